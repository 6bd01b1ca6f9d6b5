"""`wakeful watch -- COMMAND…`: a watchdog where there is no systemd."""

from __future__ import annotations

import os

import click

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import option
from wakeful.drivers.watchdog import Watchdog, WatchSettings
from wakeful.journal.wording.words import plain

_DEFAULT = WatchSettings()


@click.command("watch", context_settings={"ignore_unknown_options": True})
@option(
    "--stall-s",
    type=click.FloatRange(min=0.1),
    default=_DEFAULT.stall_s,
    show_default=True,
    metavar="S",
    help="Without a heartbeat for so long it has stalled, and is killed and started again.",
)
@option(
    "--start-s",
    type=click.FloatRange(min=0),
    default=_DEFAULT.start_s,
    show_default=True,
    metavar="S",
    help="So long it may take to become ready; 0: it need not say so, and is watched for its end alone.",
)
@option(
    "--stop-s",
    type=click.FloatRange(min=0),
    default=_DEFAULT.stop_s,
    show_default=True,
    metavar="S",
    help="So long it may take to end when it is told to; then it is killed.",
)
@option(
    "--give-up-after",
    type=click.IntRange(min=0),
    default=_DEFAULT.give_up_after,
    show_default=True,
    metavar="N",
    help=f"After so many failures in a row (a run that was ready for {_DEFAULT.steady_s:g} s ends the row); 0: never.",
)
@option(
    "--backoff-s",
    type=click.FloatRange(min=0),
    default=_DEFAULT.backoff_s,
    show_default=True,
    metavar="S",
    help=f"Before it is started again; twice as long after each failure in a row, at most {_DEFAULT.longest_backoff_s:g} s.",
)
@click.argument("command", nargs=-1, required=True, type=click.UNPROCESSED, metavar="-- COMMAND…")
@click.pass_context
def watch_command(
    context: click.Context,
    stall_s: float,
    start_s: float,
    stop_s: float,
    give_up_after: int,
    backoff_s: float,
    command: tuple[str, ...],
) -> None:
    """Run COMMAND (usually 'wakeful run …'), and start it again when it crashes or stalls.

    It is heard by systemd's notify protocol: readiness, a heartbeat from the mind's own loop, a status. Signals are handed on.
    Ends with the command's own exit code: when it succeeds, is told to end, gets its options wrong, or has failed too often.
    """
    settings = WatchSettings(stall_s=stall_s, start_s=start_s, stop_s=stop_s, give_up_after=give_up_after, backoff_s=backoff_s)
    try:
        code = Watchdog(command, settings, os.environ, lambda text: click.echo(f"watch: {plain(text)}", err=True)).run()
    except OSError as error:
        raise Mistake(f"{command[0]} cannot be started: {error.strerror}; name a program that is there, after --") from error
    context.exit(code)
