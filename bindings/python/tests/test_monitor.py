"""The client against the simulated monitor: what it says, what it refuses, what ends when."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from pathlib import Path

import lafet
import pytest
from lafet import Monitor, Simulator, _common
from lafet._native import Link, Operation
from waiting import until


def test_from_the_box_to_water(monitor: Monitor, simulator: Simulator) -> None:
    assert not simulator.deployed and not monitor.status().deployed
    monitor.deploy(wait=60)
    monitor.aim(azimuth=5, elevation=4, wait=20)
    monitor.open(wait=10)
    assert simulator.deployed
    assert abs(simulator.position("Horizontal") - 300) <= 6
    assert abs(simulator.position("Vertical") - 240) <= 6
    status = monitor.wait_for(lambda it: it["General"]["flowrate"] > 5, 20)
    assert status.open and abs(status.azimuth - 5) < 0.2 and abs(status.elevation - 4) < 0.2
    assert simulator.flow > 5
    monitor.close(wait=10)
    assert not monitor.status().open
    until(lambda: simulator.flow < 1)


def test_what_was_begun_ends_with_the_block(simulator: Simulator) -> None:
    with pytest.raises(ZeroDivisionError), simulator.connect() as monitor:
        monitor.deploy(wait=60)
        monitor.open(wait=10)
        monitor.aim(azimuth=170)
        until(lambda: simulator.position("Horizontal") > 60)
        _ = 1 / 0
    with simulator.connect() as other:
        status = other.wait_for(lambda it: not it.open and not it.moving, 10)
    assert status.azimuth < 160
    until(lambda: simulator.flow < 1)


def test_ctrl_c_ends_what_was_started(simulator: Simulator) -> None:
    program = f"""
        import lafet
        with lafet.connect("{simulator.url}") as monitor:
            monitor.deploy(wait=60)
            monitor.open(wait=10)
            print("flows", flush=True)
            monitor.aim(azimuth=170, wait=60)
    """
    child = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program)],
        stdout=subprocess.PIPE,
        # What is started in the background of a script inherits that the signal is ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert child.stdout is not None and child.stdout.readline() == b"flows\n"
    until(lambda: simulator.position("Horizontal") > 60)
    child.send_signal(signal.SIGINT)
    assert child.wait(10) != 0
    until(lambda: simulator.flow < 1)
    there = simulator.position("Horizontal")
    assert there < 170 * 60 - 600
    time.sleep(0.5)
    assert abs(simulator.position("Horizontal") - there) < 2


def test_a_program_that_ends_in_the_middle_ends_what_it_has_started(simulator: Simulator) -> None:
    program = f"""
        import lafet, sys
        def main():
            monitor = lafet.connect("{simulator.url}")
            monitor.deploy(wait=60)
            monitor.open(wait=10)
            sys.exit(3)
        main()
    """
    assert subprocess.call([sys.executable, "-c", textwrap.dedent(program)], timeout=90) == 3
    until(lambda: simulator.flow < 1)


def test_a_held_motion_ends_with_its_block_and_without_renewal(
    deployed: Monitor, simulator: Simulator
) -> None:
    with deployed.hold("left") as motion:
        assert motion.keep(0.6)
    assert motion.ended == "released"
    there = simulator.position("Horizontal")
    assert there > 60
    with deployed.hold("right") as motion:
        time.sleep(1.0)
        assert not motion.renew()
    assert motion.ended == "lapsed"
    assert simulator.position("Horizontal") < there
    with pytest.raises(ValueError, match="at most 2"), deployed.hold("right", lease=10):
        pass
    with pytest.raises(ValueError, match="left, right, up"):
        deployed.hold("forward")  # type: ignore[arg-type]


def test_a_killed_program_holds_nothing(deployed: Monitor, simulator: Simulator) -> None:
    program = f"""
        import lafet
        with lafet.connect("{simulator.url}").hold("left") as motion:
            print("moves", flush=True)
            motion.keep(60)
    """
    child = subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE)
    assert child.stdout is not None and child.stdout.readline() == b"moves\n"
    until(lambda: simulator.position("Horizontal") > 60)
    child.kill()
    child.wait()
    time.sleep(0.5)
    there = simulator.position("Horizontal")
    time.sleep(0.5)
    assert abs(simulator.position("Horizontal") - there) < 2


def test_a_program_that_keeps_the_interpreter_does_not_keep_a_motion(
    deployed: Monitor, simulator: Simulator
) -> None:
    with deployed.hold("left") as motion:
        motion.keep(0.3)
        sys.setswitchinterval(5)
        try:
            begin = time.monotonic()
            while time.monotonic() - begin < 1.2:
                pass
        finally:
            sys.setswitchinterval(0.005)
        there = simulator.position("Horizontal")
        time.sleep(0.3)
        assert abs(simulator.position("Horizontal") - there) < 2
    assert motion.ended == "lapsed"


def test_a_refusal_names_its_reason(monitor: Monitor) -> None:
    with pytest.raises(lafet.Refused, match="deploy") as refused:
        monitor.open()
    error = refused.value
    assert (error.request, error.to, error.status) == ("Open", "Valve1", "Denied")
    assert pickle.loads(pickle.dumps(error)).by == error.by
    monitor.lockout()
    with pytest.raises(lafet.Refused, match="(?i)lockout"):
        monitor.deploy()
    monitor.lockout(False)
    lafet.set_language("ru")
    try:
        with pytest.raises(lafet.Refused, match="разв"):
            monitor.open()
    finally:
        lafet.set_language("en")
    with pytest.raises(ValueError, match="en. or .ru"):
        lafet.set_language("de")


def test_a_broken_drive_is_an_error_and_not_a_wait(deployed: Monitor, simulator: Simulator) -> None:
    jammed = next(name for name in Simulator.faults() if "horizontal" in name and "jam" in name)
    assert simulator.inject(jammed) == [jammed]
    with pytest.raises((lafet.NotReached, lafet.Refused)):
        deployed.aim(azimuth=30, wait=60)
    assert simulator.repair(jammed) == []


def test_what_does_not_come_in_time(monitor: Monitor) -> None:
    with pytest.raises(lafet.NotReached, match="not deployed within 0.2 s"):
        monitor.deploy(wait=0.2)
    with pytest.raises(TimeoutError):
        monitor.wait_for(lambda it: False, 0.2)


def test_wrong_usage_is_named(monitor: Monitor) -> None:
    for wrong in ["", "tcp://", "http://127.0.0.1:1", "tcp://127.0.0.1:1?addr=300"]:
        with pytest.raises(lafet.UsageError):
            lafet.connect(wrong)
    with pytest.raises(ValueError, match="did you mean|Valve1"):
        monitor.send("Opn Valve1")
    with pytest.raises(ValueError, match="no subsystem .Valve9."):
        monitor.open("Valve9")  # type: ignore[arg-type]
    with pytest.raises(OverflowError):
        monitor.spray(40_000)
    with pytest.raises(ValueError, match="either"):
        monitor.quench((0, 0))
    for time_s in [0, -1, float("nan"), float("inf")]:
        with pytest.raises(ValueError, match="more than 0"):
            lafet.connect("tcp://127.0.0.1:1", timeout=time_s)
    with pytest.raises(KeyError, match="this monitor has"):
        monitor.status()["Pump"]


def test_nobody_there() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        with pytest.raises(lafet.LinkLost):
            lafet.connect(f"tcp://127.0.0.1:{free.getsockname()[1]}")


def test_a_server_that_does_not_speak_the_protocol() -> None:
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        begin = time.monotonic()
        monitor = lafet.connect(f"tcp://127.0.0.1:{silent.getsockname()[1]}", timeout=0.2)
        with pytest.raises(lafet.NoAnswer):
            monitor.status()
        assert time.monotonic() - begin < 15


def test_parameters_limits_hotbeds(monitor: Monitor) -> None:
    assert monitor.limits("Horizontal").low < 0 < monitor.limits("Horizontal").high
    before = monitor.param("Horizontal", "Speed")
    assert before
    monitor.set_param("Horizontal", "Speed", before[0])
    assert monitor.param("Horizontal", "Speed") == before
    with pytest.raises(lafet.Refused):
        monitor.set_param("Horizontal", "Speed", -100_000)
    with pytest.raises(lafet.Refused) as unknown:
        monitor.param("Horizontal", "Sped")
    assert unknown.value.status == "InvalidId"
    assert monitor.hotbeds() == []
    assert isinstance(monitor.crash_data(), dict)


def test_a_fire_is_found_and_put_out() -> None:
    with Simulator(fires=["az=10,range=20"]) as simulator, simulator.connect() as monitor:
        monitor.deploy(wait=60)
        monitor.seek((0, 20), (-15, 5))
        monitor.wait_for(lambda it: "Searching" in it["Detector"].flags, 5)
        monitor.wait_for(lambda it: "Searching" not in it["Detector"].flags, 120)
        (found,) = monitor.hotbeds()
        assert found.right < 600 < found.left
        centre = (found.left + found.right) / 120, (found.bottom + found.top) / 120
        monitor.open()
        monitor.quench(centre, (4, 2), step=1, distance=20)
        until(lambda: simulator.burning == [False], 120)
        monitor.end()
        until(lambda: simulator.flow < 1)
        monitor.wait_for(lambda it: not it.moving, 10)


def test_a_program_that_deploys_first_ends_too(simulator: Simulator) -> None:
    with simulator.connect() as monitor:
        monitor.quench((0, 0), (20, 4), step=1, distance=20)
        monitor.wait_for(lambda it: "Deploying" in it["Deployer"].flags, 10)
    time.sleep(1.0)
    with simulator.connect() as other:
        other.wait_for(lambda it: not it.moving, 5)
        assert not other.status().deployed


class Broken:
    """A link that does with the first requests what a test wants."""

    def __init__(self, link: Link, breaks: list[BaseException]) -> None:
        self._link = link
        self._breaks = breaks
        self.endpoint = link.endpoint
        self.asked: list[str] = []

    def command(self, request: lafet.Request) -> Operation[list[lafet.Answer]]:
        self.asked.append(f"{request.name} {request.to}")
        if self._breaks:
            raise self._breaks.pop(0)
        return self._link.command(request)


def test_an_end_that_was_interrupted_is_made_at_the_next(simulator: Simulator) -> None:
    with pytest.raises(KeyboardInterrupt), simulator.connect() as monitor:
        monitor.deploy(wait=60)
        monitor.open(wait=10)
        monitor._core._link = Broken(monitor._core.link, [KeyboardInterrupt()])  # type: ignore[assignment]
    assert simulator.flow > 1
    monitor.end()
    until(lambda: simulator.flow < 1)


def test_one_that_cannot_be_ended_keeps_no_other_from_it(deployed: Monitor) -> None:
    refusal = lafet.Refused("resting", "Close", "Valve1", "ModuleFault", "Valve1")
    deployed.open(wait=10)
    deployed.aim(azimuth=170, elevation=10)
    broken = Broken(deployed._core.link, [refusal, lafet.ProtocolError("odd")])
    link = deployed._core.link
    deployed._core._link = broken  # type: ignore[assignment]
    deployed.end()
    deployed._core._link = link
    assert broken.asked[0] == "Close Valve1" and len(set(broken.asked[:3])) == 3
    assert broken.asked.count("Close Valve1") == 2
    deployed.wait_for(lambda it: not it.moving and not it.open, 10)


def test_a_number_that_does_not_fit_moves_nothing(deployed: Monitor, simulator: Simulator) -> None:
    there = simulator.position("Horizontal")
    with pytest.raises(OverflowError):
        deployed.aim(azimuth=10, elevation=1000)
    assert deployed._core._started.ends() == []
    assert "Move" not in deployed.status()["Horizontal"].flags
    time.sleep(0.5)
    assert abs(simulator.position("Horizontal") - there) < 6


def test_a_time_that_is_no_number_is_no_wait(monitor: Monitor) -> None:
    with pytest.raises(lafet.NotReached):
        monitor.wait_for(lambda it: False, float("nan"))
    with pytest.raises(lafet.NotReached):
        monitor.deploy(wait=float("nan"))


def test_an_end_in_the_middle_of_another_request(deployed: Monitor, simulator: Simulator) -> None:
    deployed.open(wait=10)
    # As in a signal handler that comes while the lock is held.
    ended = threading.Thread(target=lambda: until_the_end(deployed), daemon=True)
    ended.start()
    ended.join(30)
    assert not ended.is_alive()
    until(lambda: simulator.flow < 1)


def until_the_end(monitor: Monitor) -> None:
    with _common.LOCK:
        monitor.end()


def test_a_busy_monitor_is_asked_again(deployed: Monitor) -> None:
    busy = [lafet.Refused("restarting", "Stop", "Horizontal", "Busy", "General") for _ in range(10)]
    deployed.aim(azimuth=170)
    broken = Broken(deployed._core.link, list(busy))
    link = deployed._core.link
    deployed._core._link = broken  # type: ignore[assignment]
    deployed.end()
    deployed._core._link = link
    assert broken.asked == ["Stop Horizontal"] * 11
    deployed.wait_for(lambda it: not it.moving, 10)


def test_a_motion_that_another_thread_holds_ends_with_the_block(simulator: Simulator) -> None:
    kept: list[bool] = []

    def hold(monitor: Monitor) -> None:
        with monitor.hold("left") as motion:
            kept.append(motion.keep(60))

    with simulator.connect() as monitor:
        monitor.deploy(wait=60)
        thread = threading.Thread(target=hold, args=(monitor,), daemon=True)
        thread.start()
        until(lambda: simulator.position("Horizontal") > 60)
    thread.join(30)
    assert kept == [False]
    there = simulator.position("Horizontal")
    time.sleep(0.5)
    assert abs(simulator.position("Horizontal") - there) < 2


def test_a_held_motion_that_was_released_is_not_stopped_again(deployed: Monitor) -> None:
    with deployed.hold("left") as motion:
        motion.keep(0.2)
        assert [key for key, _, _ in deployed._core._started.ends()] == [("Stop", "Horizontal")]
    assert deployed._core._started.ends() == []


def test_another_monitor_of_the_line_ends_with_the_block_of_the_first(simulator: Simulator) -> None:
    with lafet.connect(simulator.url.replace("addr=1", "addr=2")) as first:
        second = first.at(1)
        second.deploy(wait=60)
        second.open(wait=10)
        with first.at(1).at(3):
            pass
        assert second.status().open
    until(lambda: simulator.flow < 1)
    with pytest.raises(RuntimeError, match="connect again"):
        second.open()


def test_nothing_is_started_while_the_block_is_left(deployed: Monitor) -> None:
    deployed._core.forbid()
    starts: list[Callable[[], object]] = [
        deployed.open,
        lambda: deployed.aim(azimuth=10),
        lambda: deployed.send("Open Valve1"),
        lambda: deployed.hold("left").__enter__(),
    ]
    for start in starts:
        with pytest.raises(RuntimeError, match="connect again"):
            start()
    assert not deployed.status().open


def test_what_was_refused_is_not_ended(simulator: Simulator) -> None:
    with simulator.connect() as monitor:
        answers = monitor.send("Open Valve1")
        assert not any(answer.accepted for answer in answers)
        assert monitor._core._started.ends() == []


def test_a_refusal_or_an_arrival_of_one_thread_is_not_that_of_another() -> None:
    started = _common.Started()
    stop = [lafet.Request.stop("Horizontal")]
    first, second = started.claim(stop), started.claim(stop)
    started.refused(first)
    for claim in [first, second]:
        started.settled(claim)
    assert len(started.ends()) == 1
    assert not started.ended(first.keys, first.number)
    assert len(started.ends()) == 1
    assert started.ended(second.keys, second.number)
    assert started.ends() == []


@pytest.mark.parametrize("timeout", [0, -1, 10.1, 86_400, float("nan"), float("inf")])
def test_an_answer_is_not_waited_for_without_end(simulator: Simulator, timeout: float) -> None:
    with pytest.raises(ValueError, match="at most 10"):
        simulator.connect(timeout=timeout)


def test_a_block_that_was_left_is_over(simulator: Simulator) -> None:
    with simulator.connect() as monitor:
        monitor.status()
    with pytest.raises(RuntimeError, match="connect again"):
        monitor.status()
    simulator.close()


def test_ctrl_c_is_not_hidden_by_a_line_that_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    cut = lafet.NotReached("cut")
    lafet.monitor.raise_unless_worse(cut, KeyboardInterrupt())
    assert "lafet: cut" in capsys.readouterr().err
    with pytest.raises(lafet.NotReached):
        lafet.monitor.raise_unless_worse(cut, ValueError())


def test_the_program_of_another_client_is_not_ended(simulator: Simulator) -> None:
    with simulator.connect() as other:
        other.deploy(wait=60)
        with simulator.connect() as monitor:
            monitor.aim(azimuth=10)
            other.quench((0, 0), (20, 4), step=1, distance=20)
        time.sleep(0.5)
        assert "Quench" in other.status()["Control"].flags


def test_many_threads(monitor: Monitor) -> None:
    seen: list[int] = []

    def read() -> None:
        for _ in range(50):
            seen.append(len(monitor.status()))

    threads = [threading.Thread(target=read) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert len(seen) == 400 and len(set(seen)) == 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_fork_has_connections_of_its_own(simulator: Simulator) -> None:
    program = f"""
        import lafet, os
        monitor = lafet.connect("{simulator.url}")
        child = os.fork()
        if child == 0:
            try:
                monitor.status()
            except RuntimeError as error:
                assert "connect again" in str(error)
                lafet.connect("{simulator.url}").status()
                os._exit(7)
            os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
        monitor.status()
    """
    assert subprocess.call([sys.executable, "-c", textwrap.dedent(program)], timeout=30) == 0


@pytest.mark.parametrize("method", ["fork", "forkserver", "spawn"])
def test_a_child_of_multiprocessing_ends_what_it_has_started(
    simulator: Simulator, tmp_path: Path, method: str
) -> None:
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"there is no {method} here")
    program = tmp_path / "program.py"
    program.write_text(
        textwrap.dedent(f"""
            import multiprocessing
            import lafet

            def work():
                monitor = lafet.connect("{simulator.url}")
                monitor.deploy(wait=60)
                monitor.open(wait=10)
                print("flows", flush=True)

            if __name__ == "__main__":
                child = multiprocessing.get_context("{method}").Process(target=work)
                child.start()
                child.join()
                assert child.exitcode == 0
                # What the end of this process does is not what is tested.
                import os
                os._exit(0)
        """)
    )
    done = subprocess.run([sys.executable, program], stdout=subprocess.PIPE, timeout=120, check=True)
    assert done.stdout == b"flows\n"
    until(lambda: simulator.flow < 1)


def test_reads_per_second(monitor: Monitor) -> None:
    monitor.status()
    begin = time.monotonic()
    for _ in range(300):
        monitor.status()
    # 30 would be a read that waits for a pause somewhere.
    assert 300 / (time.monotonic() - begin) > 100
