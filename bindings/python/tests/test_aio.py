"""The same with asyncio."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import textwrap
import time

import lafet
import pytest
from lafet import Simulator, aio
from lafet._core import live


def test_two_monitors_at_once() -> None:
    async def turn(simulator: Simulator, azimuth: float) -> None:
        async with await aio.connect(simulator.url) as monitor:
            await monitor.deploy(wait=60)
            await monitor.aim(azimuth=azimuth, wait=20)
            assert abs((await monitor.status()).azimuth - azimuth) < 0.2

    async def both(first: Simulator, second: Simulator) -> None:
        await asyncio.gather(turn(first, 5), turn(second, -5))

    with Simulator() as first, Simulator(seed=2) as second:
        begin = time.monotonic()
        asyncio.run(both(first, second))
        assert time.monotonic() - begin < 30
        assert abs(second.position("Horizontal") + 300) <= 6


def test_a_cancelled_task_ends_what_it_has_started(simulator: Simulator) -> None:
    async def work() -> None:
        async with await aio.connect(simulator.url) as monitor:
            await monitor.deploy(wait=60)
            await monitor.open(wait=10)
            await monitor.aim(azimuth=170, wait=60)

    async def cancelled() -> None:
        task = asyncio.create_task(work())
        while simulator.position("Horizontal") < 60:
            await asyncio.sleep(0.02)
        task.cancel()
        # Once more, in the middle of the end.
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(asyncio.wait_for(cancelled(), 60))
    deadline = time.monotonic() + 10
    while simulator.flow > 1:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert simulator.position("Horizontal") < 170 * 60 - 600


def test_without_a_block_the_end_of_the_program_ends_it(simulator: Simulator) -> None:
    program = f"""
        import asyncio
        from lafet import aio

        async def main() -> None:
            monitor = await aio.connect("{simulator.url}")
            await monitor.deploy(wait=60)
            await monitor.open(wait=10)

        asyncio.run(main())
    """
    assert subprocess.call([sys.executable, "-c", textwrap.dedent(program)], timeout=90) == 0
    deadline = time.monotonic() + 10
    while simulator.flow > 1:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_hold_and_a_refusal(simulator: Simulator) -> None:
    async def work() -> None:
        async with await aio.connect(simulator.url) as monitor:
            with pytest.raises(lafet.Refused, match="deploy"):
                await monitor.open()
            await monitor.deploy(wait=60)
            # On a machine that stalls, a hold ends by itself, as it must: another one may do.
            for _ in range(5):
                async with monitor.hold("left") as motion:
                    kept = await motion.keep(0.5)
                if kept:
                    break
            assert kept
            assert motion.ended == "released"

    asyncio.run(work())
    assert simulator.position("Horizontal") > 60


def test_a_motion_that_another_task_holds_ends_with_the_block(simulator: Simulator) -> None:
    async def hold(monitor: aio.Monitor) -> bool:
        async with monitor.hold("left") as motion:
            return await motion.keep(60)

    async def work() -> None:
        async with await aio.connect(simulator.url) as monitor:
            await monitor.deploy(wait=60)
            task = asyncio.create_task(hold(monitor))
            while simulator.position("Horizontal") < 60:
                await asyncio.sleep(0.02)
        assert not await asyncio.wait_for(task, 30)

    asyncio.run(work())


def test_an_operation_is_begun_once(simulator: Simulator) -> None:
    async def work() -> None:
        monitor = await aio.connect(simulator.url)
        operation = monitor.link.send(lafet.Request.get_status("All"))
        assert await operation.start()
        with pytest.raises(RuntimeError, match="already"):
            operation.start()

    asyncio.run(work())
    with pytest.raises(RuntimeError):
        lafet.connect(simulator.url)._core.link.send(lafet.Request.get_status("All")).start()


def test_a_block_that_is_thrown_away_after_its_loop_ends_what_it_has_started(simulator: Simulator) -> None:
    async def work() -> None:
        async with await aio.connect(simulator.url) as monitor:
            await monitor.deploy(wait=60)
            await monitor.open(wait=10)
            await asyncio.sleep(60)

    loop = asyncio.new_event_loop()
    working = work()
    task = loop.create_task(working)
    task._log_destroy_pending = False  # type: ignore[attr-defined]
    deadline = time.monotonic() + 60
    while simulator.flow < 1:
        assert time.monotonic() < deadline
        loop.run_until_complete(asyncio.sleep(0.05))
    loop.close()
    working.close()
    while simulator.flow > 1:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert not task.done()
    assert all(core._started for core in live), "nothing is left for the end of the program"
