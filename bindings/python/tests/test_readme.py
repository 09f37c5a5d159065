"""The examples of both pages run as they stand, and are the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from lafet import Monitor, Simulator

FOLDER = Path(__file__).parent.parent


def examples(page: str) -> list[str]:
    return re.findall(r"```python\n(.*?)```", (FOLDER / page).read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("number", range(3))
def test_the_example_runs(number: int, monitor: Monitor, simulator: Simulator) -> None:
    names: dict[str, object] = {}
    exec(examples("README.md")[number], names)
    test = names.get("test_it_turns")
    if callable(test):
        test(monitor, simulator)


def test_both_pages_have_the_same_examples() -> None:
    assert examples("README.md") == examples("README.ru.md") and len(examples("README.md")) == 3
