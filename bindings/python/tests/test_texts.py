"""What the package says itself: each text in both languages, and none that is missing."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import lafet
import pytest
from lafet import Monitor, Request, Simulator, _texts, codec

FOLDER = Path(__file__).parent.parent


def arguments(text: str) -> set[str]:
    return set(re.findall(r"{(\w+)}", text))


def test_each_text_has_the_same_arguments_in_both_languages() -> None:
    for key, (english, russian) in _texts._TEXTS.items():
        assert arguments(english) == arguments(russian), key
        assert re.search("[а-я]", russian), key


def test_each_text_is_said_with_its_arguments_and_none_is_left_over() -> None:
    said = set()
    for path in [*FOLDER.glob("src/*.rs"), *FOLDER.glob("python/lafet/*.py")]:
        source = path.read_text(encoding="utf-8")
        for key in re.findall(r'\bsay(?:ing)?\(\s*"([a-z-]+)"', source):
            assert key in _texts._TEXTS, f"{path.name}: {key}"
            said.add(key)
    assert said == set(_texts._TEXTS)


def test_what_is_wrong_is_said_in_the_language(monitor: Monitor, simulator: Simulator) -> None:
    operation = monitor._core.link.send(Request.get_status("All"))
    operation.wait()
    wrong: list[Callable[[], object]] = [
        operation.wait,
        lambda: lafet.connect(simulator.url, timeout=0),
        lambda: monitor.open("Valve9"),  # type: ignore[arg-type]
        lambda: monitor.hold("forward"),  # type: ignore[arg-type]
        lambda: monitor._core.link.hold("Valve1", True, 0.3),
        lambda: monitor.status()["Pump"],
        lambda: monitor.quench((0, 0)),
        lambda: monitor.switch_limits("Horizontal", "away"),
        lambda: codec.encode([Request.stop("All")] * 200),
        lambda: Simulator(address=200),
        lambda: Simulator(profile="none"),
        lambda: Simulator(wind=(100.0, 0.0)),
        lambda: simulator.skip(-1),
        lambda: simulator.inject("none"),
        lambda: simulator.position("Valve1"),
        lambda: lafet.set_language("de"),
    ]
    for language, letters in [("en", "[a-z]{3}"), ("ru", "[а-я]{3}")]:
        lafet.set_language(language)
        try:
            for number, do in enumerate(wrong):
                with pytest.raises((ValueError, RuntimeError, KeyError)) as error:
                    do()
                assert re.search(letters, str(error.value)), f"{language} {number}: {error.value}"
                assert language == "ru" or not re.search("[а-я]", str(error.value))
        finally:
            lafet.set_language("en")
