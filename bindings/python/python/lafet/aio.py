"""The same for asyncio. To cancel a task that waits for the monitor ends what was started with its block."""

from __future__ import annotations

import asyncio
from types import TracebackType
from typing import TypeVar

from . import _common, _native
from ._common import Direction
from ._core import Core, HoldCore
from ._native import Operation
from .errors import Refused
from .monitor import end_at_once, raise_unless_worse

__all__ = ["Hold", "Monitor", "connect"]

_T = TypeVar("_T")


async def connect(url: str, *, timeout: float | None = None) -> Monitor:
    """Connects: see `lafet.connect`. Use the result in an `async with` block."""
    return Monitor(await _native.connect(url, timeout).start())


class Monitor(Core):
    """A monitor: see `lafet.Monitor`."""

    async def __aenter__(self) -> Monitor:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.forbid()
        if not _runs():
            # A coroutine that is thrown away after its event loop has ended cannot wait.
            end_at_once(self)
            self.leave()
            return
        ending = asyncio.ensure_future(self.end())
        cancelled: asyncio.CancelledError | None = None
        while not ending.done():
            # To be cancelled once more does not leave it moving.
            try:
                await asyncio.wait([ending])
            except asyncio.CancelledError as again:
                cancelled = again
        self.leave()
        # Cancelled itself when the event loop ends: what is left is ended at the end of the program.
        failure = None if ending.cancelled() else ending.exception()
        if isinstance(failure, Exception):
            raise_unless_worse(failure, cancelled or error)
        if cancelled is not None:
            raise cancelled

    def at(self, address: int) -> Monitor:
        """Another monitor on the same line. What it has started ends with this one's block at the latest."""
        return Monitor(self.link.at(address), line=self._line)

    def hold(self, toward: Direction, *, lease: float = 0.3) -> Hold:
        """A motion that lasts while it is renewed, for an `async with` block."""
        drive, grows = _common.direction(toward)
        return Hold(self, drive, self.link.hold(drive, grows, lease))

    async def _run(self, operation: Operation[_T]) -> _T:
        return await operation.start()

    async def _sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)


class Hold(HoldCore):
    """A motion that lasts while it is renewed: see `lafet.Hold`."""

    async def __aenter__(self) -> Hold:
        self._begins()
        try:
            self._hold = await self._begin.start()
        except Exception:
            self._never_moved()
            raise
        finally:
            self._has_begun()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._hold is None:
            return
        try:
            self._has_ended(await self._hold.release(_common.REACH_S).start())
        except Refused as failure:
            self._never_moved()
            raise_unless_worse(failure, error)
        except Exception as failure:
            raise_unless_worse(failure, error)

    async def keep(self, seconds: float) -> bool:
        """Renews the motion for so long; false when it ended before."""
        clock = asyncio.get_running_loop().time
        deadline = clock() + seconds
        while self.renew():
            left = deadline - clock()
            if left <= 0:
                return True
            await asyncio.sleep(min(left, 0.05))
        return False


def _runs() -> bool:
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True
