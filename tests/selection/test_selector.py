"""What and how, separately."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.selection.test_features import event
from wakeful.contracts.learner import Estimate, Vector
from wakeful.facts.domain import DomainSpec, FieldSpec, Guideline
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.settings import MindSettings
from wakeful.selection.explain import contributions
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.selector import Selector

TREATMENTS = ("analogy", "description", "planning")
SPEC = DomainSpec(
    name="d",
    version=1,
    says="",
    fields={"load": FieldSpec()},
    guideline=(
        Guideline(
            treat="planning", because="A load is in the way.", when={"load": ">0.5"}, expect="intervention", probability=0.8
        ),
    ),
)
TYPICAL = np.zeros(Selector(SPEC, TREATMENTS, None, SelectionSettings()).encoder.size)  # type: ignore[arg-type]


class Fixed:
    """A predictor that says what it was told: planning grows with the first feature (the load)."""

    def __init__(self, treatments: tuple[float, ...], labels: tuple[float, ...], novelty: float, names: tuple[str, ...]) -> None:
        self.treatments, self.labels, self.typical = names, ("none", "intervention"), TYPICAL
        self._p, self._q, self._novelty = np.array(treatments), np.array(labels), novelty

    def estimate(self, features: Vector) -> Estimate:
        shift = 0.05 * features[0]
        return Estimate(self._p + shift * np.array([-1.0, 0.0, 1.0])[: len(self._p)], self._q, self._novelty)

    def estimate_many(self, features: Vector) -> list[Estimate]:
        return [self.estimate(row) for row in features]


class Told:
    name = "told"

    def __init__(self, predictor: Fixed) -> None:
        self.predictor = predictor

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        raise NotImplementedError

    def load(self, weights: bytes) -> Fixed:
        if weights != b"model":
            raise ValueError("not a model")
        return self.predictor


CARD = ModelCard(
    version=3, base=2, watermark=80, seed=1, epochs=35, blob="b", accepted=True,
    thresholds={"*": 0.6, "@result": 0.7}, support={"planning": 9, "description": 2},
)  # fmt: skip


def selector(
    treatments: tuple[float, ...] = (0.1, 0.1, 0.8),
    labels: tuple[float, ...] = (0.2, 0.8),
    novelty: float = 0.3,
    names: tuple[str, ...] = TREATMENTS,
    card: ModelCard = CARD,
    spec: DomainSpec = SPEC,
    settings: SelectionSettings | None = None,
) -> Selector:
    one = Selector(spec, TREATMENTS, Told(Fixed(treatments, labels, novelty, names)), settings or SelectionSettings())
    one.use(card, b"model")
    return one


def test_without_a_model_a_guideline_chooses_and_nothing_is_automatic() -> None:
    one = Selector(SPEC, TREATMENTS, Told(Fixed((), (), 0.0, ())), SelectionSettings())
    decision = one.decide(event({"load": 0.9}), {}, (), 0)
    assert (decision.treatment, decision.mode, decision.model) == ("planning", "delib", 0)
    assert decision.prior == {"none": 0.2, "intervention": 0.8}
    assert decision.reasons[0] == "Guideline: A load is in the way."
    assert decision.candidates[0].treatment == "planning"


def test_without_a_model_and_a_guideline_the_treatment_is_general_and_provisional() -> None:
    one = Selector(SPEC, TREATMENTS, Told(Fixed((), (), 0.0, ())), SelectionSettings())
    decision = one.decide(event({"load": 0.1}), {}, (), 0)
    assert (decision.treatment, decision.mode) == ("analogy", "fallback")


def test_a_familiar_certain_supported_and_trusted_event_is_automatic() -> None:
    decision = selector().decide(event(), {"planning": 0.9}, (7, 3), 80)
    assert (decision.treatment, decision.mode, decision.confidence) == ("planning", "auto", 0.8)
    assert (decision.model, decision.watermark, decision.rests_on) == (3, 80, (7, 3))
    assert decision.prior == {"none": 0.2, "intervention": 0.8}
    assert decision.gate.threshold == 0.6
    assert "Automatic" in decision.reasons[-1]


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ({"treatments": (0.25, 0.2, 0.55)}, "confidence"),
        ({"labels": (0.4, 0.6)}, "forecast"),
        ({"card": ModelCard(version=1, base=0, watermark=9, seed=0, epochs=1, blob="", accepted=True)}, "validated"),
        ({"settings": SelectionSettings(support=10)}, "validated"),
        ({"settings": SelectionSettings(thresholds="fixed", confidence=0.99)}, "confidence"),
    ],
)
def test_doubt_leads_to_deliberation_and_the_reason_says_which(changed: dict[str, object], word: str) -> None:
    decision = selector(**changed).decide(event(), {}, (), 80)  # type: ignore[arg-type]
    assert (decision.treatment, decision.mode) == ("planning", "delib")
    assert any(word in reason for reason in decision.reasons[1:])


def test_lost_trust_leads_to_deliberation() -> None:
    decision = selector().decide(event(), {"planning": 0.2}, (), 80)
    assert decision.mode == "delib"
    assert (decision.gate.trust, decision.gate.trust_limit) == (0.2, 0.4)


def test_the_unfamiliar_leads_to_fallback_however_certain_the_model_is() -> None:
    decision = selector(treatments=(0.0, 1.0, 0.0), novelty=0.999).decide(event({"load": 0.9}), {}, (), 80)
    assert (decision.treatment, decision.mode) == ("planning", "fallback")
    assert decision.prior["intervention"] == 0.8
    decision = selector(treatments=(0.0, 1.0, 0.0), novelty=0.999).decide(event({"load": 0.1}), {}, (), 80)
    assert (decision.treatment, decision.mode) == ("analogy", "fallback")
    assert decision.gate.novelty > decision.gate.novelty_limit


def test_a_threshold_of_its_own_goes_before_the_pooled_one() -> None:
    card = ModelCard(
        version=1, base=0, watermark=9, seed=0, epochs=1, blob="", accepted=True,
        thresholds={"*": 0.5, "planning": 1.01, "@result": 0.5}, support={"planning": 5},
    )  # fmt: skip
    decision = selector(card=card).decide(event(), {}, (), 9)
    assert decision.mode == "delib"
    assert any("went wrong too often" in reason for reason in decision.reasons)


def test_only_allowed_treatments_are_candidates_and_their_probabilities_add_up() -> None:
    spec = DomainSpec(name="d", version=1, says="", fields={"load": FieldSpec()}, treatments=("description", "analogy"))
    decision = selector(spec=spec).decide(event(), {}, (), 0)
    assert {candidate.treatment for candidate in decision.candidates} == {"description", "analogy"}
    assert sum(candidate.probability for candidate in decision.candidates) == pytest.approx(1.0, abs=1e-6)


def test_a_model_that_does_not_know_a_newer_treatment_is_still_used_by_name() -> None:
    decision = selector(treatments=(0.2, 0.8), names=("description", "planning")).decide(event(), {}, (), 0)
    assert decision.treatment == "planning"
    assert {c.treatment: c.probability for c in decision.candidates} == {"planning": 0.8, "description": 0.2, "analogy": 0.0}


def test_weights_of_other_features_are_refused_and_the_version_in_use_stays() -> None:
    one = selector()
    other = Fixed((1.0,), (1.0,), 0.0, ("planning",))
    other.typical = np.zeros(3)
    one._learner = Told(other)
    with pytest.raises(ValueError, match="3 features"):
        one.use(CARD, b"model")
    with pytest.raises(ValueError, match="not a model"):
        one.use(CARD, b"noise")
    assert one.decide(event(), {}, (), 80).mode == "auto"


def test_a_domain_that_allows_nothing_registered_is_an_error_with_a_way_out() -> None:
    with pytest.raises(ValueError, match="register one of them"):
        Selector(
            DomainSpec(name="d", version=1, says="", treatments=("dreaming",)),
            TREATMENTS,
            Told(Fixed((), (), 0, ())),
            SelectionSettings(),
        )


@given(
    st.lists(st.floats(0.001, 1.0), min_size=3, max_size=3), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
)  # fmt: skip
def test_automatic_only_within_every_limit_and_the_same_again(
    weights: list[float], label: float, novelty: float, trust: float, load: float
) -> None:
    total = sum(weights)
    shares = tuple(round(weight / total, 9) for weight in weights)
    one = selector(treatments=shares, labels=(label, 1.0 - label), novelty=round(novelty, 9))
    given_event = event({"load": load})
    trusts = dict.fromkeys(TREATMENTS, trust)
    decision = one.decide(given_event, trusts, (), 80)
    gate = decision.gate
    passes = (
        gate.confidence >= gate.threshold
        and gate.novelty <= gate.novelty_limit
        and gate.trust >= gate.trust_limit
        and round(max(decision.prior.values()), 6) >= 0.7
        and decision.treatment in CARD.support
    )
    assert (decision.mode == "auto") == passes
    assert (decision.mode == "fallback") == (gate.novelty > gate.novelty_limit)
    again = selector(treatments=shares, labels=(label, 1.0 - label), novelty=round(novelty, 9))
    again.decide(event(), trusts, (), 80)
    assert again.decide(given_event, trusts, (), 80) == decision


def test_a_contribution_is_the_change_when_the_field_has_its_typical_value() -> None:
    one = selector()
    assert one.predictor is not None
    found = contributions(one.encoder, one.predictor, event({"load": 0.6}), "planning")
    assert [(item.field, item.value, item.treatment) for item in found] == [("load", "0.6", pytest.approx(0.03))]
    assert contributions(one.encoder, one.predictor, event({"load": 0.6}), "dreaming") == ()


def test_the_rate_of_false_alarms_of_novelty_is_the_minds_setting() -> None:
    assert SelectionSettings.under(MindSettings()).novelty_limit == 0.99
    assert SelectionSettings.under(MindSettings(novelty_rate=0.05)).novelty_limit == 0.95
    with pytest.raises(ValueError, match="novelty_rate is 1"):
        SelectionSettings.under(MindSettings(novelty_rate=1.0))
