"""Experiment 1's world: events of a service robot, each with the treatment that is right for it (Sec. IV-A).

The paper states the sizes, what an event has, what each treatment is for, and that the objects of training, calibration and test
are disjoint. Its probabilities and its labelling rule are not published: these were looked for with the paper's baselines alone
(`docs/experiments.md` has each choice and why). An event's label is the first active cue in its context's order, else
description.
"""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np

from wakeful.domains.service_robot.world import (
    CATEGORIES,
    CONTEXTS,
    HEAVY,
    HISTORIES,
    LOCATIONS,
    ROUTES,
    STATES,
    right_treatment,
)
from wakeful.facts.values import Fact

TREATMENTS = ("description", "memory", "risk_prediction", "planning", "diagnosis", "analogy")
"""The paper's six, in the order of the network's outputs."""

BOUNDARY = HEAVY
"""Above this load an unstable object is a risk in a safety context, and one beside the route matters to a task."""
DESCRIPTOR = 8
OBJECTS = {"training": 60, "calibration": 12, "test": 24}
"""Identities per category, disjoint."""

Split = Literal["training", "calibration", "test"]
Part = Literal["pair", "plain_unknown", "odd_unknown", "random"]
"""Which part of the workload an event belongs to. The two unknown objects are singletons: one normal, one abnormal."""


class Variant(Fact, frozen=True):
    """One declared form of the world.

    ``noise``: the share of random events whose label is replaced by another one. ``hard``: in how many of a kind's four test
    pairs (all but memory) the harmless member stands in the same context as the other one; for risk and planning it then lies
    ``below`` the load boundary. ``descriptor``: the standard deviation of an identity's eight numbers. ``moves``: by how much
    an identity's first number moves its boundary.
    """

    name: str
    noise: float = 0.0
    hard: int = 3
    below: float = 0.08
    descriptor: float = 0.55
    moves: float = 0.0


A = Variant(name="A")
B = Variant(name="B", noise=0.02, hard=2, below=0.05, descriptor=0.30)
C = Variant(name="C", moves=0.15)
VARIANTS = (A, B, C)


class Case(Fact, frozen=True):
    """One event with what only the world knows of it: ``truth``, the right treatment, and ``ruled``, what it was before noise."""

    part: Part
    category: str
    location: str
    state: str
    history: str
    route: str
    context: str
    load: float
    descriptor: tuple[float, ...]
    entity: str
    truth: str
    ruled: str
    pair: int = -1

    @property
    def structured(self) -> bool:
        """Whether it is one of the contextual contrasts or of the two unknown objects."""
        return self.part != "random"

    @property
    def task_safety(self) -> bool:
        """Whether the robot's task or somebody's safety is touched."""
        return self.context != "none"


class World(Fact, frozen=True):
    """One seed's events, by split, in the order in which they come."""

    variant: Variant
    seed: int
    training: tuple[Case, ...]
    calibration: tuple[Case, ...]
    test: tuple[Case, ...]


_PAIRS = {"training": 1, "calibration": 2, "test": 4}
"""Pairs of each kind."""
_HARD_OF = 4
_RANDOM = {"training": 258, "calibration": 24, "test": 48}
_STREAM = {"training": 1, "calibration": 2, "test": 3}
_FIRST_NUMBER = {"training": 0, "calibration": 60, "test": 72}
"""Where a split's objects begin in their category's numbering: a name doesn't say which split it is of."""
_ASIDE = {"location": "center", "state": "normal", "route": "none", "context": "none"}

_Object = tuple[str, int]
_Looks = dict[str, str]


def world(variant: Variant, seed: int) -> World:
    """The world of one seed: 268 training, 42 calibration and 82 test events (34 structured, 48 random).

    All variants draw the same fields for one seed, so that they differ in nothing but what their parameters say.
    """
    return World(
        variant=variant,
        seed=seed,
        training=_Drawing(variant, seed, "training").cases(),
        calibration=_Drawing(variant, seed, "calibration").cases(),
        test=_Drawing(variant, seed, "test").cases(),
    )


class _Drawing:
    """The drawing of one split's events: its own objects and its own stream of random numbers."""

    def __init__(self, variant: Variant, seed: int, split: Split) -> None:
        self._variant, self._split = variant, split
        self._random = np.random.default_rng((seed, _STREAM[split]))
        # Noise has a stream of its own, so that a variant without it draws the same fields.
        self._noise = np.random.default_rng((seed, _STREAM[split], 1))
        shape = (OBJECTS[split], DESCRIPTOR)
        self._objects = {name: np.round(self._random.normal(size=shape) * variant.descriptor, 6) for name in CATEGORIES}

    def cases(self) -> tuple[Case, ...]:
        """The split's events: pairs, the two unknown objects, then random ones."""
        count = _PAIRS[self._split]
        hard = round(self._variant.hard * count / _HARD_OF)
        found: list[Case] = []
        for contrast in (self._risk, self._planning, self._diagnosis, self._memory):
            for place in range(count):
                pair = len(found) // 2
                found += [self._case("pair", of, looks, load, pair) for of, looks, load in contrast(place < hard)]
        unknown = {**_ASIDE, "history": "none"}
        found.append(self._case("plain_unknown", self._object("unknown"), unknown))
        found.append(self._case("odd_unknown", self._object("unknown"), {**unknown, "state": "abnormal"}))
        return (*found, *(self._random_case() for _ in range(_RANDOM[self._split])))

    def _risk(self, hard: bool) -> _Contrast:
        """An item in the middle of a surface, against the same one unstable at an edge with people near."""
        item, quiet = self._object("item"), self._quiet()
        near = {**quiet, "state": "unstable", "context": "safety"}
        mild = (item, near, self._under(item)) if hard else (item, quiet, None)
        return mild, (item, {**near, "location": "edge"}, None)

    def _planning(self, hard: bool) -> _Contrast:
        """An obstacle in storage outside the route, against the same one blocking the route of a task."""
        obstacle, quiet = self._object("obstacle"), self._quiet()
        outside = {**quiet, "location": "storage", "route": "outside"}
        beside = {**outside, "context": "task" if hard else "safety"}
        mild = (obstacle, beside, self._under(obstacle) if hard else None)
        return mild, (obstacle, {**quiet, "location": "route", "route": "blocking", "context": "task"}, None)

    def _diagnosis(self, hard: bool) -> _Contrast:
        """A device that works, against the same one behaving abnormally during a task."""
        device, quiet = self._object("device"), self._quiet()
        during = {**quiet, "context": "task"}
        return (device, during if hard else quiet, None), (device, {**during, "state": "abnormal"}, None)

    def _memory(self, _hard: bool) -> _Contrast:
        """An item where it was, against the same one unexpectedly moved."""
        item = self._object("item")
        return (item, {**_ASIDE, "history": "unchanged"}, None), (item, {**_ASIDE, "history": "moved"}, None)

    def _random_case(self) -> Case:
        of = self._object(self._draw(CATEGORIES))
        looks = {
            "location": self._draw(LOCATIONS),
            "state": self._draw(STATES),
            "history": self._draw(HISTORIES),
            "route": self._draw(ROUTES),
            "context": self._draw(CONTEXTS),
        }
        case = self._case("random", of, looks)
        replaced, other = self._noise.random() < self._variant.noise, int(self._noise.integers(len(TREATMENTS) - 1))
        wrong = [name for name in TREATMENTS if name != case.truth][other]
        return msgspec.structs.replace(case, truth=wrong) if replaced else case

    def _case(self, part: Part, of: _Object, looks: _Looks, load: float | None = None, pair: int = -1) -> Case:
        drawn = round(float(self._random.random()), 6)
        category, number = of
        case = Case(
            part=part,
            category=category,
            location=looks["location"],
            state=looks["state"],
            history=looks["history"],
            route=looks["route"],
            context=looks["context"],
            load=drawn if load is None else load,
            descriptor=tuple(float(value) for value in self._objects[category][number]),
            entity=f"{category}-{_FIRST_NUMBER[self._split] + number:02d}",
            truth="",
            ruled="",
            pair=pair,
        )
        right = right_treatment(case, self._boundary(of))
        return msgspec.structs.replace(case, truth=right, ruled=right)

    def _object(self, category: str) -> _Object:
        return category, int(self._random.integers(OBJECTS[self._split]))

    def _boundary(self, of: _Object) -> float:
        category, number = of
        return BOUNDARY + self._variant.moves * float(self._objects[category][number][0])

    def _under(self, of: _Object) -> float:
        return round(self._boundary(of) - self._variant.below, 6)

    def _quiet(self) -> _Looks:
        return {**_ASIDE, "history": ("unchanged", "none")[int(self._random.integers(2))]}

    def _draw(self, values: dict[str, float]) -> str:
        return list(values)[int(self._random.choice(len(values), p=list(values.values())))]


_Contrast = tuple[tuple[_Object, _Looks, float | None], tuple[_Object, _Looks, float | None]]
"""Both members of a pair: the object, how it stands, and its load where that is not drawn."""
