"""W's model: trained once with wakeful's own learner, given to wakeful as a published version and to the others folded."""

from __future__ import annotations

from pathlib import Path
from random import Random

import msgspec
import numpy as np

from benchmarks.peers.drafting import draft
from benchmarks.peers.lean import CHOICES, COLUMNS, Floats, Lean, features
from benchmarks.peers.messages import LABELS, TREATMENTS, Event
from wakeful.domains import load as load_domain
from wakeful.facts.events import Event as WakefulEvent
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.time import Stamp
from wakeful.learning.network import views
from wakeful.learning.novelty import Novelty
from wakeful.learning.two_heads import TwoHeads
from wakeful.learning.weights import from_bytes, to_bytes
from wakeful.selection.features import Encoder

DOMAIN = str(Path(__file__).with_name("robot.toml"))
ROWS = 600
EPOCHS = 40

#: Scores of events must lie so far apart that the order of additions cannot change a choice.
MARGIN = 1e-6


def train(events: list[Event], seed: int) -> tuple[ModelCard, bytes, Lean]:
    """The model as wakeful publishes it (card and weights), and folded for everybody else.

    What it learns is the guess of a rule with noise. Its thresholds let every event of W be treated automatically, and the
    reference of its novelty has wider things in it than W: no reasoner takes part in W, in any system.
    """
    encoder = Encoder(load_domain(DOMAIN).spec, TREATMENTS)
    rows = np.array([encoder.encode(_admitted(event)) for event in events[:ROWS]])
    random = Random(seed)
    right = [_right(event, random) for event in events[: len(rows)]]
    learner = TwoHeads()
    card, weights = learner.train(
        TrainingJob(
            training=1,
            base_version=0,
            base_weights=b"",
            watermark=len(rows),
            seed=seed,
            epochs=EPOCHS,
            treatments=TREATMENTS,
            labels=LABELS,
            features=rows,
            treatment=np.array([TREATMENTS.index(name) for name, _ in right]),
            result=np.array([LABELS.index(label) for _, label in right]),
            refuted=np.full(len(rows), -1),
            weight=np.ones(len(rows)),
            held_back=np.arange(len(rows)) % 5 == 0,
            right=np.ones(len(rows), dtype=bool),
        )
    )
    model = from_bytes(weights)
    known = model.novelty
    seen = [known.distance(model.standardise(row)) for row in rows]
    wider = np.full(len(rows) // 10, 3.0 * max(seen))
    model = msgspec.structs.replace(model, novelty=Novelty(known.exemplars, np.sort([*seen, *wider])))
    weights = to_bytes(model)
    card = msgspec.structs.replace(
        card,
        blob="workload-w",
        accepted=True,
        thresholds={"*": 0.0, "@result": 0.0},
        support=dict.fromkeys(TREATMENTS, 100),
    )
    lean = _folded(weights, encoder, events)
    _same(lean, weights, encoder, events[:200])
    return card, weights, lean


def _folded(weights: bytes, encoder: Encoder, events: list[Event]) -> Lean:
    """The same function of the eight fields, without what is constant in W."""
    model = from_bytes(weights)
    parts = views(model.theta, model.shape)
    rate = 1.0 / model.scale
    base = events[0]

    def first(event: Event) -> Floats:
        return np.asarray(((encoder.encode(_admitted(event)) - model.mean) * rate) @ parts.first + parts.first_bias)

    origin = msgspec.structs.replace(
        base, category="item", location="center", state="normal", route="none", load=0.0, x=0.0, y=0.0, context="none"
    )
    bias = first(_named(origin))
    into = np.zeros((COLUMNS, len(bias)))
    at = 0
    for name, choices in zip(("category", "location", "state", "route", "context"), CHOICES, strict=True):
        for value in choices:
            into[at] = first(_named(msgspec.structs.replace(origin, **{name: value}))) - bias
            at += 1
    for name in ("load", "x", "y"):
        into[at] = first(_named(msgspec.structs.replace(origin, **{name: 1.0}))) - bias
        at += 1
    cooling = np.repeat(1.0 / np.array(model.temperatures), (len(TREATMENTS), len(LABELS)))
    return Lean([into, bias, parts.second, parts.second_bias, parts.heads * cooling, parts.heads_bias * cooling])


def _same(lean: Lean, weights: bytes, encoder: Encoder, events: list[Event]) -> None:
    """Refuse a folding that is not the same function."""
    predictor = TwoHeads().load(weights)
    out = lean.logits(features(events))
    for row, event in zip(out, events, strict=True):
        estimate = predictor.estimate(encoder.encode(_admitted(event)))
        for part, own in ((row[: len(TREATMENTS)], estimate.treatments), (row[len(TREATMENTS) :], estimate.labels)):
            shares = np.exp(part - part.max())
            if np.abs(shares / shares.sum() - own).max() > 1e-6:
                raise ValueError(f"the folded model differs from wakeful's on {event.entity}")


def clear(lean: Lean, events: list[Event]) -> bool:
    """Whether no event's choice hangs on the last digits."""
    out = np.sort(lean.logits(features(events))[:, : len(TREATMENTS)], axis=1)
    labels = lean.logits(features(events))[:, len(TREATMENTS) :]
    return bool((out[:, -1] - out[:, -2]).min() > MARGIN and np.abs(labels[:, 0] - labels[:, 1]).min() > MARGIN)


def _named(event: Event) -> Event:
    return msgspec.structs.replace(event, entity=f"{event.category}-00001")


def _admitted(event: Event) -> WakefulEvent:
    offered = draft(event)
    return WakefulEvent(
        id="w",
        kind=offered.kind,
        entity=offered.entity,
        source=offered.source,
        position=0,
        stamp=Stamp(source_ns=event.at_ns),
        fields=offered.fields,
    )


def _right(event: Event, random: Random) -> tuple[str, str]:
    if event.context == "safety" and event.state == "unstable":
        name = "risk_prediction"
    elif event.route == "blocking":
        name = "planning"
    elif event.category == "device":
        name = "diagnosis"
    elif event.category == "unknown":
        name = "analogy"
    else:
        name = "memory" if event.state != "normal" else "description"
    bad = event.state != "normal" and (event.load > 0.5 or event.location == "edge")
    if random.random() < 0.1:
        name, bad = random.choice(TREATMENTS), not bad
    return name, LABELS[bad]
