"""Why a treatment was chosen and how it was executed: the decisions of one process in words."""

from __future__ import annotations

from wakeful.cli.terminal import heading, paragraph, say
from wakeful.cli.weighed import CannotRecompute, weighed
from wakeful.cli.words import bar, count, plain
from wakeful.facts.decisions import Decision, Gate
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.story import ProcessStory, Remembered
from wakeful.journal.views import History, Story

_MODE = {"auto": "automatically", "delib": "with deliberation", "fallback": "in fallback (provisional)"}
_SHOWN = 5


def print_decisions(journal: SqliteJournal, read: History, told: Story, process: ProcessStory) -> None:
    """Print the first decision in full and what later ones changed."""
    heading("Decision")
    if not process.decisions:
        paragraph("none: this process is uncovered")
        return
    first = process.decisions[0]
    if process.role == "child":
        paragraph(f"{first.treatment}, {_MODE[first.mode]}: {'; '.join(first.reasons)}")
        return
    paragraph(f"{first.treatment}, {_MODE[first.mode]}; {_model(read, first)}", 2, 2)
    for candidate in first.candidates[:_SHOWN]:
        say(f"    {plain(candidate.treatment).ljust(18)} {candidate.probability:5.3f}  {bar(candidate.probability)}".rstrip())
    if len(first.candidates) > _SHOWN:
        rest = sum(candidate.probability for candidate in first.candidates[_SHOWN:])
        say(f"    {count(len(first.candidates) - _SHOWN, 'other').ljust(18)} {rest:5.3f}")
    _weights(journal, read, told, first)
    _gate(first)
    for reason in first.reasons:
        paragraph(f"· {reason}", 4, 2)
    _rests_on(told, first)
    for earlier, later in zip(process.decisions, process.decisions[1:], strict=False):
        _change(earlier, later)


def _weights(journal: SqliteJournal, read: History, told: Story, decision: Decision) -> None:
    """What weighed most, where a model decided."""
    if not decision.model:
        return
    try:
        found = weighed(journal, read, told.event, decision)
    except CannotRecompute as error:
        paragraph(f"what weighed most cannot be recomputed: {error}")
        return
    strongest = sorted(found, key=lambda each: -abs(each.treatment))[:_SHOWN]
    spoke = [f"{each.field} = {plain(each.value)} ({each.treatment:+.2f})" for each in strongest if abs(each.treatment) >= 0.005]
    if spoke:
        paragraph(f"what weighed most for {decision.treatment}, against what is typical: {', '.join(spoke)}", 2, 2)


def _model(read: History, decision: Decision) -> str:
    if not decision.model:
        return "no model yet, chosen by the domain's guidelines"
    cards = {record.card.version: record.card for _, record in read.published}
    line: list[str] = []
    version = decision.model
    while version in cards and str(version) not in line:
        line.append(str(version))
        version = cards[version].base
    if len(line) > _SHOWN:
        line = [*line[:2], "…", line[-1]]
    trained = f", learned from {count(decision.watermark, 'experience')}" if decision.watermark else ""
    return f"model version {' ← '.join(line) if line else decision.model}{trained}"


def _gate(decision: Decision) -> None:
    say("  automatic only if")
    for text, holds in gate_lines(decision.gate):
        say(f"    {'yes' if holds else 'no '}  {text}")


def gate_lines(gate: Gate) -> list[tuple[str, bool]]:
    """The numbers that were compared, in words, each with whether it allowed automation."""
    return [
        (
            f"confidence {gate.confidence:.3f} reaches the threshold {gate.threshold:.3f}"
            if gate.threshold <= 1.0
            else f"confidence {gate.confidence:.3f} reaches the threshold, which no confidence does yet",
            gate.confidence >= gate.threshold,
        ),
        (f"novelty {gate.novelty:.3f} stays within {gate.novelty_limit:.3f}", gate.novelty <= gate.novelty_limit),
        (f"trust {gate.trust:.3f} reaches {gate.trust_limit:.3f}", gate.trust >= gate.trust_limit),
    ]


def _rests_on(told: Story, decision: Decision) -> None:
    found = [memory for memory in told.rests_on if memory.experience.id in decision.rests_on]
    if found:
        say("  nearest validated experience")
    for memory in found:
        paragraph(f"· {_memory(memory)}", 4, 2)


def _memory(memory: Remembered) -> str:
    experience = memory.experience
    about = memory.says or f"{memory.kind} of {memory.entity}"
    return (
        f"{experience.id}: {about} [{experience.event[:10]}]: {experience.treatment} forecast "
        f"{experience.predicted or 'nothing'}, the world showed {experience.outcome}: {experience.verdict}"
    )


def _change(earlier: Decision, later: Decision) -> None:
    """What a later decision changed: the reasoner's answer, or a failure that led to fallback."""
    if (earlier.treatment, earlier.mode) == (later.treatment, later.mode):
        what = f"confirmed {later.treatment}, confidence {later.confidence:.2f}"
    else:
        what = f"changed to {later.treatment}, {_MODE[later.mode]}, confidence {later.confidence:.2f}"
    paragraph(f"then {what}")
    for reason in (
        later.reasons[len(earlier.reasons) :] if later.reasons[: len(earlier.reasons)] == earlier.reasons else later.reasons
    ):
        paragraph(f"· {reason}", 4, 2)
