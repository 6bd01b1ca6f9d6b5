"""What a training learns from."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from wakeful.learning.replay import Row, Sides, fraction, refuted, replay


def row(number: int, label: int = 0, applied: int = 0, result: int = 0, contradicted: bool = False, at: float = 0.0) -> Row:
    return Row(
        id=number,
        event=f"e{number}",
        process=number,
        features=np.array([at, 1.0]),
        label=label,
        applied=applied,
        result=result,
        contradicted=contradicted,
        weight=1.0,
        held_back=False,
    )


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 1), st.booleans()), max_size=60), st.integers(8, 24))
def test_a_replay_is_bounded_ordered_without_repetition_and_full(kinds: list[tuple[int, int, bool]], limit: int) -> None:
    rows = [row(i, label=a, result=b, contradicted=c) for i, (a, b, c) in enumerate(kinds)]
    kept = replay(rows, limit)
    assert len(kept) == min(limit, len(rows))
    ids = [each.id for each in kept]
    assert ids == sorted(set(ids))
    assert set(range(len(rows) - limit // 2, len(rows))) & set(range(len(rows))) <= set(ids)


def test_rare_treatments_and_old_contradictions_outlast_a_flood() -> None:
    rows = [row(0, label=2), row(1, label=-1, applied=1, result=1, contradicted=True)] + [row(i) for i in range(2, 2000)]
    ids = {each.id for each in replay(rows, 64)}
    assert {0, 1} <= ids


def test_an_event_stays_on_its_side_and_the_first_of_a_kind_are_learned_from() -> None:
    sides = Sides(share=1.0)
    assert [sides.held_back(f"e{i}", (0, 0), None) for i in range(4)] == [False, False, True, True]
    assert sides.held_back("e9", (1, 0), None) is False
    assert sides.held_back("e9", (0, 0), before=False) is False
    assert Sides(share=0.0).held_back("x", (0, 0), before=True) is True


def test_the_held_back_share_is_about_what_was_asked_and_the_same_for_the_same_event() -> None:
    shares = [fraction(f"event {i}") for i in range(4000)]
    assert 0.17 < np.mean([share < 0.2 for share in shares]) < 0.23
    assert fraction("event 7") == shares[7]


def test_a_contradicted_result_alone_does_not_refute_its_treatment() -> None:
    rows = [row(i, at=i / 100) for i in range(10)] + [row(10, label=-1, result=1, contradicted=True)]
    assert (refuted(rows) == -1).all()


def test_a_treatment_is_refuted_where_another_got_right_on_like_events_what_it_got_wrong() -> None:
    near = [row(i, label=2, applied=2, result=1, at=i / 100) for i in range(3)]
    assert refuted([*near, row(10, label=-1, applied=0, result=1, contradicted=True)]).tolist() == [-1, -1, -1, 0]


def test_a_treatment_that_got_it_right_itself_on_like_events_is_not_refuted() -> None:
    near = [row(0, label=2, applied=2, result=1), row(1, label=0, applied=0, result=1)]
    assert refuted([*near, row(10, label=-1, applied=0, result=1, contradicted=True)]).tolist() == [-1, -1, -1]


def test_what_another_got_right_far_away_says_nothing() -> None:
    near = [row(i, label=0, at=i / 100) for i in range(8)]
    far = [row(20, label=2, applied=2, result=1, at=50.0)]
    assert (refuted([*near, *far, row(30, label=-1, applied=0, result=1, contradicted=True)]) == -1).all()


def test_nothing_is_refuted_by_nothing() -> None:
    assert refuted([]).shape == (0,)
