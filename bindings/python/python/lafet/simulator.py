"""A simulated monitor inside this process."""

from __future__ import annotations

from types import TracebackType

from . import _native, monitor

__all__ = ["Simulator"]


class Simulator(_native.Simulator):
    """The program of a monitor in a simulated world, in real time, at a port of the loopback interface.

    `profile` names what it is built of, as `lafet sim --profile` does. A fire is written as for `lafet sim`:
    `az=30,range=25`, and `size`, `growth`, `class=hydrocarbon`. `wind` is forward and left, m/s. What it
    knows of the world (`position`, `flow`, `burning`, `deployed`) is the truth, not what a sensor says.
    """

    def __enter__(self) -> Simulator:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def connect(self, *, timeout: float | None = None) -> monitor.Monitor:
        """A client of it."""
        return monitor.connect(self.url, timeout=timeout)
