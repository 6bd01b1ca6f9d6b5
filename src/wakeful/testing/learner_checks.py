"""The contract that every learner keeps, tried on a small problem that can be learned."""

from __future__ import annotations

import msgspec
import numpy as np

from wakeful.contracts.learner import Estimate, Learner, Predictor, Vector
from wakeful.facts.inputs import TrainingJob
from wakeful.testing.broken import ContractBroken, require

_TREATMENTS = ("description", "diagnosis", "planning")
_LABELS = ("none", "stop")


def check_learner(learner: Learner, rows: int = 60, epochs: int = 30, seed: int = 0) -> Predictor:
    """Train twice from scratch and once more on top, load, and estimate.

    Checked: the same job gives the same bytes and card; the job's arrays are unchanged; estimates are probabilities of the
    right shape, rounded to 9 digits, and the same one by one as together; a training goes on from its base; bytes that are no
    model are refused with ValueError.

    Returns:
        The predictor, for further checks of one's own.

    Raises:
        ContractBroken: it does not keep its contract.
    """
    require(bool(learner.name), "a learner needs a name")
    job = training_job(rows, epochs, seed)
    before = [np.array(array, copy=True) for array in _arrays(job)]
    card, weights = learner.train(job)
    require(learner.train(job) == (card, weights), f"{learner.name}: the same job gave another model")
    same = all(np.array_equal(old, new, equal_nan=True) for old, new in zip(before, _arrays(job), strict=True))
    require(same, f"{learner.name}: training changed the job's arrays")
    require(card.watermark == job.watermark and card.seed == seed, f"{learner.name}: the card is not of this job")
    require(card.version != job.base_version or card.base == job.base_version, f"{learner.name}: the card has no lineage")

    predictor = learner.load(weights)
    require(set(predictor.treatments) <= set(_TREATMENTS), f"{learner.name}: knows treatments that the job did not name")
    require(set(predictor.labels) <= set(_LABELS), f"{learner.name}: knows labels that the job did not name")
    features: Vector = np.asarray(job.features, dtype=np.float64)
    one_by_one = [predictor.estimate(row) for row in features[:5]]
    for alone, together in zip(one_by_one, predictor.estimate_many(features)[:5], strict=True):
        _check_estimate(alone, predictor, learner.name)
        equal = np.array_equal(alone.treatments, together.treatments) and np.array_equal(alone.labels, together.labels)
        require(equal and alone.novelty == together.novelty, f"{learner.name}: an estimate depends on what it is batched with")
    far = predictor.estimate(features[0] + 1e3)
    require(
        far.novelty >= one_by_one[0].novelty, f"{learner.name}: what is far from all experience is less novel than what is near"
    )

    more = msgspec.structs.replace(job, training=2, base_version=card.version, base_weights=weights)
    learner.load(learner.train(more)[1])
    for junk in (b"", b"junk", weights[: len(weights) // 2]):
        try:
            learner.load(junk)
        except ValueError:
            continue
        raise ContractBroken(f"{learner.name}: loaded {len(junk)} bytes that are no model; it must raise ValueError")
    return predictor


def training_job(rows: int = 60, epochs: int = 30, seed: int = 0) -> TrainingJob:
    """A job whose treatments and labels follow from its features; some rows lack a treatment, some a result."""
    random = np.random.default_rng(seed)
    features = random.normal(size=(rows, 4))
    treatment = np.argmax(features[:, :3], axis=1)
    result = (features[:, 3] > 0.0).astype(np.int64)
    refuted = np.full(rows, -1)
    treatment[::7], refuted[::7] = -1, 0
    result[::9] = -1
    return TrainingJob(
        training=1,
        base_version=0,
        base_weights=b"",
        watermark=rows,
        seed=seed,
        epochs=epochs,
        treatments=_TREATMENTS,
        labels=_LABELS,
        features=features,
        treatment=treatment,
        result=result,
        refuted=refuted,
        weight=np.ones(rows),
        held_back=np.arange(rows) >= rows - rows // 5,
    )


def _arrays(job: TrainingJob) -> list[Vector]:
    every = (job.features, job.treatment, job.result, job.refuted, job.weight, job.held_back)
    return [np.asarray(array, dtype=np.float64) for array in every]


def _check_estimate(estimate: Estimate, predictor: Predictor, name: str) -> None:
    for shares, over in ((estimate.treatments, predictor.treatments), (estimate.labels, predictor.labels)):
        require(shares.shape == (len(over),), f"{name}: {shares.shape} probabilities over {len(over)} names")
        right = bool(np.all(shares >= 0.0)) and abs(float(shares.sum()) - 1.0) < 1e-6
        require(right, f"{name}: {shares} are no probabilities")
        require(bool(np.array_equal(shares, np.round(shares, 9))), f"{name}: estimates must be rounded to 9 digits")
    require(0.0 <= estimate.novelty <= 1.0, f"{name}: novelty {estimate.novelty} is not in [0, 1]")
