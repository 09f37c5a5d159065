"""What the monitor with asyncio and the one without have in common: requests, what ends them, arrival."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

from . import _native
from ._native import Request
from ._texts import say
from .errors import NotReached, NotSent
from .state import Status, arcmin, degrees

Drive = Literal["Horizontal", "Vertical", "Nozzle"]
Valve = Literal["Valve1", "Valve2"]
Direction = Literal["left", "right", "up", "down", "narrow", "wide"]
Point = tuple[float, float]

#: Pause between two reads of the state while something is waited for, s.
POLL_S = 0.1
#: A drive that is this near has arrived: arc-minutes, mm.
NEAR = 6
#: A Stop that a program refuses is tried again so often: the program may be one that ends just now.
REFUSED_MAX = 5
#: For how long a monitor that does not answer is tried when something that was started has to end, s.
REACH_S = 30.0
#: Drive and whether positions grow.
DIRECTIONS: dict[Direction, tuple[Drive, bool]] = {
    "left": ("Horizontal", True),
    "right": ("Horizontal", False),
    "up": ("Vertical", True),
    "down": ("Vertical", False),
    "narrow": ("Nozzle", True),
    "wide": ("Nozzle", False),
}

#: What ends what a request has started. A valve is closed: Stop would leave it half open (section 3.2). A
#: program deploys first if it must, and then only the deployment can be stopped.
_ENDS: dict[str, Callable[[str], list[Request]]] = {
    "Deploy": lambda to: [Request.stop("Deployer")],
    "Move": lambda to: [Request.stop(to)],
    "Open": lambda to: [Request.close(to)],
    "StartJustify": lambda to: [Request.stop(to), Request.stop("Deployer")],
    "StartQuench": lambda to: [Request.stop(to), Request.stop("Deployer")],
    "StartSeek": lambda to: [Request.stop(to), Request.stop("Deployer")],
    "StartTrajectory": lambda to: [Request.stop(to), Request.stop("Deployer")],
    "Wrap": lambda to: [Request.stop("Deployer")],
}
Key = tuple[str, str]
#: What has to end, the number of its latest claim, and what ends it.
End = tuple[Key, int, Request]

#: Held while what was started is looked at or changed. A signal handler, or a generator that is collected,
#: may come in the middle of that and end everything: so it may be taken again, and each step looks again.
LOCK = threading.RLock()


class Claim(NamedTuple):
    """That something may have been started: what ends it, and which of that only this claim asks for."""

    number: int
    keys: list[Key]
    new: list[Key]


class Started:
    """What was started, and so has to end when its program does. For several threads, tasks and handlers:
    what one of them knows to have ended may be started again by another, so claims have numbers."""

    #: Set when the program ends: nothing is started any more.
    ending = False

    def __init__(self) -> None:
        self._ends: dict[Key, tuple[int, Request]] = {}
        #: Claims whose requests have no outcome, by number, each with the thread that waits for it: what they
        #: start may start after what ends it.
        self._under_way: dict[int, tuple[list[Key], int]] = {}
        self._number = 0
        #: Set when the block is left: nothing is started over this connection any more.
        self.left = False

    def claim(self, ends: Iterable[Request]) -> Claim:
        """Before something is started that these end: whether it is executed may never be known."""
        by_key = {(end.name, end.to): end for end in ends}
        with LOCK:
            if by_key and Started.ending:
                raise NotSent(say("ending"))
            if by_key and self.left:
                raise RuntimeError(say("left"))
            new = [key for key in by_key if key not in self._ends]
            self._number += 1
            self._ends.update({key: (self._number, end) for key, end in by_key.items()})
            if by_key:
                self._under_way[self._number] = (list(by_key), threading.get_ident())
            return Claim(self._number, list(by_key), new)

    def settled(self, claim: Claim) -> None:
        """The outcome of its request is known, or it is not sent any more."""
        with LOCK:
            self._under_way.pop(claim.number, None)

    def under_way(self, key: Key) -> set[int]:
        """The threads that wait for the outcome of what this has to end."""
        with LOCK:
            return {thread for keys, thread in self._under_way.values() if key in keys}

    def refused(self, claim: Claim) -> None:
        """It was not executed; what another has claimed since stays."""
        with LOCK:
            for key in claim.new:
                end = self._ends.get(key)
                if end is not None and end[0] == claim.number:
                    self._ends.pop(key, None)

    def ended(self, keys: Iterable[Key], number: int) -> bool:
        """What was claimed up to this number has ended; false when something was claimed since, or may
        start only now."""
        with LOCK:
            later = False
            for key in keys:
                end = self._ends.get(key)
                if end is not None and end[0] <= number and not self.under_way(key):
                    self._ends.pop(key, None)
                elif end is not None:
                    later = True
            return not later

    def number(self) -> int:
        """That of the latest claim."""
        return self._number

    def ends(self) -> list[End]:
        """What has to end: see `rank` for the order."""
        with LOCK:
            every = list(self._ends.items())
        return [(key, number, end) for key, (number, end) in every]

    def __bool__(self) -> bool:
        return bool(self._ends)


def ends_of(request: Request) -> list[Request]:
    """What ends what a request starts."""
    make = _ENDS.get(request.name)
    return [] if make is None else make(request.to)


def rank(end: End) -> int:
    """Water first, then the programs: while one runs, it refuses that its drives are stopped."""
    request = end[2]
    if request.name == "Close":
        return 0
    return 1 if request.to in ("Control", "Detector") else 2


def direction(toward: Direction) -> tuple[Drive, bool]:
    try:
        return DIRECTIONS[toward]
    except KeyError:
        raise ValueError(say("direction", name=toward, all=", ".join(DIRECTIONS))) from None


def point(place: Point) -> tuple[int, int]:
    return arcmin(place[0]), arcmin(place[1])


def quench(
    centre: Point,
    size: Point,
    nozzle: int,
    step: int,
    distance: int | None,
    corrections: Iterable[int] | None,
) -> Request:
    if (distance is None) == (corrections is None):
        raise ValueError(say("either"))
    if corrections is not None:
        return Request.quench_corrected(point(centre), point(size), nozzle, step, list(corrections))
    assert distance is not None
    return Request.quench(point(centre), point(size), nozzle, step, distance)


def trajectory(points: Iterable[tuple[float, float, int, float]], ballistics: bool, repeat: bool) -> Request:
    wire = [(arcmin(az), arcmin(el), metres, round(dwell * 10)) for az, el, metres, dwell in points]
    return Request.trajectory(wire, ballistics, repeat)


Progress = Callable[[Status], bool]


class Arrival:
    """Whether drives have arrived. One that has stopped elsewhere will not: that is an error."""

    #: So many states at rest in a row are no pause before the motion.
    AT_REST = 5

    def __init__(self, targets: dict[Drive, int]) -> None:
        self._targets = targets
        self._at_rest = 0

    def __call__(self, status: Status) -> bool:
        off = {
            drive: target
            for drive, target in self._targets.items()
            if abs(status[drive]["position"] - target) > NEAR or "Move" in status[drive].flags
        }
        if not off:
            return True
        moves = any("Move" in status[drive].flags for drive in off)
        self._at_rest = 0 if moves else self._at_rest + 1
        if self._at_rest >= self.AT_REST:
            raise NotReached("; ".join(self._text(status, drive) for drive in off))
        return False

    def _text(self, status: Status, drive: Drive) -> str:
        at, target = status[drive]["position"], self._targets[drive]
        flags = ", ".join(sorted(status[drive].flags)) or "none"
        shown = {"at": _shown(drive, at), "target": _shown(drive, target)}
        return say("at-rest", drive=drive, flags=flags, **shown)


def _shown(drive: Drive, position: int) -> str:
    return f"{position} mm" if drive == "Nozzle" else f"{degrees(position):.1f}°"


def late(status: Status | None, seconds: float, what: str) -> NotReached:
    return NotReached(say("late", what=what, seconds=seconds, state=status))


def no_end(error: Exception) -> NotReached:
    return NotReached(say("no-end", seconds=REACH_S, error=error))


def ended(drive: Drive, how: str) -> str:
    """How a held motion ended; an error when the drive may be moving, or never did."""
    if how == "unknown":
        raise NotReached(say("no-rest", drive=drive, seconds=REACH_S))
    if how == "still moving":
        raise NotReached(say("still-moving", drive=drive))
    if how == "not started":
        raise NotSent(say("no-hold", drive=drive))
    return how


def parsed(request: Request | str) -> Request:
    return _native.Request.parse(request) if isinstance(request, str) else request
