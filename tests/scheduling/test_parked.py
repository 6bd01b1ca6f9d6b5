"""The index of parked processes, against a plain model of it."""

from __future__ import annotations

from random import Random

import pytest

from wakeful.facts.time import LARGEST_NS
from wakeful.scheduling import parked as room
from wakeful.scheduling.parked import Parked


def test_nobody_is_parked_at_first() -> None:
    parked = Parked()
    assert len(parked) == 0
    assert parked.soonest_ns == LARGEST_NS
    assert parked.waiting_for("reading\x1fpump") == []
    assert parked.until(LARGEST_NS - 1) == []
    assert 1 not in parked


def test_who_is_not_parked_cannot_leave() -> None:
    with pytest.raises(KeyError):
        Parked().leave(7)


@pytest.mark.parametrize("seed", range(6))
def test_it_finds_whom_a_plain_model_finds(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "FRESH", 8)
    monkeypatch.setattr(room, "RUNS", 3)
    random, parked, model, last = Random(seed), Parked(), dict[int, tuple[str, int | None]](), 0
    for _ in range(600):
        if random.random() < 0.6 or not model:
            last += random.choice((1, 1, 5))
            key, limit = f"topic\x1f{random.randrange(20)}", random.choice((None, random.randrange(1_000)))
            parked.park(last, key, limit)
            model[last] = (key, limit)
        else:
            gone = random.choice(list(model))
            parked.leave(gone)
            del model[gone]
        asked, at_ns = f"topic\x1f{random.randrange(20)}", random.randrange(1_000)
        assert parked.waiting_for(asked) == sorted(each for each, (key, _) in model.items() if key == asked)
        assert parked.until(at_ns) == sorted(each for each, (_, limit) in model.items() if limit is not None and limit <= at_ns)
        limits = [limit for _, limit in model.values() if limit is not None]
        assert parked.soonest_ns == min(limits, default=LARGEST_NS)
        assert len(parked) == len(model)
        assert all(each in parked for each in model)
        assert last + 1 not in parked
