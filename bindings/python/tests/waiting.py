"""What the tests wait with."""

from __future__ import annotations

import time
from collections.abc import Callable


def until(so: Callable[[], bool], within: float = 10.0) -> None:
    deadline = time.monotonic() + within
    while not so():
        assert time.monotonic() < deadline, f"not within {within} s"
        time.sleep(0.02)
