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
    "no-rest": (
        "whether {drive} is at rest is not known after {seconds} s, it may still move; Stop is still being sent",
        "остановился ли {drive}, за {seconds} с узнать не удалось, возможно, он движется; Stop отправляется дальше",
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
    "started-again": (
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
    "fork": (
        "this connection belongs to process {process}, and this is a fork of that: connect again here",
        "это соединение принадлежит процессу {process}, а это процесс, порождённый от него (fork): подключитесь здесь снова",
    ),
    "fork-of-simulator": (
        "this simulator belongs to process {process}, and this is a fork of that: start one here",
        "этот имитатор принадлежит процессу {process}, а это процесс, порождённый от него (fork): запустите имитатор здесь",
    ),
    "no-thread": (
        "cannot start a thread: {error}",
        "не удалось запустить поток: {error}",
    ),
    "released": (
        "the motion was released already",
        "движение уже отпущено",
    ),
    "operation-started": (
        "this operation was started already",
        "эта операция уже начата",
    ),
    "operation-lost": (
        "the operation was lost",
        "операция потеряна",
    ),
    "time": (
        "a time of {time} s: more than 0 and at most {longest}",
        "время {time} с: должно быть больше 0 и не больше {longest}",
    ),
    "not-a-drive": (
        "no drive '{name}': Horizontal, Vertical, Nozzle",
        "нет привода '{name}': Horizontal, Vertical, Nozzle",
    ),
    "no-subsystem": (
        "no subsystem '{name}': All, Motors, {all}",
        "нет подсистемы '{name}': All, Motors, {all}",
    ),
    "not-here": (
        "no {name}: this monitor has {all}",
        "нет {name}: у этого ствола есть {all}",
    ),
    "limits-state": (
        "limits '{state}': 'off', 'on' or 'reject'",
        "пределы '{state}': 'off', 'on' или 'reject'",
    ),
    "limits-fields": (
        "limits with the fields {all}",
        "пределы с полями {all}",
    ),
    "frame-too-long": (
        "{size} bytes of requests: a frame takes {most}",
        "{size} байт запросов: в кадр помещается {most}",
    ),
    "language": (
        "language '{language}': 'en' or 'ru'",
        "язык '{language}': 'en' или 'ru'",
    ),
    "direction": (
        "direction '{name}': {all}",
        "направление '{name}': {all}",
    ),
    "either": (
        "either the distance to the fire or corrections of the elevation",
        "нужно либо расстояние до очага загорания, либо поправки угла возвышения",
    ),
    "no-profile": (
        "no profile '{name}'",
        "нет исполнения '{name}'",
    ),
    "address": (
        "address {address}: 1 to 127",
        "адрес {address}: от 1 до 127",
    ),
    "wind": (
        "wind of {speed} m/s: less than {most}",
        "ветер {speed} м/с: должен быть меньше {most}",
    ),
    "skip": (
        "a time of {seconds} s to skip: 0 to {most}",
        "пропустить {seconds} с нельзя: от 0 до {most}",
    ),
    "no-fault": (
        "no fault '{name}': Simulator.faults() names them",
        "нет неисправности '{name}': их называет Simulator.faults()",
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
