"""The documentation holds: its links lead somewhere, its Python runs, its commands exist."""

from __future__ import annotations

import doctest
import re
import shlex
from pathlib import Path

import click
import pytest

from wakeful.cli import main as cli

ROOT = Path(__file__).parents[1]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


def blocks(*languages: str) -> list[object]:
    """The fenced blocks of these languages, each as a case of its own named after its place."""
    return [
        pytest.param(block[2], id=f"{named(page)}:{page.read_text()[: block.start()].count(chr(10)) + 1}")
        for page in PAGES
        for block in FENCE.finditer(page.read_text())
        if block[1] in languages
    ]


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_link_to_a_file_leads_to_one(page: Path) -> None:
    for target in LINK.findall(page.read_text()):
        if "://" not in target and not target.startswith("mailto:"):
            assert (page.parent / target).exists(), f"{named(page)} links to {target}, which is not there"


@pytest.mark.parametrize("text", blocks("python"))
def test_every_python_example_runs(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    if ">>>" in text:
        examples = doctest.DocTestParser().get_doctest(text, {"__name__": "example"}, "example", None, None)
        assert doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE).run(examples).failed == 0
    else:
        exec(compile(text, "example", "exec"), {"__name__": "example"})


@pytest.mark.parametrize("text", blocks("sh", "console", "bash"))
def test_every_command_shown_exists(text: str) -> None:
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line.removeprefix("$ "), comments=True)
        words = words[1:] if words and words[0] == "./run" else words
        if words[:1] == ["wakeful"] and len(words) > 1 and not words[1].startswith("-"):
            group: click.Command | None = cli.main
            for word in words[1:]:
                if not isinstance(group, click.Group):
                    break
                group = group.commands.get(word)
                assert group is not None, f"`{line}` names a command that is not there"
