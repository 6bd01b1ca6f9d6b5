"""What was learned from a verdict, in words."""

from __future__ import annotations

from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Judged
from wakeful.journal.story import ProcessStory, VerdictTold
from wakeful.journal.wording.verdicts import lesson_words


def lesson(label: str, forecast: str, witnessed: bool) -> str:
    supported = label == forecast
    verdict = Verdict.SUPPORTED if supported else Verdict.CONTRADICTED
    judged = Judged(process=1, event="e", predicted=forecast, label=label, verdict=verdict)
    outcome = Outcome(id="o", topic="t", entity="*", label=label, at_ns=1) if witnessed else None
    told = VerdictTold(at_ns=1, judged=judged, outcome=outcome)
    process = ProcessStory(
        id=1, role="root", treatment="risk_prediction", state="completed", created_ns=0, decisions=(), trail=(), verdicts=(told,)
    )
    experience = Experience(
        id=1,
        event="e",
        process=1,
        treatment="risk_prediction",
        treatment_label="risk_prediction" if supported else "",
        predicted=forecast,
        outcome=label,
        verdict=verdict,
        mode="auto",
    )
    return lesson_words(process, experience)


def test_that_nothing_came_as_forecast_is_not_told_as_the_treatment_having_been_right() -> None:
    assert lesson("none", "none", witnessed=False).startswith("nothing came, as forecast")


def test_what_came_as_forecast_or_otherwise_is_told_of_the_treatment() -> None:
    assert lesson("stop", "stop", witnessed=True) == "risk_prediction was right for such an event"
    assert lesson("stop", "none", witnessed=True).startswith("it counts against risk_prediction")
