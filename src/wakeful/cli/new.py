"""`wakeful new domain`: a first draft of a domain from a recording."""

from __future__ import annotations

import itertools
from pathlib import Path

import click

from wakeful.bridges import bridge_for
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import option
from wakeful.domains.draft import draft
from wakeful.facts.events import Observation

#: The beginning of a recording that a draft is made from.
OBSERVATIONS = 50_000


@click.group("new")
def new_group() -> None:
    """Make something new: a domain."""


@new_group.command("domain")
@option("--from", "source", type=click.Path(path_type=Path), required=True, help="A recording of the robot.")
@option("--name", default=None, help="The domain's name. Without it: after the recording's.")
@option(
    "--out", type=click.Path(path_type=Path, dir_okay=False), default=None, help="The file to write. Without it: standard output."
)
def new_domain_command(source: Path, name: str | None, out: Path | None) -> None:
    """Draft a domain's TOML from a recording: fields, detectors and outcomes as far as they can be seen in it.

    The draft loads and runs as it is; which changes matter and which flags are outcomes only a person knows.
    """
    bridge = bridge_for(source)
    beginning = itertools.islice(bridge.read(source), OBSERVATIONS)
    seen = (item for item in beginning if isinstance(item, Observation))
    text = draft(seen, name or _name_of(source), bridge.peek(source))
    if out is None:
        click.echo(text, nl=False)
        return
    try:
        with out.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise Mistake(f"{out} is there already; name another file with --out, or remove it") from None
    except OSError as error:
        raise Mistake(f"{out} cannot be written: {error.strerror}; name another file with --out") from error
    click.echo(f"{out} written: read and correct it, then 'wakeful run --domain {out} {source}'", err=True)


def _name_of(source: Path) -> str:
    name = "".join(letter if letter.isalnum() else "_" for letter in source.stem.lower()).strip("_")
    return name if name[:1].isalpha() else f"domain_{name}".rstrip("_")
