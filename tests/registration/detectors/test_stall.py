"""A command that is not followed."""

from __future__ import annotations

import pytest

from tests.registration.watching import detector, seen
from wakeful.contracts.detector import Found
from wakeful.contracts.domain import DomainError
from wakeful.facts.events import Phase


def test_a_command_that_is_not_followed_is_a_stall_until_it_is() -> None:
    watcher = detector("stall", commanded="cmd/v", measured="odom/v", hold_s=1.0)
    found = []
    for step in range(40):
        moves = step < 10 or step >= 30
        for index, (topic, value) in enumerate((("cmd", 0.5), ("odom", 0.5 if moves else 0.0))):
            for item in watcher.observe(seen(2 * step + index, step * 0.2, topic, v=value)):
                assert isinstance(item, Found)
                found.append((step, item.phase))
    assert found == [(15, Phase.RAISED), (30, Phase.CLEARED)]


def test_an_old_command_is_none() -> None:
    watcher = detector("stall", commanded="cmd/v", measured="odom/v", hold_s=1.0, stale_s=0.5)
    watcher.observe(seen(0, 0.0, "cmd", v=1.0))
    assert [item for step in range(1, 30) for item in watcher.observe(seen(step, 0.2 * step, "odom", v=0.0))] == []


def test_a_stall_needs_both_channels() -> None:
    with pytest.raises(DomainError, match=r"give settings\.commanded and settings\.measured"):
        detector("stall", commanded="cmd/v")
