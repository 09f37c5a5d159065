"""What a fork of this process does with what it has of its parent: connections, and locks.

A fork has the open files of its parent. With those of a line it would keep the line, and so a Stop of another
program, from it for as long as it runs, even when its parent has been killed: they become `/dev/null`. A lock that
another thread holds would never be released there, so none is held while the process forks.
"""

from __future__ import annotations

import contextlib
import os

from . import _native
from ._common import LOCK


def _before() -> None:
    LOCK.acquire()
    _native.before_fork()


def _in_parent() -> None:
    _native.after_fork_in_parent()
    LOCK.release()


def _in_child() -> None:
    lines = set(_native.after_fork_in_child())
    LOCK.release()
    if lines:
        _give_up(lines)


def _give_up(lines: set[tuple[int, int]]) -> None:
    nothing: int | None = None
    with contextlib.suppress(OSError):
        nothing = os.open(os.devnull, os.O_RDWR)
    for number in _open_files():
        try:
            about = os.fstat(number)
        except OSError:
            continue
        if (about.st_dev, about.st_ino) not in lines:
            continue
        if nothing is None:
            os.close(number)
        else:
            os.dup2(nothing, number, inheritable=False)
    if nothing is not None:
        os.close(nothing)


def _open_files() -> list[int]:
    try:
        return [int(number) for number in os.listdir("/dev/fd")]
    except OSError:
        return list(range(3, os.sysconf("SC_OPEN_MAX")))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before, after_in_parent=_in_parent, after_in_child=_in_child)
