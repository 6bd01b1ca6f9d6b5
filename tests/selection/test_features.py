"""Encoding events as numbers."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.domain import DetectorSpec, DomainSpec, FieldSpec
from wakeful.facts.events import Condition, Context, Event, Phase, Relation
from wakeful.facts.time import Stamp
from wakeful.facts.values import Field
from wakeful.selection.features import Encoder

SPEC = DomainSpec(
    name="arm",
    version=1,
    says="an arm",
    fields={
        "state": FieldSpec(values=("normal", "unstable")),
        "load": FieldSpec(low=0.0, high=10.0),
        "trace": FieldSpec(low=-1.0, high=1.0, size=3),
        "flat": FieldSpec(low=1.0, high=1.0),
    },
    detect=(DetectorSpec(detector="band", kind="current_left_band"),),
)
ENCODER = Encoder(SPEC, ("description", "planning"))


def event(fields: dict[str, Field] | None = None, **more: object) -> Event:
    base: dict[str, object] = {
        "id": "e", "kind": "current_left_band", "entity": "joint_3", "source": "s", "position": 0, "stamp": Stamp(source_ns=0),
    }  # fmt: skip
    return Event(**{**base, "fields": fields or {}, **more})  # type: ignore[arg-type]


def column(name: str, row: np.ndarray) -> float:
    return float(row[ENCODER.columns.index(name)])


def test_every_event_gets_the_same_length_and_every_column_has_a_name() -> None:
    assert len(ENCODER.columns) == ENCODER.size == len(ENCODER.encode(event()))
    assert len(set(ENCODER.columns)) == ENCODER.size
    assert sorted(at for group in ENCODER.groups.values() for at in group) == list(range(ENCODER.size))


def test_a_declared_value_is_one_hot_and_an_undeclared_one_is_other() -> None:
    row = ENCODER.encode(event({"state": "unstable"}))
    assert column("state=unstable", row) == 1.0
    assert column("state=normal", row) == column("state missing", row) == column("state other", row) == 0.0
    row = ENCODER.encode(event({"state": "melted"}))
    assert column("state other", row) == 1.0
    assert row[[name.startswith("other fields") for name in ENCODER.columns]].sum() == 1.0


@pytest.mark.parametrize(
    ("value", "scaled", "missing"),
    [
        (5, 0.5, 0.0),
        (True, 0.1, 0.0),
        (25.0, 2.0, 0.0),
        (-1e300, -1.0, 0.0),
        (math.inf, 2.0, 0.0),
        (10**400, 2.0, 0.0),
        (None, 0.0, 1.0),
        (math.nan, 0.0, 1.0),
        ("heavy", 0.0, 1.0),
    ],
)
def test_a_number_is_scaled_by_its_range_and_clipped_outside(value: Field, scaled: float, missing: float) -> None:
    row = ENCODER.encode(event({"load": value}))
    assert column("load", row) == pytest.approx(scaled)
    assert column("load missing", row) == missing


def test_a_range_without_width_gives_zero() -> None:
    assert column("flat", ENCODER.encode(event({"flat": 7.0}))) == 0.0


def test_a_vector_field_has_a_column_for_each_number() -> None:
    row = ENCODER.encode(event({"trace": (-1.0, math.nan, 1.0, 9.0)}))
    assert [column(f"trace[{i}]", row) for i in range(3)] == [0.0, 0.0, 1.0]
    assert column("trace missing", row) == 1.0
    assert column("trace missing", ENCODER.encode(event({"trace": (0.0, 0.0, 0.0)}))) == 0.0


def test_a_field_of_the_context_stands_in_where_the_event_has_none_of_that_name() -> None:
    context = Context(fields={"load": 10.0, "visitors": 4})
    assert column("load", ENCODER.encode(event(context=context))) == 1.0
    assert column("load", ENCODER.encode(event({"load": 0.0}, context=context))) == 0.0


def test_context_relation_criticality_and_condition_each_change_the_features() -> None:
    plain = ENCODER.encode(event())
    for other in (
        event(context=Context(task="deliver")),
        event(context=Context(zone="B")),
        event(context=Context(safety=True)),
        event(relation=Relation.MOVED),
        event(criticality=3),
        event(condition=Condition(key="k", phase=Phase.RAISED)),
        event(kind="something_else"),
        event({"undeclared": 3.0}),
        event({"undeclared": "yes"}),
    ):
        assert (ENCODER.encode(other) != plain).any(), other


def test_things_met_are_encoded_by_their_class_and_parts_of_the_robot_by_their_number() -> None:
    assert (ENCODER.encode(event(entity="pallet-0042")) == ENCODER.encode(event(entity="pallet-1377"))).all()
    rows = {ENCODER.encode(event(entity=f"joint_{i}")).tobytes() for i in range(6)}
    assert len(rows) > 1


def test_the_version_follows_what_the_columns_mean() -> None:
    assert Encoder(SPEC, ("description", "planning")).version == ENCODER.version
    assert Encoder(SPEC, ("description",)).version != ENCODER.version
    wider = DomainSpec(name="arm", version=1, says="", fields={**SPEC.fields, "load": FieldSpec(low=0.0, high=20.0)})
    assert Encoder(wider, ("description", "planning")).version != ENCODER.version


def test_buckets_are_the_same_in_another_process_with_another_hash_seed() -> None:
    code = "from wakeful.selection.features import bucket; print([bucket(t, 16) for t in ('a=1', 'zone', 'ü', '')])"
    runs = [
        subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path)},
            check=True,
            capture_output=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert runs[0] == runs[1]


FIELDS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=200), st.lists(st.floats(), max_size=5).map(tuple)
)
NAMES = st.one_of(st.sampled_from([*SPEC.fields, "kind", "other"]), st.text(max_size=20))


@given(st.dictionaries(NAMES, FIELDS, max_size=12), st.dictionaries(NAMES, FIELDS, max_size=6), st.text(max_size=30), st.text())
def test_whatever_an_event_carries_its_features_are_finite_small_and_repeatable(
    fields: dict[str, Field], context: dict[str, Field], kind: str, entity: str
) -> None:
    one = event(fields, context=Context(fields=context, task=entity, zone=kind), kind=kind, entity=entity)
    row = ENCODER.encode(one)
    assert np.isfinite(row).all()
    assert (np.abs(row) <= 2.0).all()
    assert (Encoder(SPEC, ("description", "planning")).encode(one) == row).all()
