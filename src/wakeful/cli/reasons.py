"""Why a treatment was chosen and how it was executed: the decisions of one process in words."""

from __future__ import annotations

import math

from wakeful.cli.terminal import bar, heading, paragraph, say
from wakeful.cli.weighed import CannotRecompute, Weighed, weighed
from wakeful.facts.decisions import Decision
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.story import ProcessStory
from wakeful.journal.views import History, Story
from wakeful.journal.wording.decisions import MODES, gate_lines, memory_words, model_words
from wakeful.journal.wording.words import count, plain

_SHOWN = 5
_RULES = 4


def print_decisions(journal: SqliteJournal, read: History, told: Story, process: ProcessStory) -> None:
    """Print the first decision in full and what later ones changed."""
    heading("Decision")
    if not process.decisions:
        paragraph("none: this process is uncovered")
        return
    first = process.decisions[0]
    if process.role == "child":
        paragraph(f"{first.treatment}, {MODES[first.mode]}: {'; '.join(first.reasons)}")
        return
    paragraph(f"{first.treatment}, {MODES[first.mode]}; {model_words(read, first)}", 2, 2)
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
    strongest = sorted(found.fields, key=lambda each: -abs(each.treatment))[:_SHOWN]
    spoke = [f"{each.field} = {plain(each.value)} ({each.treatment:+.2f})" for each in strongest if abs(each.treatment) >= 0.005]
    if spoke:
        paragraph(f"what weighed most for {decision.treatment}, against what is typical: {', '.join(spoke)}", 2, 2)
    _learned(found)


def _learned(found: Weighed) -> None:
    """The learned rules that spoke, and how the parts of the model weighed."""
    grounds, words = found.grounds, found.words
    if grounds is None or words is None:
        return
    parts = ", ".join(f"{part.name} {part.nats:+.2f}" for part in grounds.parts)
    total = sum(part.nats for part in grounds.parts)
    paragraph(f"against {grounds.against}, in nats: {parts}; together {total:+.2f}, odds of {math.exp(total):.3g} to 1", 2, 2)
    if not grounds.rules:
        return
    said = sum(rule.heard * rule.share for rule in grounds.rules)
    paragraph(f"learned rules that spoke, together {said:.3f} for {grounds.treatment}", 2, 2)
    for rule in grounds.rules[:_RULES]:
        paragraph(
            f"· {words.rule(rule)}: {grounds.treatment} with {rule.share:.3f}, from {count(rule.support, 'experience')} "
            f"({rule.heard:.0%} of the lists)",
            4,
            2,
        )
    if len(grounds.rules) > _RULES:
        rest = sum(rule.heard for rule in grounds.rules[_RULES:])
        paragraph(f"· {count(len(grounds.rules) - _RULES, 'other')} ({rest:.0%} of the lists)", 4, 2)


def _gate(decision: Decision) -> None:
    say("  automatic only if")
    for text, holds in gate_lines(decision.gate, decision.audit):
        say(f"    {'yes' if holds else 'no '}  {text}")


def _rests_on(told: Story, decision: Decision) -> None:
    found = [memory for memory in told.rests_on if memory.experience.id in decision.rests_on]
    if found:
        say("  nearest validated experience")
    for memory in found:
        paragraph(f"· {memory_words(memory)}", 4, 2)


def _change(earlier: Decision, later: Decision) -> None:
    """What a later decision changed: the reasoner's answer, or a failure that led to fallback."""
    if (earlier.treatment, earlier.mode) == (later.treatment, later.mode):
        what = f"confirmed {later.treatment}, confidence {later.confidence:.2f}"
    else:
        what = f"changed to {later.treatment}, {MODES[later.mode]}, confidence {later.confidence:.2f}"
    paragraph(f"then {what}")
    for reason in (
        later.reasons[len(earlier.reasons) :] if later.reasons[: len(earlier.reasons)] == earlier.reasons else later.reasons
    ):
        paragraph(f"· {reason}", 4, 2)
