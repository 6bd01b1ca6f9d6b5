"""One fault at a time: exact by counting every case, and a table that is learned from labelled ones."""

from __future__ import annotations

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.treatments.worlds import DOMAIN
from wakeful.facts.domain import Fault
from wakeful.treatments.fault_table import learn_faults
from wakeful.treatments.noisy_or import Network
from wakeful.treatments.one_fault import OneFault, network_of

FAULTS = (
    Fault(name="slip", prior=0.3, causes={"a>1": 0.9, "b>1": 0.2}),
    Fault(name="jam", prior=0.5, causes={"a>1": 0.4, "b>1": 0.7}),
)


@given(st.dictionaries(st.sampled_from(["a>1", "b>1"]), st.booleans()))
def test_the_posterior_is_bayes_rule_over_the_table(findings: dict[str, bool]) -> None:
    model = OneFault(FAULTS, leak=0.05)
    joint = {"": 0.2, **{fault.name: fault.prior for fault in FAULTS}}
    for symptom, seen in findings.items():
        for name in joint:
            shows = next((fault.causes[symptom] for fault in FAULTS if fault.name == name), 0.05)
            joint[name] *= shows if seen else 1.0 - shows
    total = sum(joint.values())
    for name, share in model.posterior(findings).items():
        assert share == pytest.approx(joint[name] / total, abs=1e-9)
    assert model.unexplained(findings) == pytest.approx(joint[""] / total, abs=1e-9)


def test_looking_tells_as_much_as_the_entropy_falls_on_average() -> None:
    model = OneFault(FAULTS, leak=0.05)
    chance, gain = model.look_for(("a>1",), {})["a>1"]
    assert chance == pytest.approx(0.3 * 0.9 + 0.5 * 0.4 + 0.2 * 0.05)
    assert 0.0 < gain < 1.5
    assert model.look_for(("a>1",), {"b>1": True})["a>1"][1] < 1.5


def test_any_number_of_positive_findings_is_exact_and_none_is_dropped() -> None:
    many = {f"s{number}>0": 0.9 for number in range(40)}
    model = OneFault((Fault(name="x", prior=0.5, causes=many), Fault(name="y", prior=0.5, causes=dict.fromkeys(many, 0.5))))
    assert model.posterior(dict.fromkeys(many, True))["x"] > 0.999999


def test_the_domain_says_which_model_it_wants() -> None:
    assert type(network_of(DOMAIN, 0.02)) is Network
    assert type(network_of(replace(DOMAIN, one_fault=True), 0.02)) is OneFault


def test_a_learned_table_names_the_bounds_that_tell_the_faults_apart_and_finds_the_fault_again() -> None:
    random = Random(4)
    cases = [
        ({"force": random.gauss(10.0 if name == "jam" else 3.0, 1.0), "noise": random.gauss(0.0, 1.0)}, name)
        for name in (random.choice(("jam", "slip")) for _ in range(200))
    ]
    table = learn_faults(cases[:100], symptoms=4)
    assert [fault.name for fault in table] == ["jam", "slip"]
    assert next(iter(table[0].causes)).startswith("force>")
    model = OneFault(table)
    right = 0
    for values, name in cases[100:]:
        findings = {
            symptom: values["force" if symptom.startswith("force") else "noise"] > float(symptom.split(">")[1])
            for symptom in model.symptoms
        }
        posterior = model.posterior(findings)
        right += max(posterior, key=lambda each: posterior[each]) == name
    assert right >= 97


def test_no_case_no_table() -> None:
    with pytest.raises(ValueError, match="there are none"):
        learn_faults([])
