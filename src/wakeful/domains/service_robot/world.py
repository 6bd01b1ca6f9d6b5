"""The building, its objects, and what is true of an encounter with one: the right treatment, and what it needs.

The robot never sees this module's truths; the simulator carries them beside its observations, for accuracy only. Distributions,
labelling rule and outcomes are those of the paper's Experiments 1 and 3 (Section V).
"""

from __future__ import annotations

from random import Random
from typing import Protocol

import msgspec

CATEGORIES = {"item": 0.38, "obstacle": 0.26, "device": 0.24, "unknown": 0.12}
LOCATIONS = {"center": 0.25, "edge": 0.35, "route": 0.20, "storage": 0.20}
STATES = {"normal": 0.32, "unstable": 0.38, "abnormal": 0.30}
HISTORIES = {"unchanged": 0.42, "moved": 0.26, "none": 0.32}
ROUTES = {"none": 0.32, "outside": 0.32, "blocking": 0.36}
CONTEXTS = {"none": 0.44, "task": 0.28, "safety": 0.28}

HEAVY = 0.6
"""The share of its carrying capacity above which a load counts."""

PLACES: dict[str, tuple[str, float, float]] = {
    "hall": ("center", 10.0, 10.0),
    "workshop": ("center", 22.0, 10.0),
    "reception": ("center", 10.0, 22.0),
    "loading_ramp": ("edge", 2.0, 2.0),
    "mezzanine": ("edge", 30.0, 2.0),
    "stairwell": ("edge", 30.0, 22.0),
    "dock_edge": ("edge", 2.0, 12.0),
    "corridor_a": ("route", 16.0, 10.0),
    "corridor_b": ("route", 10.0, 16.0),
    "crossing": ("route", 16.0, 16.0),
    "shelf_north": ("storage", 22.0, 22.0),
    "shelf_south": ("storage", 16.0, 2.0),
    "cold_store": ("storage", 2.0, 22.0),
}
"""Each place with its kind of location and its position in metres."""


class Thing(msgspec.Struct, kw_only=True):
    """An object as it stands in the building, ``x`` and ``y`` metres from the middle of its place."""

    identity: str
    category: str
    place: str
    x: float
    y: float
    state: str
    route: str
    load: float
    seen: bool = False
    truth: str = ""
    """The right treatment of the latest encounter with it."""


class Encounter(msgspec.Struct, frozen=True, kw_only=True):
    """The fields of one event, as the paper's simulator draws them."""

    category: str
    location: str
    state: str
    history: str
    route: str
    load: float
    context: str


def draw(random: Random, shares: dict[str, float]) -> str:
    """One key, with the probability of its value."""
    return random.choices(list(shares), list(shares.values()))[0]


class Met(Protocol):
    """What the labelling rule looks at."""

    @property
    def category(self) -> str: ...
    @property
    def location(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def history(self) -> str: ...
    @property
    def route(self) -> str: ...
    @property
    def load(self) -> float: ...
    @property
    def context(self) -> str: ...


def right_treatment(met: Met, boundary: float = HEAVY) -> str:
    """The treatment that fits: the first active cue in the order of the context (Experiment 1's labelling rule).

    ``boundary``: the load above which the object counts as heavy.
    """
    heavy = met.load > boundary
    cues = {
        "risk_prediction": met.state == "unstable" and (met.location == "edge" or (met.context == "safety" and heavy)),
        "planning": met.context != "none"
        and (met.route == "blocking" or (met.context == "task" and met.route == "outside" and heavy)),
        "diagnosis": met.category == "device" and met.state == "abnormal",
        "analogy": met.category == "unknown" and met.history == "none",
        "memory": met.history == "moved",
    }
    return next((cue for cue in _ORDER[met.context] if cues[cue]), "description")


_ORDER = {
    "none": ("risk_prediction", "diagnosis", "analogy", "memory"),
    "task": ("planning", "risk_prediction", "diagnosis", "analogy", "memory"),
    "safety": ("risk_prediction", "diagnosis", "planning", "analogy", "memory"),
}


class Signature(msgspec.Struct, frozen=True, kw_only=True):
    """A group of encounters whose outcome the environment may turn round (Experiment 3's signatures A to D)."""

    name: str
    says: str

    def holds(self, met: Encounter) -> bool:
        """Whether the encounter belongs to it."""
        match self.name:
            case "A":
                return met.category == "item" and met.location == "center" and met.state == "normal"
            case "B":
                return met.category == "obstacle" and met.route == "blocking"
            case "C":
                return met.category == "item" and met.history == "moved"
            case _:
                return met.category == "device" and met.state == "abnormal"


SIGNATURES = (
    Signature(name="A", says="normal items in the middle of a room"),
    Signature(name="B", says="obstacles that block a route"),
    Signature(name="C", says="items that were moved"),
    Signature(name="D", says="abnormal devices"),
)


def needed(met: Encounter, turned: frozenset[str]) -> str:
    """What the encounter turned out to need: intervention when its state isn't normal, the reverse where a signature that
    the environment has turned round holds."""
    needs = met.state != "normal"
    if any(signature.name in turned and signature.holds(met) for signature in SIGNATURES):
        needs = not needs
    return "intervention" if needs else "none"
