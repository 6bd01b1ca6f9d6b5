from itertools import product
from math import prod

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.facts.domain import Fault
from wakeful.treatments.noisy_or import POSITIVES, Network

SYMPTOMS = ("hot", "loud", "slow", "stopped")

chances = st.floats(0.0, 1.0).map(lambda p: round(p, 3))
networks = st.lists(
    st.builds(
        Fault, name=st.text(min_size=1), prior=chances, causes=st.dictionaries(st.sampled_from(SYMPTOMS), chances, min_size=1)
    ),
    min_size=1,
    max_size=4,
    unique_by=lambda fault: fault.name,
).map(tuple)
known = st.dictionaries(st.sampled_from(SYMPTOMS), st.booleans())


def by_enumeration(faults: tuple[Fault, ...], leak: float, findings: dict[str, bool]) -> tuple[float, dict[str, float], float]:
    """P(findings), P(findings, fault) and P(findings, no fault), by summing over every set of faults."""
    whole, none, on = 0.0, 0.0, dict.fromkeys((fault.name for fault in faults), 0.0)
    of_table = {symptom for fault in faults for symptom in fault.causes}
    for present in product((False, True), repeat=len(faults)):
        weight = prod(fault.prior if here else 1.0 - fault.prior for fault, here in zip(faults, present, strict=True))
        for symptom, seen in findings.items():
            if symptom in of_table:
                silent = (1.0 - leak) * prod(
                    1.0 - f.causes.get(symptom, 0.0) for f, here in zip(faults, present, strict=True) if here
                )
                weight *= 1.0 - silent if seen else silent
        whole += weight
        none += weight if not any(present) else 0.0
        for fault, here in zip(faults, present, strict=True):
            on[fault.name] += weight if here else 0.0
    return whole, on, none


@settings(deadline=None)
@given(networks, known, st.floats(0.001, 0.2))
def test_the_posterior_is_that_of_enumerating_every_set_of_faults(
    faults: tuple[Fault, ...], findings: dict[str, bool], leak: float
) -> None:
    network = Network(faults, leak)
    whole, on, none = by_enumeration(faults, leak, findings)
    if whole < 1e-9:
        return
    assert network.posterior(findings) == pytest.approx({name: share / whole for name, share in on.items()}, abs=1e-6)
    assert network.unexplained(findings) == pytest.approx(none / whole, abs=1e-6)


@settings(deadline=None)
@given(networks, known, st.sampled_from(SYMPTOMS))
def test_what_a_check_is_worth_is_that_of_trying_both_answers(
    faults: tuple[Fault, ...], findings: dict[str, bool], symptom: str
) -> None:
    network = Network(faults, 0.02)
    if symptom in findings or symptom not in network.symptoms or by_enumeration(faults, 0.02, findings)[0] < 1e-6:
        return
    chance, gain = network.look_for((symptom,), findings)[symptom]
    whole = by_enumeration(faults, 0.02, findings)[0]
    assert chance == pytest.approx(by_enumeration(faults, 0.02, {**findings, symptom: True})[0] / whole, abs=1e-6)
    assert gain >= 0.0


def test_a_symptom_that_only_one_fault_explains_points_to_it_and_away_from_the_other() -> None:
    faults = (Fault(name="a", prior=0.1, causes={"hot": 0.9, "loud": 0.9}), Fault(name="b", prior=0.1, causes={"hot": 0.9}))
    network = Network(faults, 0.01)
    one, both = network.posterior({"hot": True}), network.posterior({"hot": True, "loud": True})
    assert one["a"] == pytest.approx(one["b"])
    assert both["a"] > 0.9 > 0.3 > both["b"]  # b is explained away
    assert network.posterior({"hot": True, "loud": False})["b"] > one["b"]


def test_looking_for_what_separates_the_suspects_is_worth_more_than_looking_for_what_both_show() -> None:
    faults = (
        Fault(name="a", prior=0.1, causes={"hot": 0.9, "loud": 0.9, "slow": 0.5}),
        Fault(name="b", prior=0.1, causes={"hot": 0.9, "slow": 0.5}),
    )
    worth = Network(faults, 0.01).look_for(("loud", "slow"), {"hot": True})
    assert worth["loud"][1] > 3 * worth["slow"][1]


def test_more_findings_than_can_be_summed_over_keep_the_most_telling() -> None:
    causes = {f"s{at}": 0.1 + 0.04 * at for at in range(POSITIVES + 5)}
    network = Network((Fault(name="a", prior=0.01, causes=causes),), 0.02)
    assert network.posterior(dict.fromkeys(causes, True))["a"] > 0.99


def test_a_table_without_faults_leaves_everything_unexplained() -> None:
    network = Network(())
    assert network.posterior({"hot": True}) == {}
    assert network.unexplained({"hot": True}) == 1.0
    assert network.look_for((), {}) == {}
