"""Robotic fire monitors from Python.

    import lafet

    with lafet.connect("tcp://192.168.1.50?addr=1") as monitor:
        monitor.deploy(wait=60)
        monitor.aim(azimuth=20, elevation=10, wait=30)
        monitor.open(wait=10)

`lafet.aio` has the same for asyncio, `lafet.Simulator` is a monitor to try it on, and `lafet.testing` has
pytest fixtures. `lafet.codec` has the bytes.
"""

from __future__ import annotations

from . import _fork, aio, codec, errors
from ._native import Answer, Request
from ._texts import set_language
from .errors import (
    Error,
    LinkLost,
    NoAnswer,
    NotReached,
    NotSent,
    OutcomeUnknown,
    ProtocolError,
    Refused,
    UsageError,
)
from .monitor import Hold, Monitor, connect
from .simulator import Simulator
from .state import Hotbed, Limits, Status, Subsystem

__all__ = [
    "Answer",
    "Error",
    "Hold",
    "Hotbed",
    "Limits",
    "LinkLost",
    "Monitor",
    "NoAnswer",
    "NotReached",
    "NotSent",
    "OutcomeUnknown",
    "ProtocolError",
    "Refused",
    "Request",
    "Simulator",
    "Status",
    "Subsystem",
    "UsageError",
    "aio",
    "codec",
    "connect",
    "errors",
    "set_language",
]
