"""The collector's setting, and that it is safe: processes leave no cycles behind that only a full pass would find."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from wakeful.drivers.garbage import MIDDLE, OLD, YOUNG, settle
from wakeful.drivers.inline import Mind
from wakeful.facts.events import Event


@pytest.fixture
def _as_before() -> Iterator[None]:
    before = gc.get_threshold()
    yield
    gc.unfreeze()
    gc.set_threshold(*before)
    gc.enable()


@pytest.mark.usefixtures("_as_before")
def test_what_is_there_is_left_alone_from_then_on() -> None:
    settle()
    assert gc.get_freeze_count() > 0
    assert gc.get_threshold() == (YOUNG, MIDDLE, OLD)


@pytest.mark.usefixtures("_as_before")
def test_what_a_mind_no_longer_keeps_is_freed_without_the_collector() -> None:
    with Mind("service_robot") as mind:
        mind.admit("object", "cup-1", {"category": "item", "state": "normal"}, at_ns=1_000_000_000)
        gc.collect()
        gc.disable()
        before = sum(isinstance(each, Event) for each in gc.get_objects())
        for number in range(20):
            mind.admit("object", f"cup-{number + 2}", {"category": "item", "state": "normal"}, at_ns=2_000_000_000 + number)
        kept = sum(isinstance(each, Event) for each in gc.get_objects()) - before
        assert gc.collect() < 200
        assert kept <= 4 * 20
