"""asyncio in virtual time: at once, in order, and ended where somebody says so."""

from __future__ import annotations

import asyncio

import pytest

from wakeful.testing.crash_points import Crashed
from wakeful.testing.virtual_loop import Beside, NobodyWakes, VirtualLoop


def test_an_hour_passes_at_once_and_in_order() -> None:
    loop = VirtualLoop(start_s=5.0)
    seen: list[tuple[str, float]] = []

    async def story() -> None:
        async def wait(name: str, seconds: float) -> None:
            await asyncio.sleep(seconds)
            seen.append((name, loop.time()))

        await asyncio.gather(wait("late", 3_600.0), wait("soon", 1.0))

    loop.run_until_complete(story())
    loop.close()
    assert seen == [("soon", 6.0), ("late", 3_605.0)]


def test_what_would_wait_for_ever_is_said() -> None:
    loop = VirtualLoop()
    with pytest.raises(NobodyWakes):
        loop.run_until_complete(loop.create_future())
    loop.close()


def test_what_stands_beside_does_one_thing_after_the_other() -> None:
    loop = VirtualLoop()
    beside = Beside(loop, lambda: 2.0)
    done: list[float] = []

    async def story() -> None:
        first, second = (beside.submit(lambda: done.append(loop.time())) for _ in range(2))
        await asyncio.sleep(10.0)
        assert first.done()
        assert second.done()

    loop.run_until_complete(story())
    loop.close()
    assert done == [2.0, 4.0]


def test_nothing_runs_on_after_the_end() -> None:
    loop = VirtualLoop()
    ran: list[str] = []

    async def story() -> None:
        loop.call_soon(ran.append, "already due")
        loop.end(Crashed("here"))
        await asyncio.sleep(0)
        ran.append("later")

    task = loop.create_task(story())
    with pytest.raises(Crashed, match="here"):
        loop.run_until_complete(task)
    task._log_destroy_pending = False  # type: ignore[attr-defined]
    task.get_coro().close()  # type: ignore[union-attr]
    loop.close()
    assert ran == []
