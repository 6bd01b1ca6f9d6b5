"""A batch of events is encoded to the rows that each event has by itself."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.domain import DetectorSpec, DomainSpec, FieldSpec
from wakeful.facts.events import Condition, Context, Draft, Phase, Relation
from wakeful.selection.batch import BatchEncoder
from wakeful.selection.features import Encoder

SPEC = DomainSpec(
    name="bench",
    version=1,
    says="a bench",
    fields={
        "category": FieldSpec(values=("item", "device")),
        "state": FieldSpec(values=("normal", "odd")),
        "load": FieldSpec(low=0.0, high=1.0),
        "flat": FieldSpec(low=2.0, high=2.0),
        "place": FieldSpec(low=-2.0, high=2.0, size=3),
    },
    detect=(DetectorSpec(detector="band", kind="seen"),),
)
ENCODER = Encoder(SPEC, ("memory",))
BATCH = BatchEncoder(ENCODER)

categories = st.sampled_from(["item", "device"]) | st.sampled_from(["other", 7, True, None, float("nan"), (1.0, 2.0)])
numbers = st.floats(-3, 3) | st.sampled_from([0, 1, True, "0.5", None, 10**400, float("inf"), float("nan"), (0.5,), 1e301])
places = st.lists(st.floats(-3, 3) | st.sampled_from([float("nan"), float("inf"), 1e301]), max_size=4).map(tuple)
plain = st.fixed_dictionaries(
    {
        "category": st.sampled_from(["item", "device"]),
        "state": st.sampled_from(["normal", "odd"]),
        "load": st.floats(-3, 3),
        "flat": st.integers(-3, 3),
        "place": st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.integers(-3, 3)),
    }
)
odd = st.dictionaries(st.sampled_from(["category", "state", "load", "flat", "place", "new"]), categories | numbers | places)
contexts = st.just(Context()) | st.builds(
    Context,
    task=st.sampled_from(["", "pick 12"]),
    zone=st.sampled_from(["", "hall"]),
    safety=st.booleans(),
    fields=st.dictionaries(st.sampled_from(["load", "light"]), st.floats(0, 1), max_size=2),
)
drafts = st.builds(
    Draft,
    kind=st.sampled_from(["seen", "heard"]),
    entity=st.sampled_from(["pallet-0042", "pallet-7", "cafe12", "a-b-12", "joint_3", "x" * 120 + "-12", "é-٣٤"]),
    source=st.just("s"),
    position=st.integers(0, 9),
    at_ns=st.just(0),
    relation=st.sampled_from(Relation),
    fields=plain | odd,
    context=contexts,
    condition=st.none() | st.builds(Condition, key=st.just("k"), phase=st.sampled_from(Phase)),
    criticality=st.sampled_from([0, 1, 2, 3]),
)


@given(st.lists(drafts, max_size=8))
def test_each_row_is_that_of_the_event_alone_to_the_last_bit(events: list[Draft]) -> None:
    together = BATCH.encode(events)
    assert together.shape == (len(events), ENCODER.size)
    for row, event in zip(together, events, strict=True):
        assert np.array_equal(row, ENCODER.encode(event))


@given(st.lists(plain, min_size=2, max_size=8))
def test_plain_events_are_written_field_by_field(fields: list[dict[str, float | int | str]]) -> None:
    events = [
        Draft(kind="seen", entity=f"pallet-{i:04d}", source="s", position=i, at_ns=0, fields=f) for i, f in enumerate(fields)
    ]
    together = BATCH.encode(events)
    for row, event in zip(together, events, strict=True):
        assert np.array_equal(row, ENCODER.encode(event))
