"""`wakeful export`: a journal as JSON lines or Parquet."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, option, reading
from wakeful.journal.export import write_jsonl, write_parquet
from wakeful.journal.wording.words import count


@click.command("export")
@journal_option
@option("--format", "form", type=click.Choice(["jsonl", "parquet"]), default="jsonl", show_default=True, help="What to write.")
@option(
    "--out", type=click.Path(path_type=Path, dir_okay=False), default=None, help="The file to write; without it, standard output."
)
@option(
    "--stable",
    is_flag=True,
    help="Leave out wall-clock fields and resumption records, so that an interrupted run equals an undisturbed one.",
)
def export_command(journal: Path | None, form: str, out: Path | None, stable: bool) -> None:
    """Write a journal's lines: JSON lines of position, at_ns and record, or a Parquet table."""
    if form == "parquet" and out is None:
        raise click.UsageError("a Parquet table goes to a file: give --out FILE.parquet")
    with reading(journal) as opened:
        try:
            if form == "parquet" and out is not None:
                written = write_parquet(opened, out, stable=stable)
            elif out is not None:
                with out.open("wb") as file:
                    written = write_jsonl(opened, file, stable=stable)
            else:
                write_jsonl(opened, sys.stdout.buffer, stable=stable)
                sys.stdout.buffer.flush()
                return
        except BrokenPipeError:
            raise
        except OSError as error:
            raise Mistake(
                f"{out or 'standard output'} cannot be written: {error.strerror}; name another file with --out"
            ) from error
    click.echo(f"{count(written, 'line')} written to {out}", err=True)
