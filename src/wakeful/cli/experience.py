"""`wakeful experience export` and `import`: what one robot learned from, carried to another with its provenance."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, json_option, named_journal, option, print_json, reading
from wakeful.cli.terminal import say
from wakeful.facts.lines import Opened
from wakeful.journal.experience import carried, read_experience, take_up, write_experience
from wakeful.journal.sqlite import open_journal
from wakeful.journal.wording.words import count


@click.group("experience")
def experience_group() -> None:
    """Carry experience from one robot to another."""


@experience_group.command("export")
@journal_option
@option("--out", type=click.Path(path_type=Path, dir_okay=False), required=True, help="The Parquet file to write.")
def experience_export_command(journal: Path | None, out: Path) -> None:
    """Write a journal's experiences as a Parquet table: each with its event, its verdict, and whose it is."""
    with reading(journal) as opened:
        try:
            written = write_experience(carried(opened), out)
        except OSError as error:
            raise Mistake(f"{out} cannot be written: {error.strerror or error}; name another file with --out") from error
    click.echo(f"{count(written, 'experience')} written to {out}", err=True)


@experience_group.command("import")
@click.argument("table", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@journal_option
@option("--any-domain", is_flag=True, help="Also experiences of other domains than the journal's.")
@json_option
def experience_import_command(table: Path, journal: Path | None, any_domain: bool, as_json: bool) -> None:
    """Take up the experiences of TABLE in a journal that no mind is writing; the next run learns from them.

    What was imported before is passed over, and so is what this journal made itself. A new file may be named with --journal.
    """
    path = named_journal(journal)
    with open_journal(path) as opened:
        domains = [line.record.domain for line in opened.lines_of(kinds=("opened",)) if isinstance(line.record, Opened)]
        taken = take_up(opened, read_experience(table), "" if any_domain or not domains else domains[-1])
    if as_json:
        print_json(taken)
        return
    say(f"{count(taken.imported, 'experience')} imported into {path}; {taken.known} were known already")
    if taken.foreign:
        say(f"{taken.foreign} are of other domains than {domains[-1]!r} and were left; --any-domain takes them too")
