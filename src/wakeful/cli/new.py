"""`wakeful new domain` and `new treatment`: a first draft of a domain from a recording, and of a treatment's package."""

from __future__ import annotations

import itertools
import keyword
import re
from pathlib import Path

import click

from wakeful.bridges import bridge_for
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import option
from wakeful.cli.skeleton import skeleton
from wakeful.domains.draft import draft
from wakeful.facts.events import Observation
from wakeful.treatments.registry import Registry
from wakeful.version import __version__

#: The beginning of a recording that a draft is made from.
OBSERVATIONS = 50_000

_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


@click.group("new")
def new_group() -> None:
    """Make something new: a domain, a treatment."""


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


@new_group.command("treatment")
@click.argument("name")
@option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=None,
    help="The folder to make. Without it: wakeful-NAME in the current one.",
)
def new_treatment_command(name: str, out: Path | None) -> None:
    """Write a package with the treatment NAME: a documented skeleton, its test with the contract's checks, how to install it."""
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise Mistake(f"{name!r} cannot name a treatment: small letters, digits and _, a letter first, such as 'inspection'")
    if name in Registry(installed=()).names():
        raise Mistake(f"{name} is one of wakeful's own treatments; take another name")
    folder = out if out is not None else Path(f"wakeful-{name.replace('_', '-')}")
    try:
        folder.mkdir(parents=True)
        for path, text in skeleton(name, __version__).items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    except FileExistsError:
        raise Mistake(f"{folder} is there already; name another folder with --out, or remove it") from None
    except OSError as error:
        raise Mistake(f"{folder} cannot be written: {error.strerror}; name another folder with --out") from error
    click.echo(f"{folder} written: 'pip install -e {folder}', then 'pytest {folder}' and 'wakeful treatments'", err=True)


def _name_of(source: Path) -> str:
    name = "".join(letter if letter.isalnum() else "_" for letter in source.stem.lower()).strip("_")
    return name if name[:1].isalpha() else f"domain_{name}".rstrip("_")
