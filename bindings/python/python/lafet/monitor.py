"""A monitor for programs without asyncio."""

from __future__ import annotations

import atexit
import os
import sys
import threading
import time
from collections.abc import Coroutine, Iterable
from multiprocessing import util
from types import TracebackType
from typing import Any, TypeVar

from . import _common, _native
from ._common import Direction, Drive, Point, Progress, Started, Valve
from ._core import Core, HoldCore, Line, live
from ._native import Answer, Link, Operation, Request
from .errors import Refused
from .state import Hotbed, Limits, Status

__all__ = ["Hold", "Monitor", "connect"]

_T = TypeVar("_T")


class _Waiting(Core):
    """Waits in the thread that calls."""

    async def _run(self, operation: Operation[_T]) -> _T:
        return operation.wait()

    async def _sleep(self, seconds: float) -> None:
        time.sleep(seconds)

    def _holds_up(self, thread: int) -> bool:
        # One that is interrupted by a signal, or waits for the end of the program.
        ends = Started.ending and thread == threading.main_thread().ident
        return ends or thread == threading.get_ident()


def _now(work: Coroutine[Any, Any, _T]) -> _T:
    """The result of work that waits in this thread, and so never gives way."""
    try:
        work.send(None)
    except StopIteration as end:
        result: _T = end.value
        return result
    raise RuntimeError("work that gives way cannot be waited for here")


def connect(url: str, *, timeout: float | None = None) -> Monitor:
    """Connects to the monitor at a URL, as of the command line: `tcp://192.168.1.50?addr=1`,
    `serial:///dev/ttyUSB0?baud=19200&addr=1`, `udp://…`.

    `timeout` is the time that an answer is waited for, at most 10 s. Use the result in a `with` block: what it has
    started ends with the block.
    """
    return Monitor(_native.connect(url, timeout).wait())


class Monitor:
    """A monitor. Positions are degrees, positive to the left and up; the nozzle has millimetres.

    In a `with` block whatever was started ends with the block, however that is left: drives and programs are
    stopped, valves that were opened are closed. Ctrl-C leaves it too.
    """

    def __init__(self, link: Link, line: Line | None = None) -> None:
        self._core = _Waiting(link, line=line)

    def __enter__(self) -> Monitor:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._core.forbid()
        try:
            self.end()
        except Exception as failure:
            raise_unless_worse(failure, error)
        finally:
            self._core.leave()

    def __repr__(self) -> str:
        return repr(self._core)

    def at(self, address: int) -> Monitor:
        """Another monitor on the same line. What it has started ends with this one's block at the latest."""
        return Monitor(self._core.link.at(address), self._core._line)

    def end(self) -> None:
        """Ends what was started, and says when that could not be done. A line that is cut is tried again for
        half a minute."""
        _now(self._core.end())

    def hold(self, toward: Direction, *, lease: float = 0.3) -> Hold:
        """A motion that lasts while it is renewed, for a `with` block."""
        drive, grows = _common.direction(toward)
        return Hold(self._core, drive, self._core.link.hold(drive, grows, lease))

    def status(self) -> Status:
        """The state of all subsystems (section 3.3)."""
        return _now(self._core.status())

    def wait_for(self, condition: Progress, timeout: float, *, poll: float = _common.POLL_S) -> Status:
        """Reads the state until the condition is true; `NotReached` after the time, s."""
        return _now(self._core.wait_for(condition, timeout, poll=poll))

    def limits(self, drive: Drive) -> Limits:
        """The limits of a drive, arc-minutes or mm (section 3.7)."""
        return _now(self._core.limits(drive))

    def param(self, whose: str, name: str) -> list[int]:
        """The values of a parameter (section 3.4)."""
        return _now(self._core.param(whose, name))

    def hotbeds(self) -> list[Hotbed]:
        """The places of fire that the detector found (section 3.21)."""
        return _now(self._core.hotbeds())

    def crash_data(self) -> dict[str, int]:
        """Registers saved at the last fault of the program (section 3.20)."""
        return _now(self._core.crash_data())

    def send(self, request: Request | str) -> list[Answer]:
        """Any request, also in the words of `lafet send`; returns what is answered, refusals too."""
        return _now(self._core.send(request))

    def stop(self, whose: str = "All") -> None:
        """Stops drives and programs (section 3.2). A valve that is moving stays where it is: `close`."""
        _now(self._core.stop(whose))

    def lockout(self, on: bool = True) -> None:
        """Stops everything, closes the valves and refuses every motion until it is off (section 3.18)."""
        _now(self._core.lockout(on))

    def deploy(self, *, wait: float | None = None) -> None:
        """Into the working position (section 3.10); `wait`: until it is there, at most so many s."""
        _now(self._core.deploy(wait=wait))

    def wrap(self, *, wait: float | None = None) -> None:
        """Into the stowed position (section 3.11)."""
        _now(self._core.wrap(wait=wait))

    def aim(
        self,
        azimuth: float | None = None,
        elevation: float | None = None,
        *,
        wait: float | None = None,
    ) -> None:
        """Turns the barrel, degrees (section 3.1)."""
        _now(self._core.aim(azimuth, elevation, wait=wait))

    def spray(self, nozzle: int, *, wait: float | None = None) -> None:
        """Moves the nozzle, mm: from a wide spray to a narrow jet."""
        _now(self._core.spray(nozzle, wait=wait))

    def open(self, valve: Valve = "Valve1", *, wait: float | None = None) -> None:
        """Opens a valve (section 3.8)."""
        _now(self._core.open(valve, wait=wait))

    def close(self, valve: Valve = "Valve1", *, wait: float | None = None) -> None:
        """Closes a valve (section 3.9)."""
        _now(self._core.close(valve, wait=wait))

    def quench(
        self,
        centre: Point,
        size: Point = (0.0, 0.0),
        *,
        nozzle: int = 60,
        step: int = 0,
        distance: int | None = None,
        corrections: Iterable[int] | None = None,
    ) -> None:
        """Extinguishes a sector: its centre and size in degrees, step between lines in degrees, and
        either the distance to the fire in m or corrections of the elevation (section 3.14)."""
        work = self._core.quench(
            centre, size, nozzle=nozzle, step=step, distance=distance, corrections=corrections
        )
        _now(work)

    def quench_program(self, program: int, centre: Point = (0.0, 0.0), *, nozzle: int = 60) -> None:
        """Extinguishes by a stored program, moved to a centre (section 3.14)."""
        _now(self._core.quench_program(program, centre, nozzle=nozzle))

    def follow(
        self,
        points: Iterable[tuple[float, float, int, float]],
        *,
        ballistics: bool = True,
        repeat: bool = False,
    ) -> None:
        """Extinguishes along points: azimuth and elevation in degrees, distance in m, time to stay in s
        (section 3.15)."""
        _now(self._core.follow(points, ballistics=ballistics, repeat=repeat))

    def seek(self, horizontal: Point, vertical: Point, *, analyse: bool = False) -> None:
        """Searches a sector for fire: from and to, degrees (section 3.16)."""
        _now(self._core.seek(horizontal, vertical, analyse=analyse))

    def justify(self) -> None:
        """Aligns detector and barrel (section 3.13)."""
        _now(self._core.justify())

    def set_param(self, whose: str, name: str, *values: int) -> None:
        """Sets a parameter (section 3.5)."""
        _now(self._core.set_param(whose, name, *values))

    def correction_table(self, first: int, corrections: Iterable[int]) -> None:
        """Stores corrections of the elevation, degrees, one for each 0.1 atm (section 3.6)."""
        _now(self._core.correction_table(first, corrections))

    def switch_limits(self, whose: str, to: str) -> None:
        """Limits 'off', 'on', or 'reject' what was set meanwhile (section 3.17)."""
        _now(self._core.switch_limits(whose, to))

    def restart(self) -> None:
        """Restarts the monitor's program (section 3.12)."""
        _now(self._core.restart())

    def clean_flash(self) -> None:
        """Erases the monitor's memory: every parameter is as delivered (section 3.19)."""
        _now(self._core.clean_flash())


class Hold(HoldCore):
    """A motion that lasts while it is renewed, and ends with its `with` block. It ends by itself when it is
    not renewed in time (`lease`, at most 2 s), when the connection is lost and when this program ends. A drive
    that does not answer is waited for half a minute: then `NotReached`."""

    def __enter__(self) -> Hold:
        self._begins()
        try:
            self._hold = self._begin.wait()
        except Exception:
            self._never_moved()
            raise
        finally:
            self._has_begun()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._hold is None:
            return
        try:
            self._has_ended(self._hold.release(_common.REACH_S).wait())
        except Refused as failure:
            self._never_moved()
            raise_unless_worse(failure, error)
        except Exception as failure:
            raise_unless_worse(failure, error)

    def keep(self, seconds: float) -> bool:
        """Renews the motion for so long; false when it ended before."""
        deadline = time.monotonic() + seconds
        while self.renew():
            left = deadline - time.monotonic()
            if left <= 0:
                return True
            time.sleep(min(left, 0.05))
        return False


def raise_unless_worse(failure: Exception, error: BaseException | None) -> None:
    """A failed end is an error, but Ctrl-C and a cancelled task stay what they are: then it is printed, as
    a warning may be switched off, and a program that goes on has to say that a monitor still moves."""
    if error is None or isinstance(error, Exception):
        raise failure
    print(f"lafet: {failure}", file=sys.stderr)


@atexit.register
def _end_all() -> None:
    """A program that ends in the middle ends what it has started, whether or not it uses asyncio."""
    Started.ending = True
    # Side by side: one whose line is cut takes half a minute.
    ends = []
    for core in [core for core in list(live) if core.process == os.getpid()]:
        end = threading.Thread(target=_end, args=(core,), daemon=True)
        try:
            end.start()
        except RuntimeError:
            # Some interpreters start no thread any more by now.
            _end(core)
        else:
            ends.append(end)
    for end in ends:
        end.join()


def end_at_once(core: Core) -> None:
    """Ends what was started in its block, in this thread; prints what could not be ended."""
    for one in core.block():
        if one._started:
            _end(one)


def _end(core: Core) -> None:
    try:
        _now(_Waiting(core.link, core._started).end())
        core.rest()
    except Exception as failure:
        print(f"{core!r}: {failure}", file=sys.stderr)


def _end_with_child(_: object = None) -> None:
    # A child of multiprocessing may end without atexit, and forgets what its parent has registered.
    util.Finalize(None, _end_all, exitpriority=0)


_end_with_child()
util.register_after_fork(_end_all, _end_with_child)
