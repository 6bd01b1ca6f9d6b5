"""What the world showed of a result since, and what was learned from it, in words."""

from __future__ import annotations

from wakeful.facts.experience import Experience
from wakeful.facts.time import to_s
from wakeful.journal.story import ProcessStory, Story, VerdictTold
from wakeful.journal.wording.words import duration


def lesson_words(process: ProcessStory, experience: Experience) -> str:
    """What an experience teaches about the treatment. That nothing came, as forecast, proves little, and is said so."""
    right, applied = experience.treatment_label, experience.treatment
    came = any(verdict.outcome is not None and verdict.judged.label == experience.outcome for verdict in process.verdicts)
    if not right:
        return f"it counts against {applied} for such an event; which treatment would have been right is not known"
    if right == applied and not came:
        return f"nothing came, as forecast: this counts for {right}, though other treatments may have done as well"
    return f"{right} was right for such an event" if right == applied else f"{right} would have been right, not {applied}"


def verdict_words(told: Story, process: ProcessStory, verdict: VerdictTold) -> str:
    """What the world showed, when, by whose word, and what that makes of the forecast."""
    judged, outcome = verdict.judged, verdict.outcome
    forecast = f"the forecast was {judged.predicted}: {judged.verdict}"
    if outcome is None:
        if judged.verdict == "undecided":
            return f"{forecast}{f' ({judged.why})' if judged.why else ''}"
        window_s = to_s((process.closes_ns or verdict.at_ns) - told.admitted_ns)
        return f"no outcome came within {duration(window_s)}, which counts as {judged.label}; {forecast}"
    after = duration(to_s(outcome.at_ns - told.event.stamp.source_ns))
    who = {"world": "the world showed", "person": "a person said", "reasoner": "a reasoner said"}[outcome.origin]
    whom = "" if outcome.entity == "*" else f" of {outcome.entity}"
    acted = ", after the result had been acted on" if outcome.acted_on else ""
    lead = ""
    if judged.lead_ns is not None:
        way = "after it was concluded" if judged.lead_ns >= 0 else "before it was concluded"
        lead = f" ({duration(abs(to_s(judged.lead_ns)))} {way})"
    why = f" ({judged.why})" if judged.why else ""
    return f"{after} after the event{lead} {who} {outcome.label}{whom}{acted}; {forecast}{why}"
