"""What ends with a block, though threads, signals and dead lines come in between."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from types import FrameType

import lafet
import pytest
from lafet import Monitor, Request, Simulator, _common
from lafet._native import Link, Operation
from waiting import until


class Late:
    """A link that sends an Open only when a test lets it."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self.endpoint = link.endpoint
        self.waits = threading.Event()
        self.go = threading.Event()

    def command(self, request: Request) -> Operation[list[lafet.Answer]]:
        if request.name == "Open":
            self.waits.set()
            assert self.go.wait(60)
        return self._link.command(request)


def test_a_start_that_is_under_way_does_not_outlive_the_block(simulator: Simulator) -> None:
    with simulator.connect() as monitor:
        monitor.deploy(wait=60)
        late = Late(monitor._core.link)
        monitor._core._link = late  # type: ignore[assignment]
        opening = threading.Thread(target=monitor.open, daemon=True)
        opening.start()
        assert late.waits.wait(10)
        threading.Timer(0.5, late.go.set).start()
    late.go.set()
    opening.join(10)
    time.sleep(0.5)
    with simulator.connect() as other:
        other.wait_for(lambda it: not it.open, 10)
    until(lambda: simulator.flow < 1)


def test_a_start_that_is_under_way_is_not_seen_to_have_ended() -> None:
    started = _common.Started()
    opening = started.claim([Request.close("Valve1")])
    assert not started.ended(opening.keys, opening.number)
    assert len(started.ends()) == 1
    started.settled(opening)
    assert started.ended(opening.keys, opening.number)
    assert started.ends() == []


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="there is no such signal here")
def test_an_end_does_not_wait_for_what_it_interrupts(deployed: Monitor) -> None:
    late = Late(deployed._core.link)
    deployed._core._link = late  # type: ignore[assignment]
    took: list[float] = []

    def end(_number: int, _frame: FrameType | None) -> None:
        begin = time.monotonic()
        deployed.end()
        took.append(time.monotonic() - begin)
        late.go.set()

    before = signal.signal(signal.SIGUSR1, end)
    try:
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGUSR1)).start()
        deployed.open()
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert len(took) == 1 and took[0] < 5
    # It was opened after that, and the end of the block closes it.
    assert ("Close", "Valve1") in [key for key, _, _ in deployed._core._started.ends()]


def test_one_that_comes_from_a_block_that_is_left_starts_nothing(simulator: Simulator) -> None:
    with lafet.connect(simulator.url.replace("addr=1", "addr=2")) as first:
        second = first.at(3)
        first._core.forbid()
        for other in [first.at(1), second.at(1)]:
            assert other.status()
            with pytest.raises(RuntimeError, match="connect again"):
                other.deploy()


def test_an_end_ends_though_more_is_started_all_the_time(
    deployed: Monitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = deployed._core.link
    others: list[Monitor] = []
    goes_on = True

    class Refilling(Late):
        def command(self, request: Request) -> Operation[list[lafet.Answer]]:
            if goes_on:
                start()
            return link.command(request)

    def start() -> None:
        other = Monitor(Refilling(link), deployed._core._line)  # type: ignore[arg-type]
        others.append(other)
        other._core._settled(other._core._claim([Request.stop("Nozzle")]))

    start()
    monkeypatch.setattr(_common, "REACH_S", 0.5)
    begin = time.monotonic()
    with pytest.raises(lafet.NotReached):
        deployed.end()
    assert time.monotonic() - begin < 20
    goes_on = False
    deployed.end()


class Cable:
    """A line to a simulator that can be cut: then connections stay, and bytes are lost."""

    def __init__(self, simulator: Simulator) -> None:
        host, port = simulator.url.removeprefix("tcp://").split("?")[0].split(":")
        self._to = (host, int(port))
        self._server = socket.create_server(("127.0.0.1", 0))
        self.is_cut = False
        self.url = f"tcp://127.0.0.1:{self._server.getsockname()[1]}?addr=1"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._server.accept()
                far = socket.create_connection(self._to)
                for one, other in [(near, far), (far, near)]:
                    threading.Thread(target=self._pass_on, args=(one, other), daemon=True).start()

    def _pass_on(self, one: socket.socket, other: socket.socket) -> None:
        with suppress(OSError):
            while data := one.recv(4096):
                if not self.is_cut:
                    other.sendall(data)
            other.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        self._server.close()


@pytest.fixture
def cable(simulator: Simulator) -> Iterator[Cable]:
    cable = Cable(simulator)
    yield cable
    cable.close()


def test_the_end_of_a_hold_on_a_dead_line_is_not_waited_for_without_end(
    cable: Cable, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    with lafet.connect(cable.url, timeout=0.2) as monitor:
        monitor.deploy(wait=60)
        monkeypatch.setattr(_common, "REACH_S", 1.0)
        begin = 0.0
        with pytest.raises(lafet.NotReached, match="Horizontal"), monitor.hold("left") as motion:
            assert motion.keep(0.5)
            cable.is_cut = True
            begin = time.monotonic()
        assert 0.9 < time.monotonic() - begin < 10
        assert [key for key, _, _ in monitor._core._started.ends()] == [("Stop", "Horizontal")]
        monkeypatch.undo()
        cable.is_cut = False
    there = simulator.position("Horizontal")
    time.sleep(0.5)
    assert abs(simulator.position("Horizontal") - there) < 2
