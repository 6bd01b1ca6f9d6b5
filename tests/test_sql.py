"""SQL is made of fixed text and question marks: every statement in the package, by its syntax tree."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
#: The modules that reach a database at all.
SOURCES = [
    path
    for path in sorted((ROOT / "src" / "wakeful").rglob("*.py"))
    if any(f"import {name}" in path.read_text() for name in ("apsw", "sqlite3"))
]
EXECUTES = {"execute", "executemany", "executescript"}

#: Functions that pass a statement on (which of their arguments it is): held to the same as ``execute`` where they are called.
RUNNERS = {"_query": 0, "_rows": 0, "_entries": 0, "number": 1, "_number": 1}

#: What may stand in a statement beside fixed text, and why that is no text from outside: (file, expression) -> why.
SLOTS = {
    ("journal/reading.py", "'AND ' + where"): "fixed conditions joined, as many as keys are sought; the keys are bound",
    ("journal/compaction/compactor.py", "boundary"): "a number, and another `_rows`: of rows to compact",
    ("journal/compaction/compactor.py", "begin"): "a number, and another `_rows`: of rows to compact",
    ("journal/sqlite.py", "table"): "a name out of the module's own tuple",
    ("journal/compaction/compactor.py", "name"): "a name out of the module's own tuple",
    ("journal/compaction/compactor.py", "table"): "a name out of the module's own tuple",
}


def fixed(node: ast.expr, names: dict[str, ast.expr], file: str) -> Iterator[str]:
    """What in a statement's expression is neither fixed text, nor question marks, nor a slot that is allowed."""
    match node:
        case ast.Constant(value=str() | int()):
            return
        case _ if (file, ast.unparse(node)) in SLOTS:
            return
        case ast.JoinedStr(values=values):
            for each in values:
                yield from fixed(each, names, file)
        case ast.FormattedValue(value=value):
            yield from fixed(value, names, file)
        case ast.IfExp(body=body, orelse=other):
            yield from fixed(body, names, file)
            yield from fixed(other, names, file)
        case ast.Name(id=name) if name.isupper() or name.lstrip("_").isupper():
            return  # a constant of a module
        case ast.Attribute(attr=name) if name.isupper():
            return
        case ast.Name(id=name) if name in names:
            yield from fixed(names[name], {key: value for key, value in names.items() if key != name}, file)
        case ast.Call(func=ast.Attribute(value=ast.Constant(value=","), attr="join"), args=[marks]) if question_marks(
            marks, names
        ):
            return
        case _:
            yield ast.unparse(node)


def question_marks(node: ast.expr, names: dict[str, ast.expr]) -> bool:
    """Whether an expression gives question marks, however many: text of nothing else, times a number."""
    match node:
        case ast.Constant(value=str(text)):
            return set(text) <= set("?,() ")
        case ast.BinOp(left=left, op=ast.Mult()):
            return question_marks(left, names)
        case ast.List(elts=parts):
            return all(question_marks(each, names) for each in parts)
        case ast.JoinedStr(values=values):
            return all(question_marks(each, names) for each in values)
        case ast.FormattedValue(value=value):
            return question_marks(value, names)
        case ast.Call(func=ast.Attribute(value=ast.Constant(value=","), attr="join"), args=[marks]):
            return question_marks(marks, names)
        case ast.Name(id=name) if name in names:
            return question_marks(names[name], {key: value for key, value in names.items() if key != name})
        case _:
            return False


def run(node: ast.AST) -> ast.expr | None:
    """The statement that a call runs or passes on; None where it is no such call."""
    match node:
        case ast.Call(func=ast.Attribute(attr=name), args=[statement, *_]) if name in EXECUTES:
            return statement
        case ast.Call(func=ast.Attribute(attr=name) | ast.Name(id=name), args=args) if (
            name in RUNNERS and len(args) > RUNNERS[name]
        ):
            return args[RUNNERS[name]]
        case _:
            return None


def unsafe(tree: ast.AST, file: str) -> list[str]:
    """The statements of a module that are made of more than fixed text and question marks."""
    found: list[str] = []
    for scope in ast.walk(tree):
        if not isinstance(scope, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        names: dict[str, ast.expr] = {}
        for node in ast.walk(scope):
            if isinstance(node, ast.Assign):
                names.update({target.id: node.value for target in node.targets if isinstance(target, ast.Name)})
        for node in ast.walk(scope):
            statement = run(node)
            passed_on = scope.name in RUNNERS and isinstance(statement, ast.Name) and statement.id == "query"
            if statement is not None and not passed_on:
                found.extend(f"line {statement.lineno}: {each}" for each in fixed(statement, names, file))
    return found


def test_only_modules_that_import_a_database_run_statements() -> None:
    others = [path for path in (ROOT / "src" / "wakeful").rglob("*.py") if path not in SOURCES]
    found = [path.name for path in others if any(f".{name}(" in path.read_text() for name in EXECUTES)]
    assert found == []
    assert SOURCES


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_statement_is_fixed_text_and_question_marks(path: Path) -> None:
    file = str(path.relative_to(ROOT / "src" / "wakeful"))
    assert unsafe(ast.parse(path.read_text()), file) == []


@pytest.mark.parametrize(
    "code",
    [
        'db.execute(f"SELECT {column} FROM lines")',
        'db.execute("SELECT " + column)',
        'db.execute("SELECT %s" % column)',
        'db.execute("SELECT {}".format(column))',
        'query = f"SELECT {column}"\n    db.execute(query)',
        "db.execute(column)",
        "self._rows(f'SELECT {column}')",
        "number(db, f'SELECT {column}')",
        "db.execute(f\"x IN ({','.join(column)})\")",
        'db.executemany(f"INSERT INTO {column} VALUES (?)", rows)',
    ],
)
def test_the_search_for_sql_made_of_data_finds_it(code: str) -> None:
    assert unsafe(ast.parse(f"def f(db, column, rows):\n    {code}"), "journal/reading.py")


@pytest.mark.parametrize(
    "code",
    [
        'db.execute("SELECT 1 WHERE x = ?", (column,))',
        'db.execute(f"PRAGMA user_version={VERSION}")',
        "db.execute(f\"x IN ({','.join('?' * len(rows))})\", rows)",
        'slots = ",".join(["(?,?)"] * len(rows))\n    db.execute(f"INSERT INTO lines VALUES {slots}", rows)',
        'db.execute("A" if column else "B")',
    ],
)
def test_the_search_lets_bound_parameters_through(code: str) -> None:
    assert unsafe(ast.parse(f"def f(db, column, rows):\n    {code}"), "x.py") == []
