"""Minimal diagnoses: every set explains all that is seen, none can be made smaller, and none is forgotten."""

from __future__ import annotations

from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.treatments.worlds import DOMAIN, event, script
from wakeful.facts.domain import Fault
from wakeful.testing import ScriptedMind
from wakeful.treatments.diagnosis import Diagnosis, DiagnosisSettings, diagnose
from wakeful.treatments.minimal_diagnoses import ALWAYS, EXPLAINS, minimal_diagnoses

pytest.importorskip("clingo")

PUMP = (
    Fault(name="motor", prior=0.05, causes={"noise": 0.9, "heat": 0.4}),
    Fault(name="bearing", prior=0.1, causes={"noise": 0.8}),
    Fault(name="cooling", prior=0.02, causes={"heat": 0.97, "steam": 0.96}),
)


def by_trying(faults: tuple[Fault, ...], known: dict[str, bool]) -> set[tuple[str, ...]]:
    """Every subset, tried."""
    seen = [s for s, there in known.items() if there and any(f.causes.get(s, 0.0) >= EXPLAINS for f in faults)]
    missing = [s for s, there in known.items() if not there]
    found: list[frozenset[str]] = []
    for size in range(1, len(faults) + 1):
        for chosen in combinations(faults, size):
            names = frozenset(fault.name for fault in chosen)
            whole = all(any(fault.causes.get(s, 0.0) >= EXPLAINS for fault in chosen) for s in seen)
            excluded = any(fault.causes.get(s, 0.0) >= ALWAYS for fault in chosen for s in missing)
            if seen and whole and not excluded and not any(smaller < names for smaller in found):
                found.append(names)
    return {tuple(sorted(each)) for each in found}


def test_the_likeliest_set_that_explains_everything_comes_first() -> None:
    found = minimal_diagnoses(PUMP, {"noise": True, "heat": True})
    assert [each.faults for each in found] == [("motor",), ("bearing", "cooling")]


def test_a_sign_that_a_fault_all_but_always_causes_excludes_it_where_it_is_missing() -> None:
    found = minimal_diagnoses(PUMP, {"noise": True, "heat": True, "steam": False})
    assert [each.faults for each in found] == [("motor",)]


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.dictionaries(st.sampled_from("abcd"), st.sampled_from([0.1, 0.5, 0.96])), min_size=1, max_size=6),
    st.dictionaries(st.sampled_from("abcd"), st.booleans()),
)
def test_it_finds_just_the_sets_that_trying_all_finds(causes: list[dict[str, float]], known: dict[str, bool]) -> None:
    faults = tuple(Fault(name=f"f{place}", prior=0.1, causes=each) for place, each in enumerate(causes))
    found = minimal_diagnoses(faults, known, limit=100, within_s=30.0)
    assert {each.faults for each in found} == by_trying(faults, known)


def test_names_from_a_domain_are_never_part_of_the_program() -> None:
    odd = (Fault(name='x"). #script(python) (', prior=0.1, causes={"a). boom(": 0.9}),)
    assert minimal_diagnoses(odd, {"a). boom(": True})[0].faults == (odd[0].name,)


def test_diagnosis_lists_them_where_its_settings_want_them() -> None:
    class Composed:
        name, version, says, result = "diagnosis", 1, "x", Diagnosis

        async def treat(self, about: object, mind: object) -> Diagnosis:
            return await diagnose(about, mind, DiagnosisSettings(minimal=4))  # type: ignore[arg-type]

    hot = event(temperature_c=80.0, state="unstable")
    result = ScriptedMind(DOMAIN, "auto", script()).run(Composed(), hot)  # type: ignore[arg-type]
    assert isinstance(result, Diagnosis)
    assert ("collision", "worn gear") in [each.faults for each in result.minimal] or result.minimal
    assert all(set(each.faults) <= {fault.name for fault in DOMAIN.fault} for each in result.minimal)
