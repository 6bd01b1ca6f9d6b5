"""`wakeful suspend`, `resume` and `cancel`: an operator's acts on a process, at rest or under a running mind."""

from __future__ import annotations

from pathlib import Path
from uuid import uuid4

import click

from wakeful.cli.handing import THIS_COMMAND, hand, wait_option, who_option, why_option
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import F, journal_option, json_option, named_journal, print_json
from wakeful.cli.terminal import say
from wakeful.facts.inputs import Act
from wakeful.journal.sqlite import open_journal
from wakeful.journal.views import History, ProcessPast
from wakeful.journal.wording.words import duration

_DONE = {
    "reopen": "the event of process {} is thought about again",
    "hold": "process {} is held: it keeps its state and gets no slot until it is resumed",
    "release": "process {} may go on",
    "cancel": "process {} is cancelled; its event is owed a treatment ('wakeful debt' lists it)",
}


class Process(click.ParamType[int]):
    """A process's number, with or without a P before it."""

    name = "PROCESS"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """The number."""
        number = str(value).upper().removeprefix("P")
        if not number.isdecimal() or not int(number):
            self.fail(f"{value!r} is not the number of a process; 'wakeful processes' lists them", param, ctx)
        return int(number)


def _operating(command: F) -> F:
    """The argument and the options that the three commands share."""
    for decorate in (
        json_option,
        wait_option,
        journal_option,
        why_option,
        who_option,
        click.argument("process", type=Process()),
    ):
        command = decorate(command)
    return command


@click.command("suspend")
@_operating
def suspend_command(process: int, who: str, why: str, journal: Path | None, wait_s: float, as_json: bool) -> None:
    """Hold PROCESS: it keeps its state, and gets no slot until it is resumed.

    One that is thinking goes on to the end of its step. One that waits may be woken, and stays where it is. A running mind
    hears of it at once; a journal that nobody is writing is written directly.
    """
    _operate("hold", process, who, why, journal, wait_s, as_json)


@click.command("resume")
@_operating
def resume_command(process: int, who: str, why: str, journal: Path | None, wait_s: float, as_json: bool) -> None:
    """Lift the hold on PROCESS: it competes for a slot again, where it stood."""
    _operate("release", process, who, why, journal, wait_s, as_json)


@click.command("cancel")
@_operating
def cancel_command(process: int, who: str, why: str, journal: Path | None, wait_s: float, as_json: bool) -> None:
    """Complete PROCESS, and the processes it had started, as cancelled; its event is entered as debt."""
    _operate("cancel", process, who, why, journal, wait_s, as_json)


@click.command("reopen")
@_operating
def reopen_command(process: int, who: str, why: str, journal: Path | None, wait_s: float, as_json: bool) -> None:
    """Think about the event of PROCESS, which has completed, again: in a new process linked to it, with deliberation.

    For what is in debt and can be helped now: quarantined events whose treatment was mended, cancelled and unresolved ones.
    """
    _operate("reopen", process, who, why, journal, wait_s, as_json)


def _operate(act: str, process: int, who: str, why: str, journal: Path | None, wait_s: float, as_json: bool) -> None:
    path = named_journal(journal)
    found = _check(path, act, process)
    event = found.event if act == "reopen" else ""
    (done,) = hand(path, [Act(who=who, act=act, process=process, why=why, id=uuid4().hex, event=event)], wait_s)
    if as_json:
        print_json(done)
    elif not done.recorded:
        say(
            f"handed to process {done.by}, which has not recorded it within {duration(wait_s)}: it takes it up with its next "
            "input, or whoever writes the journal next does"
        )
    else:
        where = "applied at once" if done.by == THIS_COMMAND else f"taken up by the running mind, process {done.by}"
        say(f"{_DONE[act].format(process)} ({where}, line {done.position})")


def _check(path: Path, act: str, process: int) -> ProcessPast:
    """The process as it stands. What is wrong is said before anything is written."""
    with open_journal(path, read_only=True) as opened:
        read = History()
        for line in opened.lines_of(process=process):
            read.take(line)
    found = read.processes.get(process)
    if found is None:
        raise Mistake(f"there is no process {process} in {path}; 'wakeful processes' lists them")
    _check_state(found, act)
    return found


def _check_state(found: ProcessPast, act: str) -> None:
    if act == "reopen":
        if found.open:
            raise Mistake(f"process {found.id} is open: it is being thought about")
        return
    if not found.open:
        raise Mistake(f"process {found.id} has completed ({found.end}): there is nothing left to {_WORDS[act]}")
    if act == "hold" and found.held_by:
        raise Mistake(f"process {found.id} is held already, by {found.held_by}")
    if act == "release" and not found.held_by:
        raise Mistake(f"nobody holds process {found.id}: there is nothing to resume")


_WORDS = {"hold": "suspend", "release": "resume", "cancel": "cancel"}
