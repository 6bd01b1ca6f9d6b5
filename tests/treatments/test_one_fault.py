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
    table = learn_faults(cases[:100])
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


def test_bounds_that_one_value_passes_are_one_finding() -> None:
    """Three bounds passed say no more than the highest of them."""
    causes = ({"x>1": 0.9, "x>2": 0.8, "x>3": 0.6}, {"x>1": 0.5, "x>2": 0.4, "x>3": 0.3})
    model = OneFault([Fault(name=str(place), prior=0.5, causes=row) for place, row in enumerate(causes)])
    assert model.posterior({"x>1": True, "x>2": True, "x>3": True}) == pytest.approx(model.posterior({"x>3": True}))
    between = model.posterior({"x>1": True, "x>2": True, "x>3": False})
    assert between["0"] == pytest.approx(0.2 / (0.2 + 0.1))
    below = OneFault([Fault(name="low", prior=1.0, causes={"x<1": 0.2, "x<2": 0.7})])
    assert below.look_for(("x<1",), {"x<2": True})["x<1"][0] == pytest.approx(0.2 / 0.7)
    assert below.look_for(("x<2",), {"x<1": True})["x<2"][0] > 0.99


def test_bounds_from_below_and_from_above_cut_one_distribution() -> None:
    """Past the upper bound is not below the lower one: that is no news."""
    rows = ({"x>5": 0.6, "x<3": 0.1}, {"x>5": 0.3, "x<3": 0.5})
    model = OneFault([Fault(name=str(place), prior=0.5, causes=row) for place, row in enumerate(rows)])
    high = model.posterior({"x>5": True, "x<3": False})
    assert high == pytest.approx(model.posterior({"x>5": True}))
    assert high["0"] == pytest.approx(0.6 / 0.9)
    assert model.posterior({"x>5": False, "x<3": False})["0"] == pytest.approx(0.3 / (0.3 + 0.2))
    assert model.look_for(("x<3",), {"x>5": True})["x<3"][0] < 0.001


@pytest.mark.parametrize(("value", "share"), [(2.0, 0.1), (4.0, 0.6), (6.0, 0.3)])
def test_bounds_that_overlap_leave_the_middle_to_what_lies_in_both(value: float, share: float) -> None:
    """P(x > 3) = 0.9 and P(x < 5) = 0.7 leave 0.6 between them; the other fault leaves nothing there."""
    model = OneFault(
        [Fault(name="a", prior=0.5, causes={"x>3": 0.9, "x<5": 0.7}), Fault(name="b", prior=0.5, causes={"x>3": 0.5, "x<5": 0.5})]
    )
    other = {2.0: 0.5, 4.0: 1e-4, 6.0: 0.5}[value]
    findings = {"x>3": value > 3.0, "x<5": value < 5.0}
    assert model.posterior(findings)["a"] == pytest.approx(share / (share + other), abs=1e-3)


def test_bounds_that_overlap_and_are_both_said_to_be_rare_are_read_as_the_nearest_distribution() -> None:
    """Neither fault names both; the leak would have both at 2 %, but every number is above 3 or below 5."""
    model = OneFault([Fault(name="high", prior=0.5, causes={"x>3": 0.9}), Fault(name="low", prior=0.5, causes={"x<5": 0.9})])
    assert model.posterior({"x>3": True, "x<5": False})["high"] == pytest.approx(0.94)
    assert model.posterior({"x>3": False, "x<5": True})["low"] == pytest.approx(0.94)
    assert model.posterior({"x>3": True, "x<5": True})["high"] == pytest.approx(0.5)


def test_a_number_on_the_bound_itself_is_on_the_side_that_its_sign_says() -> None:
    model = OneFault([Fault(name="a", prior=1.0, causes={"x<5": 0.2, "x<=5": 0.5, "x>5": 0.5, "x>=5": 0.8})])
    chances = {symptom: model.look_for((symptom,), {"x<=5": True})[symptom][0] for symptom in ("x<5", "x>=5", "x>5")}
    assert chances == pytest.approx({"x<5": 0.4, "x>=5": 0.6, "x>5": 0.0}, abs=1e-3)


@given(st.permutations(["x>1", "x>2", "x>3"]), st.integers(0, 3))
def test_the_order_of_findings_does_not_matter_and_a_bound_that_a_fault_leaves_out_is_never_less_likely(
    order: list[str], passed: int
) -> None:
    model = OneFault(
        [Fault(name="a", prior=0.6, causes={"x>3": 0.9}), Fault(name="b", prior=0.4, causes={"x>1": 0.5, "x>2": 0.2})]
    )
    findings = {symptom: int(symptom[-1]) <= passed for symptom in order}
    assert model.posterior(findings) == pytest.approx(model.posterior(dict(sorted(findings.items()))))
    if passed == 3:
        assert model.posterior(findings)["a"] > 0.9


def test_a_learned_table_tells_a_fault_in_the_middle_from_those_on_both_sides() -> None:
    random = Random(5)
    middle = {"low": -4.0, "mid": 0.0, "high": 4.0}
    cases = [({"x": random.gauss(middle[name], 1.0)}, name) for name in (random.choice(list(middle)) for _ in range(300))]
    table = {fault.name: fault for fault in learn_faults(cases)}
    assert len(table["mid"].causes) == 2
    first, second = table["mid"].causes.values()
    assert first > 0.9 > 0.1 > second


def test_a_field_that_tells_nothing_stands_in_no_row_and_few_cases_get_one_bound_a_field() -> None:
    random = Random(6)
    cases = [({"x": random.random(), "y": float(number % 2)}, ("a", "b")[number % 2]) for number in range(100)]
    assert set(learn_faults(cases)[0].causes) == {"y>0.5"}
    assert set(learn_faults(cases[:2])[0].causes) == {f"x>{(cases[0][0]['x'] + cases[1][0]['x']) / 2:.6g}", "y>0.5"}


def test_fields_that_say_the_same_thing_many_times_do_not_make_it_surer() -> None:
    """Forty copies of one doubtful sign: a table that took each for news would be certain, and wrong in every fifth case."""
    random = Random(7)

    def case(number: int) -> tuple[dict[str, float], str]:
        name = ("a", "b")[number % 2]
        shown = float((name == "a") == (random.random() < 0.8))
        return {f"copy{place:02}": shown for place in range(40)}, name

    model = OneFault(learn_faults([case(number) for number in range(200)]))
    sure = model.posterior(dict.fromkeys(model.symptoms, True))["a"]
    assert len(model.symptoms) == 40
    assert 0.6 < sure < 0.995


def test_cases_of_one_run_are_held_back_together() -> None:
    """Within a run everything looks alike; between runs the field says nothing: only who holds back whole runs can see that."""
    random = Random(8)
    cases, runs = [], []
    for run in range(6):
        name, level = ("a", "b")[run % 2], random.random()
        cases += [({f"x{place}": level + random.gauss(0.0, 0.001) for place in range(10)}, name) for _ in range(30)]
        runs += [str(run)] * 30

    def spread(table: tuple[Fault, ...]) -> float:
        return max(abs(table[0].causes[symptom] - table[1].causes[symptom]) for symptom in table[0].causes)

    assert spread(learn_faults(cases, runs)) < 0.5 * spread(learn_faults(cases))


def test_a_field_that_some_cases_lack_is_learned_from_the_others() -> None:
    cases = [({"x": float(number % 2)} if number % 3 else {}, ("a", "b")[number % 2]) for number in range(60)]
    assert set(learn_faults(cases)[0].causes) == {"x>0.5"}


def test_no_case_no_table() -> None:
    with pytest.raises(ValueError, match="there are none"):
        learn_faults([])
