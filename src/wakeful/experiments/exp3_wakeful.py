"""Experiment 3's ``wakeful``: the product's encoder, learner, selector, exemplar memory and recent experience, as they ship.

The rule is one for all variants. What is sufficiently similar to a validated experience is decided by memory, what is not by the
model, and what is of a type never met by the reasoner. How much one contradiction counts for follows from how reliable
validations have proved so far.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from hashlib import blake2b

import msgspec
import numpy as np

from wakeful.contracts.learner import Learner, Predictor
from wakeful.experiments.exp1_events import spec as objects
from wakeful.experiments.exp3_baselines import Said
from wakeful.experiments.exp3_reasoner import DriftReasoner
from wakeful.experiments.worlds.service_drift import NOVEL, OUTCOMES, PRETRAINING, DriftWorld, Met
from wakeful.experiments.worlds.service_events import TREATMENTS
from wakeful.facts.decisions import Decision
from wakeful.facts.domain import DomainSpec, FieldSpec
from wakeful.facts.events import Context, Event, Relation
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.lines import Decided, Gained, Published, TrainingAsked
from wakeful.facts.time import NS_PER_S, Stamp
from wakeful.learning.belief import Expected
from wakeful.learning.exemplars import Exemplars
from wakeful.learning.plan import Learning, LearningSettings
from wakeful.learning.pooled import Pooled
from wakeful.learning.recent import Recent
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.recalled import with_memory
from wakeful.selection.selector import Selector

#: The reasoner is right on little more than half of the events, treatment and outcome together: what the model holds to be
#: likelier than not is left to it. What is unlike anything met is told by its type, so that distance says nothing more.
GATE = SelectionSettings(thresholds="fixed", confidence=0.5, result_confidence=0.5, novelty_limit=1.0)

PLAN = LearningSettings(held_back=0.0, every=64, growth=0.0, contradiction_counts=1)
"""A new model version after 64 validations, from all of them: what cannot wait is memory's. Nothing is held back of so few."""
_RELATIONS = {"none": Relation.NEW, "unchanged": Relation.UNCHANGED, "moved": Relation.MOVED}


@cache
def spec() -> DomainSpec:
    """The shipped ``service_robot`` with Experiment 1's identities, this experiment's outcomes, and a field for new types."""
    base = objects()
    kind = FieldSpec(values=("none", *(f"type {number}" for number in range(1, NOVEL + 1))), meaning="its type, where it is new")
    outcome = msgspec.structs.replace(base.outcome, labels=OUTCOMES)
    return msgspec.structs.replace(base, fields={**base.fields, "type": kind}, outcome=outcome)


def event(met: Met, number: int) -> Event:
    """The event as registration would have it."""
    case = met.case
    return Event(
        id=f"event {number}",
        kind="object",
        entity=case.category,
        source="service_drift",
        position=number,
        stamp=Stamp(source_ns=number * NS_PER_S, received_ns=number * NS_PER_S),
        relation=_RELATIONS[case.history],
        fields={
            "category": case.category,
            "location": case.location,
            "state": case.state,
            "route": case.route,
            "load": case.load,
            "identity": case.descriptor,
            "type": f"type {met.novel}" if met.novel else "none",
        },
        context=Context(
            task="delivery" if case.context == "task" else "", safety=case.context == "safety", fields={"context": case.context}
        ),
    )


class Once:
    """A learner that trains an equal job once: three of the variants begin with the same materials.

    Args:
        learner: whose trainings they are; the same job gives the same bytes.
    """

    def __init__(self, learner: Learner) -> None:
        self.name = learner.name
        self._learner = learner
        self._done: dict[bytes, tuple[ModelCard, bytes]] = {}

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        """As the learner does."""
        told = (getattr(job, name) for name in job.__struct_fields__)
        parts = [each.tobytes() if isinstance(each, np.ndarray) else repr(each).encode() for each in told]
        key = blake2b(b"|".join(parts)).digest()
        if key not in self._done:
            self._done[key] = self._learner.train(job)
        return self._done[key]

    def load(self, weights: bytes) -> Predictor:
        """As the learner does."""
        return self._learner.load(weights)


class Wakeful:
    """One mind: the rooms from selection to learning, without the kernel's processes, which this experiment doesn't vary.

    Args:
        world: its materials are the mind's experience before the stream.
        learner: of the model.
        expected: memory's, where it is not what ships.
    """

    def __init__(self, world: DriftWorld, learner: Learner | None = None, expected: Expected | None = None) -> None:
        self._reasoner = DriftReasoner(world)
        self._learner = learner or Pooled()
        self._selector = Selector(spec(), TREATMENTS, self._learner, GATE)
        self.memory = Exemplars(self._selector.encode, TREATMENTS, OUTCOMES, expected=expected)
        self.recent = Recent(self._selector.encode, self._selector.encode_many, OUTCOMES)
        plan = msgspec.structs.replace(PLAN, seed=world.seed)
        self._learning = Learning(spec(), TREATMENTS, self._learner, self._selector.encode, plan)
        self._met = np.zeros(self._selector.encoder.size, dtype=np.bool_)
        self._events: dict[int, Event] = {}
        self._weights = b""
        for number, met in enumerate(world.pretraining, 1):
            self._gain(met, event(met, number))
        first = self._learning.due(0)
        if first is not None:
            self._train(first)

    def decide(self, place: int, met: Met) -> Said:
        """The selector's decision with memory's say; the reasoner's where it is not automatic."""
        own = event(met, PRETRAINING + 1 + place)
        decision = self._decision(own)
        self._events[place] = own
        decided = Decided(process=own.position, event=own.id, decision=decision)
        self.memory.apply(decided)
        self.recent.apply(decided)
        label = _likeliest(decision)
        if decision.mode == "auto":
            treatment, outcome = TREATMENTS.index(decision.treatment), OUTCOMES.index(label)
        else:
            treatment, outcome = self._reasoner.answer(place, met)
        return Said(treatment=treatment, outcome=outcome, mode=decision.mode, trust=decision.prior[OUTCOMES[outcome]])

    def learn(self, place: int, met: Met, said: Said) -> None:
        """The validation of an event of the stream: at once in memory, and from time to time a new model version."""
        self._reasoner.hear(met)
        self._gain(met, self._events[place], said)
        asked = self._learning.due(0)
        if asked is not None:
            self._train(asked)

    def accuracy(self, events: Sequence[Met]) -> float:
        """How much of these it would get right by itself, treatment and outcome together, in percent; nothing is learned."""
        right = 0
        for met in events:
            decision = self._decision(event(met, 0))
            right += decision.treatment == met.case.truth and _likeliest(decision) == OUTCOMES[met.outcome]
        return 100.0 * right / len(events)

    def _decision(self, own: Event) -> Decision:
        features = self._selector.encode(own)
        card = self._selector.card
        seen = alone = self._selector.see(own)
        if seen is not None and self.recent.heard:
            seen = self._selector.joined(seen, self.recent.join(seen[2], features))
        decision = self._selector.decide(own, {}, (), card.watermark if card is not None else 0, seen)
        if seen is not alone and alone is not None:
            decision = msgspec.structs.replace(decision, foretold=self._selector.forecast(alone))
        if ((features != 0.0) & ~self._met).any():
            # A value that was never met before: a new type.
            decision = msgspec.structs.replace(decision, mode="fallback")
        sure = decision.mode == "auto" and not self.memory.contested(features, self._selector.predictor)
        if sure or self.recent.outdoes_memory:
            return decision
        return with_memory(decision, self.memory.recall(features, self._selector.predictor))

    def _gain(self, met: Met, own: Event, said: Said | None = None) -> None:
        right = said is None or said.outcome == met.told
        experience = Experience(
            id=self._learning.watermark + 1,
            event=own.id,
            process=own.position,
            treatment=met.case.truth if said is None else TREATMENTS[said.treatment],
            treatment_label=met.case.truth,
            predicted=OUTCOMES[met.told if said is None else said.outcome],
            outcome=OUTCOMES[met.told],
            verdict=Verdict.SUPPORTED if right else Verdict.CONTRADICTED,
            mode="delib" if said is None else said.mode,
        )
        self._met |= self._selector.encode(own) != 0.0
        self._learning.apply(Gained(experience=experience), own)
        self.memory.apply(Gained(experience=experience), own)
        self.recent.gain(experience, own)

    def _train(self, asked: TrainingAsked) -> None:
        self._learning.apply(asked)
        card, self._weights = self._learner.train(self._learning.job(asked, self._weights))
        self._selector.use(card, self._weights)
        self._learning.apply(Published(training=asked.training, card=card))


def _likeliest(decision: Decision) -> str:
    return max(decision.prior, key=lambda name: decision.prior[name])
