"""Options that several commands share, each also read from the environment, and the opening of journals."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import click
import msgspec

from wakeful.cli.mistakes import Mistake
from wakeful.journal.retention import Retention
from wakeful.journal.sqlite import SqliteJournal, open_journal

F = TypeVar("F", bound=Callable[..., object])


def option(*names: str, **settings: object) -> Callable[[F], F]:
    """A click option that is also read from ``WAKEFUL_<NAME>``, and says so in its help."""
    long = next(name for name in names if name.startswith("--"))
    variable = "WAKEFUL_" + long.split("/")[0].lstrip("-").replace("-", "_").upper()
    return click.option(*names, envvar=variable, show_envvar=True, **settings)  # type: ignore[arg-type]


journal_option = option(
    "--journal",
    type=click.Path(path_type=Path, dir_okay=False),
    default=None,
    help="The journal file. Without it: the one that was written last in the state directory.",
)


def alpha_option(default: float | None) -> Callable[[F], F]:
    """The risk under which automatic processing is held."""
    unless = "Without it: the journal's, or 0.05." if default is None else ""
    return option(
        "--alpha",
        type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
        default=default,
        show_default=default is not None,
        help=f"Under the guarantee: the risk P(wrong and automatic) that each treatment may run. {unless}".rstrip(),
    )


def delta_option(default: float | None) -> Callable[[F], F]:
    """How often the guarantee may fail."""
    unless = "Without it: the journal's, or 0.05." if default is None else ""
    return option(
        "--delta",
        type=click.FloatRange(0.0, 1.0, min_open=True, max_open=True),
        default=default,
        show_default=default is not None,
        help=f"Under the guarantee: the probability with which it may fail. {unless}".rstrip(),
    )


def retention_options(command: F) -> F:
    """How much of the past a journal keeps while a mind writes it."""
    default = Retention()
    for each in (
        option(
            "--keep-megabytes",
            type=click.IntRange(min=0),
            default=default.megabytes,
            show_default=True,
            help="Give up what is oldest where the journal is larger. 0: no limit.",
        ),
        option(
            "--keep-events",
            type=click.IntRange(min=0),
            default=default.events,
            show_default=True,
            help="Keep the newest so many events, and what is open or owed. 0: no limit.",
        ),
        option(
            "--keep-days",
            type=click.FloatRange(min=0.0),
            default=default.days,
            show_default=True,
            help="Keep so many days of events, and what is open or owed. 0: no limit.",
        ),
    ):
        command = each(command)
    return command


json_option = option("--json", "as_json", is_flag=True, help="Print JSON instead of text.")


def state_directory() -> Path:
    """Where journals are kept unless one is named: XDG's state directory."""
    base = os.environ.get("XDG_STATE_HOME", "")
    return (Path(base) if base else Path.home() / ".local" / "state") / "wakeful"


@contextmanager
def reading(path: Path | None) -> Iterator[SqliteJournal]:
    """A journal opened for looking at, beside a writer or not.

    Raises:
        Mistake: none was named and there is none in the state directory.
        JournalError: what was named is no journal that can be read.
    """
    journal = open_journal(named_journal(path), read_only=True)
    try:
        yield journal
    finally:
        journal.close()


def named_journal(path: Path | None) -> Path:
    """The journal that was named, or the one that was written last, which is then said on standard error."""
    if path is None:
        path = _latest()
        click.echo(f"journal: {path}", err=True)
    return path


def _latest() -> Path:
    folder = state_directory()
    found = sorted(folder.glob("*.db"), key=lambda file: file.stat().st_mtime) if folder.is_dir() else []
    if not found:
        raise Mistake(f"there is no journal in {folder} yet; make one with 'wakeful run SOURCE', or name one with --journal FILE")
    return found[-1]


def print_json(value: object) -> None:
    """One JSON value on standard output, indented for people and read as easily by programs."""
    click.echo(msgspec.json.format(msgspec.json.encode(value), indent=2).decode())
