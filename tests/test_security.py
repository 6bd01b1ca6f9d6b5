"""What docs/security.md promises of the code as a whole, and that the tests which it names are there."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from wakeful.facts.lines import Line, Noted
from wakeful.journal.sqlite import open_journal

ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "src" / "wakeful").rglob("*.py"))
UNSAFE_MODULES = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "telnetlib", "pty"}
UNSAFE_CALLS = {"eval", "exec", "compile", "__import__"}
UNSAFE_METHODS = {("os", "system"), ("os", "popen"), ("numpy", "load"), ("np", "load"), ("yaml", "load"), ("tempfile", "mktemp")}


def unsafe(tree: ast.AST) -> Iterator[str]:
    """What a syntax tree does that data from outside might reach."""
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                yield from (name.name for name in names if name.name.split(".")[0] in UNSAFE_MODULES)
            case ast.ImportFrom(module=str(module)) if module.split(".")[0] in UNSAFE_MODULES:
                yield module
            case ast.Call(func=ast.Name(id=name)) if name in UNSAFE_CALLS:
                yield f"{name}()"
            case ast.Call(func=ast.Attribute(value=ast.Name(id=module), attr=name)) if (module, name) in UNSAFE_METHODS:
                yield f"{module}.{name}()"
            case ast.keyword(arg="shell", value=ast.Constant(value=True)):
                yield "shell=True"
            case ast.keyword(arg="allow_pickle", value=ast.Constant(value=True)):
                yield "allow_pickle=True"


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_code_is_made_of_data(path: Path) -> None:
    assert list(unsafe(ast.parse(path.read_text()))) == []


@pytest.mark.parametrize(
    "code",
    ["import pickle", "from pickle import loads", "eval(x)", "np.load(p)", "run(x, shell=True)", "np.load(p, allow_pickle=True)"],
)
def test_the_search_for_unsafe_code_finds_it(code: str) -> None:
    assert list(unsafe(ast.parse(code)))


@pytest.mark.parametrize("hostile", ["x' OR '1'='1", "x'; DROP TABLE lines; --", 'x" --', "x\0", "%", "*"])
def test_text_in_a_query_is_a_value_and_never_sql(hostile: str, tmp_path: Path) -> None:
    record = Noted(what=hostile, detail=hostile, event="e")
    with open_journal(tmp_path / "mind.db") as journal:
        journal.commit([Line(1, 0, record)], {hostile: b"1"}, {hostile: b"2"})
        assert list(journal.lines_of(event=hostile)) == []
        assert list(journal.lines_of(kinds=(hostile,))) == []
        assert [line.record for line in journal.lines()] == [record]
        assert journal.state() == {hostile: b"1"}
        assert journal.blob(hostile) == b"2"


def test_every_test_that_the_security_page_names_is_there() -> None:
    page = (ROOT / "docs" / "security.md").read_text()
    named = re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", page)
    assert len(named) > 15
    for file, test in named:
        assert (ROOT / file).is_file(), file
        assert not test or f"def {test}(" in (ROOT / file).read_text(), f"{file}::{test}"
