"""What a monitor does, once for programs with asyncio and without."""

from __future__ import annotations

import os
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable
from typing import TypeVar
from weakref import WeakSet

from . import _common, _native, state
from ._common import LOCK, Claim, Drive, Point, Progress, Started, Valve
from ._native import Answer, Link, Operation, Request
from ._texts import say
from .errors import Error, NotReached, NotSent, Refused
from .state import Hotbed, Limits, Status, arcmin

_T = TypeVar("_T")


#: Monitors with something that has to end, so that the end of the program can see to it.
live: set[Core] = set()


class Line:
    """Those that came from the first monitor of a line by `at`, and whether its block is being left."""

    def __init__(self) -> None:
        self.cores: WeakSet[Core] = WeakSet()
        self.left = False


class Core(ABC):
    """The requests of a monitor, whatever waits for them."""

    def __init__(self, link: Link, started: Started | None = None, line: Line | None = None) -> None:
        self._link: Link | None = link
        self._endpoint = link.endpoint
        self._started = Started() if started is None else started
        #: A fork does not end what its parent has started.
        self.process = os.getpid()
        #: That of the first, for all that came from it.
        self._line = Line() if line is None else line
        self._is_first = line is None
        if line is not None:
            with LOCK:
                # One that comes while the block is being left starts nothing either.
                self._started.left = line.left
                line.cores.add(self)

    def __repr__(self) -> str:
        return f"<Monitor {self._endpoint}>"

    @property
    def link(self) -> Link:
        if self._link is None:
            raise RuntimeError(say("left"))
        return self._link

    def forbid(self) -> None:
        """The block is being left: other threads and tasks start nothing any more."""
        with LOCK:
            if self._is_first:
                self._line.left = True
            for core in self.block():
                core._started.left = True

    def leave(self) -> None:
        """Closes the connection, unless something is left to be ended over it."""
        for core in self.block():
            if not core._started:
                core._link = None

    def block(self) -> list[Core]:
        """Those that end with this one's block: of the first of a line, all that came from it by `at`."""
        with LOCK:
            return [self, *self._line.cores] if self._is_first else [self]

    def _ends(self) -> list[tuple[Core, _common.End]]:
        ends = [(core, end) for core in self.block() for end in core._started.ends()]
        return sorted(ends, key=lambda it: _common.rank(it[1]))

    @abstractmethod
    async def _run(self, operation: Operation[_T]) -> _T: ...

    @abstractmethod
    async def _sleep(self, seconds: float) -> None: ...

    async def end(self) -> None:
        """Ends what was started, and says when that could not be done. A line that is cut, or a valve that
        refuses, is tried again for half a minute."""
        deadline = time.monotonic() + _common.REACH_S
        refused: Counter[tuple[Core, _common.Key]] = Counter()
        #: What stays noted: a start of it that is under way cannot come to its outcome before this returns.
        held_up: set[tuple[Core, _common.Key, int]] = set()
        failed: Error | None = None
        while ends := [it for it in self._ends() if (it[0], it[1][0], it[1][1]) not in held_up]:
            if time.monotonic() > deadline:
                # What is left stays noted: another call, or the end of the program, tries it again.
                failed = failed or NotReached(say("started-again"))
                raise _common.no_end(failed) from failed
            if failed is not None:
                await self._sleep(_common.POLL_S)
            failed = None
            for core, end in ends:
                # Whatever becomes of one, the others are tried.
                error = await self._end_one(core, end, refused)
                key, number, _ = end
                if error is None and not core._ended([key], number):
                    threads = core._started.under_way(key)
                    if threads and all(self._holds_up(thread) for thread in threads):
                        held_up.add((core, key, number))
                    else:
                        error = NotReached(say("started-again"))
                failed = failed or error

    async def _end_one(
        self, core: Core, end: _common.End, refused: Counter[tuple[Core, _common.Key]]
    ) -> Error | None:
        """Sends what ends it; why that was in vain."""
        key, _, request = end
        try:
            await self._run(core.link.command(request))
        except Refused as error:
            refused[core, key] += error.status != "Busy"
            # A program that moves a drive refuses in its name: if it is not one that ends just now, another
            # client has started it.
            if error.by == error.to or refused[core, key] < _common.REFUSED_MAX:
                return error
        except Error as error:
            return error
        return None

    def _holds_up(self, thread: int) -> bool:
        """Whether that thread does nothing else before this end has returned."""
        return False

    def _claim(self, ends: Iterable[Request]) -> Claim:
        """Before something is started that these end."""
        with LOCK:
            claim = self._started.claim(ends)
            if self._started:
                live.add(self)
        return claim

    def _settled(self, claim: Claim) -> None:
        """The outcome of what was claimed is known, or it is not sent any more."""
        self._started.settled(claim)

    def _refused(self, claim: Claim) -> None:
        """What was claimed was not executed."""
        with LOCK:
            self._started.refused(claim)
            self.rest()

    def _ended(self, keys: Iterable[_common.Key], number: int) -> bool:
        with LOCK:
            ended = self._started.ended(keys, number)
            self.rest()
        return ended

    def _seen_to_end(self, claim: Claim) -> None:
        """What was claimed has ended."""
        self._ended(claim.keys, claim.number)

    def rest(self) -> None:
        """Nothing has to be ended at the end of the program, if nothing is left."""
        with LOCK:
            if not self._started:
                live.discard(self)

    # What it is asked.

    async def status(self) -> Status:
        """The state of all subsystems (section 3.3)."""
        answers = await self._run(self.link.send(Request.get_status("All")))
        if len(answers) == 1 and not answers[0].accepted:
            # General refuses for all.
            answers = await self._ask(Request.get_status("All"))
        return Status(answers)

    async def wait_for(self, condition: Progress, timeout: float, *, poll: float = _common.POLL_S) -> Status:
        """Reads the state until the condition is true; `NotReached` after the time, s."""
        deadline = time.monotonic() + timeout
        while True:
            status = await self.status()
            if condition(status):
                return status
            # Written so that a time that is no number has passed.
            if not time.monotonic() <= deadline:
                raise _common.late(status, timeout, getattr(condition, "__name__", "as asked"))
            await self._sleep(poll)

    async def limits(self, drive: Drive) -> Limits:
        """The limits of a drive, arc-minutes or mm (section 3.7)."""
        return state.limits(await self._ask(Request.get_limits(drive)))

    async def param(self, whose: str, name: str) -> list[int]:
        """The values of a parameter (section 3.4)."""
        return await self._run(self.link.param(whose, name))

    async def hotbeds(self) -> list[Hotbed]:
        """The places of fire that the detector found (section 3.21)."""
        return state.hotbeds(await self.param("Detector", "Hotbeds"))

    async def crash_data(self) -> dict[str, int]:
        """Registers saved at the last fault of the program (section 3.20)."""
        return dict((await self._ask(Request.get_crash_data()))[0].fields())

    async def send(self, request: Request | str) -> list[Answer]:
        """Any request, also in the words of `lafet send`; returns what is answered, refusals too."""
        asked = _common.parsed(request)
        claim = self._claim(_common.ends_of(asked))
        try:
            answers = await self._run(self.link.send(asked))
        except NotSent:
            self._refused(claim)
            raise
        finally:
            self._settled(claim)
        if not any(answer.accepted for answer in answers):
            self._refused(claim)
        return answers

    # What it is to do.

    async def stop(self, whose: str = "All") -> None:
        """Stops drives and programs (section 3.2). A valve that is moving stays where it is: `close`."""
        await self._ask(Request.stop(whose))

    async def lockout(self, on: bool = True) -> None:
        """Stops everything, closes the valves and refuses every motion until it is off (section 3.18)."""
        await self._ask(Request.lockout(on))

    async def deploy(self, *, wait: float | None = None) -> None:
        """Into the working position (section 3.10); `wait`: until it is there, at most so many s."""
        claim = await self._do(Request.deploy())
        await self._await(lambda status: status.deployed, wait, "deployed")
        if wait is not None:
            self._seen_to_end(claim)

    async def wrap(self, *, wait: float | None = None) -> None:
        """Into the stowed position (section 3.11)."""
        claim = await self._do(Request.wrap())
        await self._await(lambda status: "Wrapped" in status["Deployer"].flags, wait, "wrapped")
        if wait is not None:
            self._seen_to_end(claim)

    async def aim(
        self,
        azimuth: float | None = None,
        elevation: float | None = None,
        *,
        wait: float | None = None,
    ) -> None:
        """Turns the barrel, degrees (section 3.1)."""
        targets: dict[Drive, int] = {}
        if azimuth is not None:
            targets["Horizontal"] = arcmin(azimuth)
        if elevation is not None:
            targets["Vertical"] = arcmin(elevation)
        await self._move(targets, wait)

    async def spray(self, nozzle: int, *, wait: float | None = None) -> None:
        """Moves the nozzle, mm: from a wide spray to a narrow jet."""
        await self._move({"Nozzle": nozzle}, wait)

    async def open(self, valve: Valve = "Valve1", *, wait: float | None = None) -> None:
        """Opens a valve (section 3.8)."""
        await self._do(Request.open(valve))
        await self._await(lambda status: "Open" in status[valve].flags, wait, "open")

    async def close(self, valve: Valve = "Valve1", *, wait: float | None = None) -> None:
        """Closes a valve (section 3.9)."""
        number = self._started.number()
        await self._do(Request.close(valve))
        await self._await(lambda status: "Closed" in status[valve].flags, wait, "closed")
        if wait is not None:
            self._ended([("Close", valve)], number)

    async def quench(
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
        await self._do(_common.quench(centre, size, nozzle, step, distance, corrections))

    async def quench_program(self, program: int, centre: Point = (0.0, 0.0), *, nozzle: int = 60) -> None:
        """Extinguishes by a stored program, moved to a centre (section 3.14)."""
        await self._do(Request.quench_program(program, _common.point(centre), nozzle))

    async def follow(
        self,
        points: Iterable[tuple[float, float, int, float]],
        *,
        ballistics: bool = True,
        repeat: bool = False,
    ) -> None:
        """Extinguishes along points: azimuth and elevation in degrees, distance in m, time to stay in s
        (section 3.15)."""
        await self._do(_common.trajectory(points, ballistics, repeat))

    async def seek(self, horizontal: Point, vertical: Point, *, analyse: bool = False) -> None:
        """Searches a sector for fire: from and to, degrees (section 3.16)."""
        await self._do(Request.seek(_common.point(horizontal), _common.point(vertical), analyse))

    async def justify(self) -> None:
        """Aligns detector and barrel (section 3.13)."""
        await self._do(Request.justify())

    # How it is set up.

    async def set_param(self, whose: str, name: str, *values: int) -> None:
        """Sets a parameter (section 3.5)."""
        await self._run(self.link.set_param(whose, name, list(values)))

    async def correction_table(self, first: int, corrections: Iterable[int]) -> None:
        """Stores corrections of the elevation, degrees, one for each 0.1 atm (section 3.6)."""
        await self._run(self.link.correction_table(first, list(corrections)))

    async def switch_limits(self, whose: str, to: str) -> None:
        """Limits 'off', 'on', or 'reject' what was set meanwhile (section 3.17)."""
        await self._ask(Request.switch_limits(whose, to))

    async def restart(self) -> None:
        """Restarts the monitor's program (section 3.12)."""
        await self._ask(Request.restart())

    async def clean_flash(self) -> None:
        """Erases the monitor's memory: every parameter is as delivered (section 3.19)."""
        await self._ask(Request.clean_flash())

    async def _ask(self, request: Request) -> list[Answer]:
        return await self._run(self.link.command(request))

    async def _do(self, request: Request) -> Claim:
        claim = self._claim(_common.ends_of(request))
        try:
            await self._ask(request)
        except (Refused, NotSent):
            self._refused(claim)
            raise
        finally:
            self._settled(claim)
        return claim

    async def _move(self, targets: dict[Drive, int], wait: float | None) -> None:
        # All are made before one is sent: a number that does not fit moves nothing.
        requests = [Request.move_to(drive, target) for drive, target in targets.items()]
        claims = [await self._do(request) for request in requests]
        await self._await(_common.Arrival(targets), wait, "there")
        if wait is not None:
            for claim in claims:
                self._seen_to_end(claim)

    async def _await(self, condition: Progress, wait: float | None, what: str) -> None:
        if wait is None:
            return
        deadline = time.monotonic() + wait
        while not condition(status := await self.status()):
            if not time.monotonic() <= deadline:
                raise _common.late(status, wait, what)
            await self._sleep(_common.POLL_S)


class HoldCore:
    """A motion that lasts while it is renewed, whatever waits for its beginning and its end."""

    def __init__(self, core: Core, drive: Drive, begin: Operation[_native.Hold]) -> None:
        self._core = core
        self._claimed: Claim | None = None
        self._drive = drive
        self._begin = begin
        self._hold: _native.Hold | None = None
        #: How the motion ended: 'released', 'lapsed', 'link lost', 'stopped', 'at rest', 'replaced' or
        #: 'taken over'. A drive that does not stop is an error.
        self.ended: str | None = None

    def renew(self) -> bool:
        """Lets the motion go on for another lease; false when it is ending or has ended."""
        return self._hold is not None and self._hold.renew()

    def _begins(self) -> None:
        """Before it begins: the end of the monitor's block ends it too, whoever renews it."""
        self._claimed = self._core._claim([Request.stop(self._drive)])

    def _has_begun(self) -> None:
        """It has, or it could not: a Stop over the same connection ends it from now on."""
        if self._claimed is not None:
            self._core._settled(self._claimed)

    def _has_ended(self, how: str) -> None:
        try:
            self.ended = _common.ended(self._drive, how)
        except NotSent:
            self._never_moved()
            raise
        if self._claimed is not None:
            self._core._seen_to_end(self._claimed)

    def _never_moved(self) -> None:
        """It never moved."""
        if self._claimed is not None:
            self._core._refused(self._claimed)
