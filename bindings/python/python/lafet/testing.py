"""pytest fixtures; pytest finds them by itself once lafet is installed.

    def test_it_turns(monitor, simulator):
        monitor.deploy(wait=60)
        monitor.aim(azimuth=10, wait=20)
        assert abs(simulator.position("Horizontal") - 600) < 6
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from .monitor import Monitor
from .simulator import Simulator

__all__ = ["monitor", "simulator"]


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    """A simulated monitor of its own for each test."""
    with Simulator() as running:
        yield running


@pytest.fixture
def monitor(simulator: Simulator) -> Iterator[Monitor]:
    """A client of the simulated monitor."""
    with simulator.connect() as connected:
        yield connected
