"""Experiment 3's world: familiar events, new types, a changed environment, and the new types again (Sec. IV-D).

Its events are Experiment 1's without unknown objects. The paper states the sizes (198 materials before deployment; 28 familiar, 6
novel, 24 changed and 6 reused events), that validation is delayed, and that four learned signatures produce other outcomes
from the change on. The rest was looked for with the paper's baselines alone (`docs/experiments.md` has each choice and why).
"""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.domains.service_robot.world import CATEGORIES, CONTEXTS, HISTORIES, LOCATIONS, ROUTES, STATES, right_treatment
from wakeful.experiments.worlds.service_events import DESCRIPTOR, TREATMENTS, A, Case
from wakeful.facts.values import Fact

OUTCOMES = ("uneventful", "intervention")
"""Whether somebody had to step in: 1 where the state is not normal, until the world changes."""

PRETRAINING, FAMILIAR, NOVEL, REPETITIONS = 198, 28, 6, 6
HELD = 200
"""Further familiar events that are never met, by which forgetting is measured."""
OBJECTS = 60
"""Identities per category."""
FIELDS = {
    "category": tuple(CATEGORIES),
    "location": tuple(LOCATIONS),
    "state": tuple(STATES),
    "history": tuple(HISTORIES),
    "route": tuple(ROUTES),
    "context": tuple(CONTEXTS),
}
INPUTS = sum(len(values) for values in FIELDS.values()) + 1 + DESCRIPTOR + NOVEL
"""One-hot fields, load, the identity's descriptor, and a flag per novel type."""

Stage = Literal["familiar", "novel", "drift", "reuse"]


class Variant(Fact, frozen=True):
    """One declared form of the world.

    ``wrong``: the share of validations that tell the other outcome. ``delay``: the validation of event i is there before event
    i + delay is decided; ``late`` that of the signatures ``late_of``. ``jitter``: by how much the load of a repetition differs at
    most; its identity is then a fresh one each time.
    """

    name: str
    wrong: float = 0.0
    delay: int = 4
    late: int = 4
    late_of: str = "BD"
    jitter: float = 0.0


CLEAN = Variant(name="clean")
NOISY = Variant(name="noisy", wrong=0.10)
LATE = Variant(name="late", late=10)
JITTER = Variant(name="jitter", jitter=0.15)
VARIANTS = (CLEAN, NOISY, LATE, JITTER)


class Signature(Fact, frozen=True):
    """An observable event whose outcome changes; so many copies with the ``old`` and the ``new`` outcome were learned from."""

    name: str
    looks: dict[str, str]
    old: int
    new: int = 0


SIGNATURES = (
    Signature(name="A", looks={"category": "item", "location": "center", "state": "normal"}, old=1, new=3),
    Signature(
        name="B",
        looks={"category": "obstacle", "location": "route", "state": "normal", "route": "blocking", "context": "task"},
        old=5,
    ),
    Signature(name="C", looks={"category": "item", "location": "center", "state": "normal", "history": "moved"}, old=1),
    Signature(name="D", looks={"category": "device", "location": "center", "state": "abnormal", "context": "task"}, old=5),
)
_PLAIN = {"history": "unchanged", "route": "none", "context": "none"}


class Met(Fact, frozen=True):
    """One event with what only the world knows of it: the right treatment (``case.truth``) and the ``outcome``, an index.

    ``novel`` is the number of its type flag, 0 for none. ``wrong``: its validation tells the other outcome. It is there before
    event ``known_from`` of the stream is decided.
    """

    case: Case
    outcome: int
    stage: Stage = "familiar"
    novel: int = 0
    signature: str = ""
    repetition: int = 0
    wrong: bool = False
    known_from: int = 0

    @property
    def treatment(self) -> int:
        """The right treatment's index."""
        return TREATMENTS.index(self.case.truth)

    @property
    def told(self) -> int:
        """The outcome that its validation tells."""
        return 1 - self.outcome if self.wrong else self.outcome

    @property
    def same_as(self) -> str:
        """What it is another occurrence of; empty for an event of its own."""
        return self.signature or (f"novel {self.novel}" if self.novel else "")


class DriftWorld(Fact, frozen=True):
    """One seed's materials and stream, in the order in which they come; ``held`` events are never met."""

    variant: Variant
    seed: int
    pretraining: tuple[Met, ...]
    stream: tuple[Met, ...]
    held: tuple[Met, ...]


def features(met: Met) -> npt.NDArray[np.float64]:
    """What a robot sees of it, shape (INPUTS,)."""
    row = np.zeros(INPUTS)
    at = 0
    for name, values in FIELDS.items():
        row[at + values.index(getattr(met.case, name))] = 1.0
        at += len(values)
    row[at] = met.case.load
    row[at + 1 : at + 1 + DESCRIPTOR] = met.case.descriptor
    if met.novel:
        row[at + DESCRIPTOR + met.novel] = 1.0
    return row


def world(variant: Variant, seed: int) -> DriftWorld:
    """The world of one seed. All variants draw the same events, outcomes and reasoner's luck; only what they declare differs."""
    return _Drawing(variant, seed).world()


class _Drawing:
    """The drawing of one seed, each part from its own stream of random numbers."""

    def __init__(self, variant: Variant, seed: int) -> None:
        self._variant, self._seed = variant, seed
        objects = self._random(0)
        self._objects = {name: np.round(objects.normal(size=(OBJECTS, DESCRIPTOR)) * A.descriptor, 6) for name in CATEGORIES}
        self._jitter = self._random(6)

    def world(self) -> DriftWorld:
        """Materials and stream."""
        draw = self._random(1)
        signatures = [self._signature(each, draw) for each in SIGNATURES]
        copies: list[Met] = []
        for each, met in zip(SIGNATURES, signatures, strict=True):
            # What changed before did so between its copies: the old ones come first.
            copies += [self._again(met) for _ in range(each.old)]
            copies += [self._again(msgspec.structs.replace(met, outcome=1 - met.outcome)) for _ in range(each.new)]
        random = self._random(2)
        rest = self._balanced(random, PRETRAINING - len(copies))
        places = set(random.permutation(PRETRAINING)[: len(copies)].tolist())
        pretraining = tuple((copies if place in places else rest).pop(0) for place in range(PRETRAINING))
        return DriftWorld(
            variant=self._variant,
            seed=self._seed,
            pretraining=pretraining,
            stream=self._stream(signatures),
            held=tuple(self._balanced(self._random(5), HELD)),
        )

    def _stream(self, signatures: list[Met]) -> tuple[Met, ...]:
        novel = [self._novel(self._random(4, number), number) for number in range(1, NOVEL + 1)]
        changed = [
            self._again(msgspec.structs.replace(met, outcome=1 - met.outcome, stage="drift", repetition=repetition))
            for repetition in range(1, REPETITIONS + 1)
            for met in signatures
        ]
        reused = [self._again(msgspec.structs.replace(met, stage="reuse")) for met in novel]
        wrong = self._random(7).random(FAMILIAR + 2 * NOVEL + len(changed)) < self._variant.wrong
        stream = (*self._balanced(self._random(3), FAMILIAR), *novel, *changed, *reused)
        return tuple(
            msgspec.structs.replace(met, wrong=bool(wrong[place]), known_from=place + self._delay(met))
            for place, met in enumerate(stream)
        )

    def _delay(self, met: Met) -> int:
        late = met.stage == "drift" and met.signature in self._variant.late_of
        return self._variant.late if late else self._variant.delay

    def _balanced(self, random: np.random.Generator, count: int) -> list[Met]:
        """Familiar events of which each of the five treatments is right for as many, but for one, in random order."""
        wanted = {name: (count + 4 - place) // 5 for place, name in enumerate(TREATMENTS[:5])}
        found: list[Met] = []
        while len(found) < count:
            met = self._familiar(random)
            if wanted.get(met.case.truth):
                wanted[met.case.truth] -= 1
                found.append(met)
        return [found[place] for place in random.permutation(count).tolist()]

    def _familiar(self, random: np.random.Generator) -> Met:
        return self._met({"category": _draw(random, _KNOWN)}, random)

    def _novel(self, random: np.random.Generator, number: int) -> Met:
        """Something of a type never met before: the last of them is a risk, for the others there is nothing but analogy."""
        risk = number == NOVEL
        met = self._met({"category": "unknown", "history": "none"}, random)
        case = msgspec.structs.replace(met.case, truth=TREATMENTS[2] if risk else TREATMENTS[5])
        return msgspec.structs.replace(met, case=case, stage="novel", novel=number)

    def _signature(self, signature: Signature, random: np.random.Generator) -> Met:
        return msgspec.structs.replace(self._met({**_PLAIN, **signature.looks}, random), signature=signature.name)

    def _met(self, looks: dict[str, str], random: np.random.Generator) -> Met:
        values = {name: looks[name] if name in looks else _draw(random, share) for name, share in _SHARES.items()}
        number = int(random.integers(OBJECTS))
        case = Case(
            part="random",
            category=values["category"],
            location=values["location"],
            state=values["state"],
            history=values["history"],
            route=values["route"],
            context=values["context"],
            load=round(float(random.random()), 6),
            descriptor=tuple(self._objects[values["category"]][number].tolist()),
            entity=f"{values['category']}-{number:02d}",
            truth="",
            ruled="",
        )
        right = right_treatment(case)
        return Met(case=msgspec.structs.replace(case, truth=right, ruled=right), outcome=int(case.state != "normal"))

    def _again(self, met: Met) -> Met:
        """The event once more: the same to the digit, or similar."""
        reach = self._variant.jitter
        if reach == 0.0:
            return met
        load = min(max(met.case.load + float(self._jitter.uniform(-reach, reach)), 0.0), 1.0)
        descriptor = np.round(self._jitter.normal(size=DESCRIPTOR) * A.descriptor, 6)
        case = msgspec.structs.replace(met.case, load=round(load, 6), descriptor=tuple(descriptor.tolist()))
        return msgspec.structs.replace(met, case=case)

    def _random(self, *stream: int) -> np.random.Generator:
        return np.random.default_rng((self._seed, 3, *stream))


def _draw(random: np.random.Generator, shares: dict[str, float]) -> str:
    left = float(random.random()) * sum(shares.values())
    for name, share in shares.items():
        left -= share
        if left < 0.0:
            return name
    return next(reversed(shares))


_KNOWN = {name: share for name, share in CATEGORIES.items() if name != "unknown"}
_SHARES = {
    "category": CATEGORIES,
    "location": LOCATIONS,
    "state": STATES,
    "history": HISTORIES,
    "route": ROUTES,
    "context": CONTEXTS,
}
