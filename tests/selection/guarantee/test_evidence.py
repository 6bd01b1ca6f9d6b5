"""The gate as numbers: levels are certified one after the other, watched, and begun anew; alone and side by side."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.selection.guarantee.bets import LEVELS
from wakeful.selection.guarantee.evidence import Evidence
from wakeful.selection.guarantee.settings import GuaranteeSettings

SETTINGS = GuaranteeSettings(audit_rate=0.5)


def take(evidence: Evidence, place: int, wrong: bool, times: int = 1, certified: bool = False) -> None:
    shape = evidence.proven.shape
    for _ in range(times):
        evidence.take(
            place=np.full(shape, place),
            drawn=np.full(shape, True),
            wrong=np.full(shape, wrong),
            automatic=np.full(shape, certified),
            probability=1.0,
            certified=np.full(shape, certified),
        )
        evidence.weigh()


def test_levels_are_certified_from_the_strictest_on_up_to_the_first_that_is_too_risky() -> None:
    evidence = Evidence(SETTINGS)
    for _ in range(60):
        take(evidence, place=2, wrong=False)
        take(evidence, place=8, wrong=True)
    assert int(evidence.proven) == 8
    take(evidence, place=2, wrong=True, times=40)
    assert int(evidence.proven) == 8, "what was certified stays so until it is revoked"


def test_every_level_is_certified_where_nothing_was_ever_wrong() -> None:
    evidence = Evidence(SETTINGS)
    take(evidence, place=0, wrong=False, times=88)
    assert int(evidence.proven) == len(LEVELS)


def test_only_what_is_certified_is_watched_and_a_restart_forgets_all_but_the_number() -> None:
    evidence = Evidence(SETTINGS, (2,))
    evidence.take(
        place=np.zeros(2, dtype=np.int64),
        drawn=np.array([True, True]),
        wrong=np.array([True, True]),
        automatic=np.array([True, True]),
        probability=0.5,
        certified=np.array([True, False]),
    )
    assert evidence.audited.tolist() == [pytest.approx(np.log(4)), 0.0]
    for _ in range(5):
        take(evidence, place=0, wrong=True, certified=True)
    assert evidence.alarms()[0].all()
    evidence.restart(np.array([True, False]))
    assert evidence.alarms()[0].tolist() == [False, True]
    assert evidence.number.tolist() == [2, 1]
    assert evidence.tally.errors[0].sum() == 0
    assert evidence.tally.errors[1].sum() > 0
    assert evidence.delta[0] == pytest.approx(0.05 / 6)


def test_many_deployments_side_by_side_are_each_what_they_would_be_alone() -> None:
    random = np.random.default_rng(5)
    together, alone = Evidence(SETTINGS, (6,)), [Evidence(SETTINGS) for _ in range(6)]
    for _ in range(300):
        place, wrong = random.integers(0, 17, 6), random.random(6) < np.linspace(0, 0.3, 6)
        drawn, automatic, where = random.random(6) < 0.5, random.random(6) < 0.5, random.random(6) < 0.9
        certified = together.proven > 0
        together.take(place, drawn, wrong, automatic, 0.5, certified, where)
        together.weigh()
        for each in np.flatnonzero(where):
            one = alone[each]
            one.take(place[each], drawn[each], wrong[each], automatic[each], 0.5, one.proven > 0)
            one.weigh()
    assert together.proven.tolist() == [int(one.proven) for one in alone]
    assert together.audited == pytest.approx([float(one.audited) for one in alone])
    assert len(set(together.proven.tolist())) > 1
