"""Backpressure: callers wait for room in turn, criticals in room of their own; patience ends, and so does the mind."""

from __future__ import annotations

import asyncio

import pytest

from wakeful.drivers.room import Room
from wakeful.facts.overload import OverloadSettings

SETTINGS = OverloadSettings(refuse_backlog=10, reserve=0.2)


class Load:
    """A backlog that the test sets."""

    def __init__(self, value: int) -> None:
        self.value = value

    def __call__(self) -> int:
        return self.value


async def settle() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


def test_with_room_nobody_waits_and_nobody_is_switched_away_from() -> None:
    entering = Room(SETTINGS, Load(7)).enter(False, None)
    with pytest.raises(StopIteration):
        entering.send(None)


def test_callers_are_let_in_in_turn_as_far_as_there_is_room_and_criticals_before() -> None:
    async def main() -> list[str]:
        load = Load(10)
        room = Room(SETTINGS, load)
        came: list[str] = []

        async def caller(name: str, critical: bool) -> None:
            await room.enter(critical, None)
            came.append(name)

        tasks = [asyncio.create_task(caller(name, name.isupper())) for name in "abCdE"]
        await settle()
        assert came == []
        assert room.waiting == 5
        load.value = 8
        room.let_in()
        await settle()
        assert came == ["C", "E"]
        load.value = 6
        room.let_in()
        await settle()
        assert came == ["C", "E", "a", "b"]
        load.value = 0
        room.let_in()
        await asyncio.gather(*tasks)
        return came

    assert asyncio.run(main()) == ["C", "E", "a", "b", "d"]


def test_patience_ends_and_leaves_no_place_behind() -> None:
    async def main() -> int:
        room = Room(SETTINGS, Load(10))
        await room.enter(False, 0.01)
        return room.waiting

    assert asyncio.run(main()) == 0


def test_a_caller_that_is_cancelled_leaves_no_place_behind() -> None:
    async def main() -> int:
        room = Room(SETTINGS, Load(10))
        waiting = asyncio.create_task(room.enter(False, None))
        await settle()
        waiting.cancel()
        await asyncio.gather(waiting, return_exceptions=True)
        return room.waiting

    assert asyncio.run(main()) == 0


def test_whoever_waits_hears_that_the_mind_has_closed() -> None:
    async def main() -> BaseException | None:
        room = Room(SETTINGS, Load(10))
        waiting = asyncio.create_task(room.enter(True, None))
        await settle()
        room.close(ValueError("closed"))
        return (await asyncio.gather(waiting, return_exceptions=True))[0]

    assert isinstance(asyncio.run(main()), ValueError)
