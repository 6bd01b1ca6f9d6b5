"""Experiment 1's events as the product sees them: the shipped domain ``service_robot``, and an identity for each object."""

from __future__ import annotations

from functools import cache

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.learner import Vector
from wakeful.domains import load
from wakeful.domains.service_robot.world import CATEGORIES, CONTEXTS, HISTORIES, LOCATIONS, ROUTES, STATES
from wakeful.experiments.worlds.service_events import DESCRIPTOR, TREATMENTS, Case, Split, World
from wakeful.facts.domain import DomainSpec, FieldSpec
from wakeful.facts.events import Context, Event, Relation, event_id
from wakeful.facts.time import NS_PER_S, Stamp

SOURCE = "service_events"
_RELATIONS = {"none": Relation.NEW, "unchanged": Relation.UNCHANGED, "moved": Relation.MOVED}
_ONE_HOT = {
    "category": CATEGORIES,
    "location": LOCATIONS,
    "state": STATES,
    "history": HISTORIES,
    "route": ROUTES,
    "context": CONTEXTS,
}


@cache
def spec(identity: bool = True) -> DomainSpec:
    """``service_robot`` as it ships, guidelines and all; with ``identity``, a declared field for the descriptor of objects.

    Its guidelines were written for the simulated robot, before this experiment and without its labels.
    """
    shipped = load("service_robot").spec
    if not identity:
        return shipped
    descriptor = FieldSpec(size=DESCRIPTOR, low=-2.0, high=2.0, meaning="what it looks like", compared=False)
    return msgspec.structs.replace(shipped, fields={**shipped.fields, "identity": descriptor})


def events(world: World, split: Split, identity: bool = True) -> tuple[Event, ...]:
    """The split's events, one a second; ids are unique over seeds, variants and splits."""
    digest = f"{world.variant.name}-{world.seed}-{split}"
    return tuple(_event(case, digest, place, identity) for place, case in enumerate(getattr(world, split)))


def _event(case: Case, digest: str, place: int, identity: bool) -> Event:
    at_ns = (place + 1) * NS_PER_S
    return Event(
        id=event_id("robot", digest, place, "object", 0),
        kind="object",
        entity=case.entity,
        source=SOURCE,
        position=place,
        stamp=Stamp(source_ns=at_ns, received_ns=at_ns),
        robot="robot",
        relation=_RELATIONS[case.history],
        fields={
            "category": case.category,
            "location": case.location,
            "state": case.state,
            "route": case.route,
            "load": case.load,
            **({"identity": case.descriptor} if identity else {}),
        },
        context=Context(
            task="delivery" if case.context == "task" else "", safety=case.context == "safety", fields={"context": case.context}
        ),
        truth_treatment=case.truth,
    )


def paper_inputs(cases: tuple[Case, ...]) -> Vector:
    """The inputs of the paper's network, shape (n, 29): the six fields one-hot, load, and the object's descriptor."""
    rows = [
        [
            *(float(getattr(case, name) == value) for name, values in _ONE_HOT.items() for value in values),
            case.load,
            *case.descriptor,
        ]
        for case in cases
    ]
    return np.array(rows)


def labels_of(cases: tuple[Case, ...]) -> npt.NDArray[np.int64]:
    """The right treatments as indices into ``TREATMENTS``, shape (n,)."""
    return np.array([TREATMENTS.index(case.truth) for case in cases])
