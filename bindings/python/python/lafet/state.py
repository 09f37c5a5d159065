"""The state of a monitor (document, section 3.3)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from ._native import Answer
from ._texts import say
from .errors import Error

__all__ = ["Hotbed", "Limits", "Status", "Subsystem", "arcmin", "degrees"]


def arcmin(degrees: float) -> int:
    """Degrees in the units of the protocol."""
    return round(degrees * 60)


def degrees(arcmin: float) -> float:
    """Arc-minutes of the protocol in degrees."""
    return arcmin / 60


class Limits(NamedTuple):
    """Limits of a drive, in arc-minutes; mm of the nozzle (section 3.7)."""

    low: int
    high: int


class Hotbed(NamedTuple):
    """A place of fire that the detector found, in arc-minutes (section 3.21)."""

    left: int
    right: int
    bottom: int
    top: int
    brightness: int


class Subsystem(Mapping[str, int]):
    """The state of a subsystem: its fields by name, in the units of the protocol, and its flags."""

    __slots__ = ("_fields", "bits", "flags", "name")

    def __init__(self, answer: Answer) -> None:
        self.name = answer.subsystem
        self.bits = answer.bits or 0
        self.flags = frozenset(answer.flags)
        self._fields = {name: value for name, value in answer.fields() if name != "flags"}

    def __getitem__(self, field: str) -> int:
        return self._fields[field]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __repr__(self) -> str:
        fields = " ".join(f"{name}={value}" for name, value in self._fields.items())
        return f"<{self.name} {fields} {' '.join(sorted(self.flags))}>"


class Status(Mapping[str, Subsystem]):
    """The state of a monitor: that of each subsystem that it has, by name.

    What is asked of a subsystem that the monitor does not have is an error.
    """

    __slots__ = ("_all", "_silent")

    def __init__(self, answers: list[Answer]) -> None:
        self._all = {it.subsystem: Subsystem(it) for it in answers if it.accepted and it.bits is not None}
        self._silent = {it.subsystem for it in answers} - set(self._all)

    def _of(self, *names: str) -> list[Subsystem]:
        """Those that the monitor has. One that does not say its state is no safe one."""
        for name in names:
            if name in self._silent:
                raise Error(say("no-state", subsystem=name))
        return [self._all[name] for name in names if name in self._all]

    def __getitem__(self, name: str) -> Subsystem:
        try:
            return self._all[name]
        except KeyError:
            raise KeyError(say("not-here", name=name, all=", ".join(self._all))) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __repr__(self) -> str:
        return f"<Status {' '.join(repr(it) for it in self._all.values())}>"

    @property
    def azimuth(self) -> float:
        """Where the barrel points, degrees; positive is left."""
        return degrees(self["Horizontal"]["position"])

    @property
    def elevation(self) -> float:
        """Elevation of the barrel, degrees; positive is up."""
        return degrees(self["Vertical"]["position"])

    @property
    def moving(self) -> bool:
        """Whether anything turns, deploys, opens or closes, or a program runs."""
        return any(not _MOVING.isdisjoint(it.flags) for it in self._of(*_MOVE))

    @property
    def deployed(self) -> bool:
        """Whether the monitor is in its working position. One without a deployer always is."""
        return all("Deployed" in deployer.flags for deployer in self._of("Deployer"))

    @property
    def open(self) -> bool:
        """Whether a valve is not closed: water may flow."""
        return any("Closed" not in valve.flags for valve in self._of("Valve1", "Valve2"))


_MOVE = ("Vertical", "Horizontal", "Nozzle", "Valve1", "Valve2", "Control", "Detector", "Deployer")
_MOVING = frozenset(
    (
        "Closing",
        "Deploying",
        "Justifying",
        "Move",
        "Opening",
        "Quench",
        "Searching",
        "Trajectory",
        "Wrapping",
    )
)


def limits(answers: list[Answer]) -> Limits:
    """Limits of the answer to section 3.7."""
    fields = dict(answers[0].fields())
    try:
        return Limits(fields["min"], fields["max"])
    except KeyError:
        raise Error(say("limits-fields", all=", ".join(fields))) from None


def hotbeds(values: list[int]) -> list[Hotbed]:
    """Hotbeds in the values of the parameter (section 3.21)."""
    return [Hotbed(*values[at : at + 5]) for at in range(0, len(values) - 4, 5)]
