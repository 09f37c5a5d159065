"""What a fork has of its parent: no line, and no lock that nothing releases."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager

import lafet
import pytest
from lafet import Simulator

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")


@contextmanager
def fork_of_a_killed_program(url: str) -> Iterator[None]:
    """A program connects and forks; its fork does nothing, and is there after it was killed."""
    program = f"""
        import lafet, os, time
        monitor = lafet.connect("{url}")
        fork = os.fork()
        if fork == 0:
            time.sleep(60)
            os._exit(0)
        print(fork, flush=True)
        time.sleep(60)
    """
    parent = subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE)
    assert parent.stdout is not None
    fork = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    try:
        yield
    finally:
        os.kill(fork, signal.SIGKILL)


def test_a_fork_does_not_keep_a_port_of_its_parent() -> None:
    other_end, line = os.openpty()
    url = f"serial://{os.ttyname(line)}?addr=1"
    with fork_of_a_killed_program(url), lafet.connect(url) as monitor:
        assert "serial" in repr(monitor)
    os.close(line)
    os.close(other_end)


def test_a_fork_does_not_keep_a_connection_of_its_parent() -> None:
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        server.settimeout(30)
        with fork_of_a_killed_program(f"tcp://127.0.0.1:{server.getsockname()[1]}?addr=1"):
            connection, _ = server.accept()
            with connection:
                connection.settimeout(10)
                while connection.recv(100):
                    pass


def exit_code(program: str) -> int:
    return subprocess.call([sys.executable, "-c", textwrap.dedent(program)], timeout=60)


def test_a_lock_that_another_thread_holds_is_not_held_in_a_fork(simulator: Simulator) -> None:
    program = f"""
        import os, threading, time
        import lafet
        from lafet import _common

        held = threading.Event()

        def hold() -> None:
            with _common.LOCK:
                held.set()
                time.sleep(0.5)

        threading.Thread(target=hold).start()
        held.wait()
        child = os.fork()
        if child == 0:
            with lafet.connect("{simulator.url}") as monitor:
                monitor.deploy()
            os._exit(7)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
        # And here it is free.
        with lafet.connect("{simulator.url}") as monitor:
            monitor.deploy()
    """
    assert exit_code(program) == 0


def test_a_simulator_is_that_of_its_process() -> None:
    program = """
        import os
        import lafet

        with lafet.Simulator() as simulator:
            child = os.fork()
            if child == 0:
                for use in [lambda: simulator.now, lambda: simulator.skip(1), simulator.power_cycle]:
                    try:
                        use()
                    except RuntimeError as error:
                        assert "fork" in str(error)
                    else:
                        os._exit(1)
                simulator.close()
                del simulator, use
                os._exit(7)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
            assert simulator.now >= 0
    """
    assert exit_code(program) == 0
