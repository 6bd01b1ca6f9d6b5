"""Experiment 1's ``wakeful``: the product's encoder, learner, selector and gate, as they ship."""

from __future__ import annotations

import msgspec
import numpy as np

from wakeful.experiments.exp1_events import events, spec
from wakeful.experiments.exp1_guaranteed import guaranteed, levels
from wakeful.experiments.exp1_methods import Choice, Trial
from wakeful.experiments.worlds.service_events import TREATMENTS
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.pooled import Pooled
from wakeful.learning.pooled_predictor import PooledPredictor
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.selector import Selector

#: Experiment 1 has no outcomes, so that the result head must not be asked for confidence, and no unfamiliar kinds of events.
GATE = SelectionSettings(result_confidence=0.0, novelty_limit=1.0)


def wakeful(given: Trial, identity: bool = True) -> list[Choice]:
    """Learn from the training events, hold back the calibration events, decide for the test events, and ask as the gate says."""
    learner = Pooled()
    selector = Selector(spec(identity), TREATMENTS, learner, GATE)
    card, weights = learner.train(job_of(given, selector, identity))
    selector.use(card, weights)
    found = []
    for event in events(given.world, "test", identity):
        decision = selector.decide(event, {}, (), card.watermark)
        asked = decision.mode == "delib"
        found.append(
            Choice(
                treatment=given.advice.get(event.id, decision.treatment) if asked else decision.treatment,
                learned=decision.treatment,
                automatic=decision.mode == "auto",
                asked=asked,
                confidence=decision.confidence,
            )
        )
    return guaranteed(found, levels(_told(given, selector, identity), given.world.calibration))


def _told(given: Trial, selector: Selector, identity: bool) -> list[Choice]:
    """What the selector's experts say of the calibration events that have not learned from these: the published ones have."""
    published = selector.predictor
    assert isinstance(published, PooledPredictor)
    blind = PooledPredictor(msgspec.structs.replace(published.model, whole=published.model.tested))
    found = []
    for event in events(given.world, "calibration", identity):
        shares = blind.estimate(selector.encode(event)).treatments
        name = TREATMENTS[int(shares.argmax())]
        found.append(Choice(treatment=name, learned=name, confidence=round(float(shares.max()), 6)))
    return found


def job_of(given: Trial, selector: Selector, identity: bool = True) -> TrainingJob:
    """The training as the kernel's learning room would make it: calibration events are the held-back rows, and the reasoner's
    answers to them are validated."""
    learned, kept = events(given.world, "training", identity), events(given.world, "calibration", identity)
    n = len(learned) + len(kept)
    none = np.full(n, -1)
    truth = np.array([TREATMENTS.index(event.truth_treatment or "") for event in (*learned, *kept)])
    said = [given.advice.get(event.id, "") for event in (*learned, *kept)]
    advised = np.array([TREATMENTS.index(name) if name in TREATMENTS else -1 for name in said])
    return TrainingJob(
        training=1,
        base_version=0,
        base_weights=b"",
        watermark=n,
        seed=given.world.seed,
        epochs=140,
        treatments=TREATMENTS,
        labels=selector.spec.outcome.labels,
        features=np.stack([selector.encode(event) for event in (*learned, *kept)]),
        treatment=truth,
        result=none,
        refuted=none,
        weight=np.ones(n),
        held_back=np.arange(n) >= len(learned),
        right=np.concatenate([np.ones(len(learned), dtype=np.bool_), advised[len(learned) :] == truth[len(learned) :]]),
        advised=advised,
    )
