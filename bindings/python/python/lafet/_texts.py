"""What the package itself has to say, in the language that was chosen; the client's own messages come so."""

from __future__ import annotations

from . import _native

_TEXTS = {
    "late": (
        "not {what} within {seconds} s; last state: {state}",
        "{what}: не наступило за {seconds} с; последнее состояние: {state}",
    ),
    "at-rest": (
        "{drive} is at rest at {at}, not at {target}; flags: {flags}",
        "{drive} стоит на {at}, а не на {target}; флаги: {flags}",
    ),
    "no-end": (
        "whether everything has stopped is not known after {seconds} s, it may still move or flow: {error}",
        "остановлено ли всё, за {seconds} с узнать не удалось; ствол, возможно, движется или подаёт воду: {error}",
    ),
    "still-moving": (
        "{drive} answers, but does not stop: use the emergency stop",
        "{drive} отвечает, но не останавливается: нажмите аварийный останов",
    ),
    "no-hold": (
        "{drive} does not move: its limits are off, and nothing in the monitor would end the motion if this "
        "program did not",
        "{drive} не движется: пределы выключены, и ничто в стволе не прекратило бы движение вместо программы",
    ),
    "no-state": (
        "{subsystem} does not say its state",
        "{subsystem} не сообщает своё состояние",
    ),
    "started-anew": (
        "another part of this program starts again what is being ended",
        "другая часть программы снова начинает то, что прекращается",
    ),
    "left": (
        "the block of this monitor was left, and its connection closed: connect again",
        "блок этого ствола кончился, соединение закрыто: подключитесь снова",
    ),
    "ending": (
        "not sent: this program is ending, and so is what it has started",
        "не отправлено: программа завершается и прекращает начатое",
    ),
}
_language = 0


def set_language(language: str) -> None:
    """The language of messages: 'en' or 'ru'."""
    global _language
    _native.set_language(language)
    _language = ("en", "ru").index(language)


def say(key: str, **values: object) -> str:
    return _TEXTS[key][_language].format(**values)
