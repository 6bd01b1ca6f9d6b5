"""A process's result in words, and what the world showed of it since."""

from __future__ import annotations

from wakeful.cli.terminal import heading, paragraph, row
from wakeful.facts.time import to_s
from wakeful.journal.results import result_fields
from wakeful.journal.story import ProcessStory
from wakeful.journal.views import History, Story
from wakeful.journal.wording.results import forecast_words, ground_words, own_lines, proposal_words
from wakeful.journal.wording.verdicts import lesson_words, verdict_words
from wakeful.journal.wording.words import duration, plain

_SHOWN = 8


def print_result(read: History, told: Story, process: ProcessStory) -> None:
    """Print the typed result: its sentence, the treatment's own fields, what it rests on, proposals and forecast."""
    fields = result_fields(process.result)
    if not fields:
        return
    confidence = fields.get("confidence")
    sure = f", confidence {confidence:.2f}" if isinstance(confidence, int | float) else ""
    heading(f"Result of {plain(str(fields.get('type', process.treatment)))}{sure}")
    paragraph(str(fields.get("says", "")))
    for name, lines in own_lines(fields):
        _listed(name, lines)
    rests_on, would_change, proposes = (fields.get(name) for name in ("rests_on", "would_change", "proposes"))
    _listed("rests on", [ground_words(read, told, str(each)) for each in rests_on] if isinstance(rests_on, list) else [])
    _listed("would change it", [str(each) for each in would_change] if isinstance(would_change, list) else [])
    _listed(
        "proposes", [proposal_words(each) for each in proposes if isinstance(each, dict)] if isinstance(proposes, list) else []
    )
    if process.forecast:
        row("forecast", forecast_words(told, process))


def _listed(label: str, entries: list[str]) -> None:
    for index, entry in enumerate(entries[:_SHOWN]):
        row(label if index == 0 else "", entry)
    if len(entries) > _SHOWN:
        row("", f"and {len(entries) - _SHOWN} more")


def print_since(told: Story, process: ProcessStory) -> None:
    """Print the outcomes and verdicts on a result, and what was learned from them."""
    if process.role == "child" or not process.forecast:
        return
    heading("What happened since")
    if not process.verdicts:
        left_s = to_s((process.closes_ns or told.now_ns) - told.now_ns)
        paragraph(f"nothing yet: the window closes in {duration(left_s)}" if left_s > 0 else "nothing that decides it")
    for verdict in process.verdicts:
        paragraph(verdict_words(told, process, verdict), 2, 2)
    for experience in told.experiences:
        if experience.process == process.id:
            paragraph(
                f"learned from as experience {experience.id}: {lesson_words(process, experience)}",
                2,
                2,
            )
