"""`wakeful revisit EVENT|EXPERIENCE`: past decisions that rest on refuted knowledge, and their reopening."""

from __future__ import annotations

from pathlib import Path
from uuid import uuid4

import click

from wakeful.cli.handing import THIS_COMMAND, Operated, hand, wait_option
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, json_option, named_journal, option, print_json, reading
from wakeful.cli.terminal import heading, paragraph, say, table
from wakeful.contracts.domain import DomainError
from wakeful.domains import load
from wakeful.facts.inputs import Act
from wakeful.journal.revisit import BY_MODEL, OPEN_TO_CORRECTION, Affected, Refuted, Revisited, revisit, revisit_event
from wakeful.journal.views import History, NoSuchEvent, View, find_event, history
from wakeful.journal.wording.words import count, duration, percent


class Reconsidered(View, frozen=True):
    """What was found, and what became of the reopenings that were asked for."""

    knowledge: tuple[Refuted, ...]
    affected: tuple[Affected, ...]
    through_model: int
    reopened: tuple[Operated, ...]


@click.command("revisit")
@click.argument("knowledge", metavar="EVENT|EXPERIENCE")
@journal_option
@option("--through-model", is_flag=True, help="Also list decisions by model versions that had not learned better yet.")
@option("--reopen", is_flag=True, help="Reopen those that are open to correction, each in a new process linked to the old.")
@option("--who", default="", metavar="NAME", help="With --reopen: who acts, for the record.")
@option("--why", default="", metavar="TEXT", help="With --reopen: the reason, for the record.")
@option("--limit", type=click.IntRange(min=0), default=50, show_default=True, help="The first so many; 0: all.")
@wait_option
@json_option
def revisit_command(
    knowledge: str,
    journal: Path | None,
    through_model: bool,
    reopen: bool,
    who: str,
    why: str,
    limit: int,
    wait_s: float,
    as_json: bool,
) -> None:
    """List every past decision that rests on an experience (its number) or on what was experienced at an event (its id).

    What can't be taken back comes first, then what is open to correction, by criticality and forecast risk.
    """
    if reopen and not (who and why):
        raise click.UsageError("--reopen changes the journal: say --who acts and --why")
    path = named_journal(journal)
    with reading(path) as opened:
        found = _found(history(opened), knowledge, through_model)
    wanted = [row for row in found.affected if row.stands == OPEN_TO_CORRECTION] if reopen else []
    acts = [Act(who=who, act="reopen", process=row.process, why=why, id=uuid4().hex, event=row.event) for row in wanted]
    done = hand(path, acts, wait_s) if acts else []
    if as_json:
        print_json(
            Reconsidered(
                knowledge=found.knowledge, affected=found.affected, through_model=found.through_model, reopened=tuple(done)
            )
        )
        return
    _print(found, limit)
    if reopen:
        _print_reopened(done)


def _found(read: History, knowledge: str, through_model: bool) -> Revisited:
    quiet = _quiet(read)
    number = knowledge.upper().removeprefix("E")
    if number.isdecimal() and int(number) in read.gained:
        return revisit(read, [int(number)], quiet, through_model=through_model)
    try:
        past = find_event(read, knowledge)
    except NoSuchEvent as error:
        raise Mistake(
            f"{knowledge!r} is neither an event's id nor the number of one of {count(len(read.gained), 'experience')}; "
            "'wakeful events' lists events, 'wakeful why EVENT' names experiences"
        ) from error
    return revisit_event(read, past, quiet, through_model=through_model)


def _quiet(read: History) -> str:
    """The outcome label that says that nothing happened, where the journal's domain can be loaded."""
    for opened in reversed(read.opened):
        try:
            return load(opened.domain).spec.outcome.labels[0]
        except DomainError:
            continue
    return ""


def _print(found: Revisited, limit: int) -> None:
    heading("What was experienced")
    if not found.knowledge:
        say("  nothing yet: no outcome has decided this event")
    for each in found.knowledge:
        seen = "was contradicted" if each.refuted else "was supported"
        paragraph(
            f"experience {each.experience}, event {each.event[:10]} ({each.says}): {each.treatment} forecast "
            f"{each.predicted!r} and {seen}, {each.outcome!r} came"
        )
    heading(f"{count(len(found.affected), 'decision')} resting on it")
    shown = found.affected[:limit] if limit else found.affected
    if shown:
        table(
            ["process", "event", "criticality", "risk", "taken back", "mode", "treatment", "forecast", "age", "stands", "on"],
            [
                [
                    f"P{row.process}",
                    row.event[:10],
                    str(row.criticality),
                    percent(row.risk),
                    "cannot be" if row.irreversible else "can be",
                    row.mode,
                    row.treatment,
                    row.predicted,
                    duration(row.age_s),
                    row.stands,
                    ", ".join(map(str, row.on)) + (" through the model" if row.by == BY_MODEL else ""),
                ]
                for row in shown
            ],
            ["criticality", "risk", "age"],
            whole=["process", "event", "stands"],
            drop=["treatment", "mode", "age"],
        )
    if len(shown) < len(found.affected):
        click.echo(f"the first {len(shown)} of {count(len(found.affected), 'decision')}; --limit 0 shows all", err=True)
    hidden = found.through_model - sum(row.by == BY_MODEL for row in found.affected)
    if hidden:
        click.echo(f"{hidden} more are by model versions that had not learned better yet; --through-model lists them", err=True)


def _print_reopened(done: list[Operated]) -> None:
    recorded = [each for each in done if each.recorded]
    if not done:
        say("none of them is open to correction: nothing was reopened")
    elif len(recorded) == len(done):
        by = "at once" if done[0].by == THIS_COMMAND else f"by the running mind, process {done[0].by}"
        say(f"{count(len(done), 'decision')} reopened {by}; 'wakeful processes' shows them, the next run thinks about them")
    else:
        say(f"{len(recorded)} of {count(len(done), 'decision')} reopened so far; process {done[0].by} takes up the rest")
