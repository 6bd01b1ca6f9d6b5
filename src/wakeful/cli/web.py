"""`wakeful web`: the page."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.mistakes import INTERRUPTED, Mistake
from wakeful.cli.options import journal_option, option, reading
from wakeful.cli.terminal import say
from wakeful.cli.weighed import CannotRecompute, weighed
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.views import History
from wakeful.web.follow import Followed
from wakeful.web.serve import Unreachable, bound, is_loopback, serve

_SHOWN = 5
_LEAST = 0.005


@click.command("web")
@journal_option
@option("--host", default="127.0.0.1", show_default=True, help="The address to listen on.")
@option(
    "--port",
    type=click.IntRange(0, 65_535),
    default=8765,
    show_default=True,
    help="The port to listen on; 0 takes a free one.",
)
@option("--allow-remote", is_flag=True, help="Let other machines see the page: it has neither login nor encryption.")
def web_command(journal: Path | None, host: str, port: int, allow_remote: bool) -> None:
    """Show a journal as a page that follows it: what is being thought about now, and why.

    It only reads, also beside a running writer. Ctrl-C ends it.
    """
    with reading(journal) as opened:
        path = opened.path
    try:
        loopback = is_loopback(host)
        if not loopback and not allow_remote:
            raise Mistake(
                f"other machines would reach {host or 'every address'}, and the page has neither login nor encryption; "
                "keep to 127.0.0.1 (through an SSH tunnel from elsewhere), or give --allow-remote if that is meant"
            )
        listening = bound(host, port)
    except Unreachable as error:
        raise Mistake(str(error)) from None
    if not loopback:
        click.echo(
            "warning: whoever reaches this machine can read the journal: the page has neither login nor encryption", err=True
        )
    followed = Followed(path)
    try:
        serve(followed, host, listening, _weighing, lambda url: say(f"{path} at {url} (ctrl-C ends it)"), remote=not loopback)
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None
    finally:
        followed.close()


def _weighing(journal: SqliteJournal, read: History, event: Event, decision: Decision) -> list[tuple[str, float]]:
    """What weighed most in a model's decision; nothing where it can't be recomputed here."""
    try:
        found = weighed(journal, read, event, decision)
    except CannotRecompute:
        return []
    strongest = sorted(found.fields, key=lambda each: -abs(each.treatment))[:_SHOWN]
    return [(f"{each.field} = {each.value}", each.treatment) for each in strongest if abs(each.treatment) >= _LEAST]
