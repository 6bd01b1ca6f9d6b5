"""Every command has help and stands in docs/cli.md with each of its options."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from wakeful.cli.main import main

DOCS = Path(__file__).parents[2] / "docs" / "cli.md"


def _commands(group: click.Group, path: str) -> Iterator[tuple[str, click.Command]]:
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from _commands(command, f"{path} {name}")
        else:
            yield f"{path} {name}", command


COMMANDS = list(_commands(main, "wakeful"))


@pytest.mark.parametrize(("path", "command"), COMMANDS, ids=[path for path, _ in COMMANDS])
def test_a_command_is_documented_with_each_option(path: str, command: click.Command) -> None:
    text = DOCS.read_text(encoding="utf-8")
    heading = f"\n## `{path}"
    assert heading in text, f"{path} has no section in docs/cli.md"
    section = text.split(heading, 1)[1].split("\n## ", 1)[0]
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert f"`{parameter.opts[-1]}" in section, f"{path} {parameter.opts[-1]} is not in docs/cli.md"


@pytest.mark.parametrize(("path", "command"), COMMANDS, ids=[path for path, _ in COMMANDS])
def test_a_command_and_its_options_have_help(path: str, command: click.Command) -> None:
    assert command.help, path
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, f"{path} {parameter.opts}"
            assert str(parameter.envvar or "").startswith("WAKEFUL_"), f"{path} {parameter.opts}"


def test_every_documented_command_exists() -> None:
    named = {line.split("`")[1].rsplit(" ", 0)[0] for line in DOCS.read_text().splitlines() if line.startswith("## `wakeful")}
    known = {path for path, _ in COMMANDS}
    assert {next((path for path in known if heading.startswith(path)), heading) for heading in named} <= known
