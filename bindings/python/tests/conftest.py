"""Fixtures of the tests, beside those of the package."""

from __future__ import annotations

import pytest
from lafet import Monitor


@pytest.fixture
def deployed(monitor: Monitor) -> Monitor:
    monitor.deploy(wait=60)
    return monitor
