"""Called in the event loop when an operation has ended; the future may have been cancelled meanwhile."""

from __future__ import annotations

import asyncio
from typing import TypeVar

_T = TypeVar("_T")


def result(future: asyncio.Future[_T], value: _T) -> None:
    if not future.done():
        future.set_result(value)


def exception(future: asyncio.Future[_T], error: BaseException) -> None:
    if not future.done():
        future.set_exception(error)
