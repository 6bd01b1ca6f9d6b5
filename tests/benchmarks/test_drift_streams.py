"""The drifting streams' loop on a small made-up one: outcomes are heard, recent experience helps, and recovery knows as much."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.drift_streams import Rows, lived, mind, wakeful
from wakeful.facts.lines import Gained, Published
from wakeful.journal import MemoryJournal


@pytest.fixture(scope="module")
def rows() -> Rows:
    """The class follows one number, and from row 200 on the other way round."""
    x = np.random.default_rng(0).random((480, 2))
    turned = np.arange(480) >= 200
    return Rows("made up", x, tuple("high" if high else "low" for high in (x[:, 0] > 0.5) ^ turned), (200,))


def test_every_outcome_that_is_told_becomes_an_experience_of_its_own_label(rows: Rows) -> None:
    journal = MemoryJournal()
    lived(rows, *mind(rows), journal)
    gained = [line.record.experience.outcome for line in journal.lines() if isinstance(line.record, Gained)]
    assert gained == list(rows.y[: len(gained)])
    assert len(gained) == len(rows.y) - 20


def test_recent_experience_follows_what_the_model_alone_does_not(rows: Rows) -> None:
    found = wakeful(rows)
    assert found["accuracy"] > found["model_alone"] + 0.1  # type: ignore[operator]


def test_a_kernel_that_recovers_knows_as_much_of_recent_experience(rows: Rows) -> None:
    journal = MemoryJournal()
    kernel, learner = mind(rows)
    lived(rows, kernel, learner, journal)
    again, _ = mind(rows)
    published = [line.record.card.blob for line in journal.lines() if isinstance(line.record, Published)]
    again.recover(journal.entries(), journal.state(), {name: journal.blob(name) for name in published})
    for found in (kernel, again):
        assert found._recent.heard
    assert again._recent.weights == kernel._recent.weights
    assert again._recent.outdoes_memory == kernel._recent.outdoes_memory
