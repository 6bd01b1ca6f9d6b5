"""Whatever a journal holds, what looks at it prints it: no typed line makes a command fail."""

from __future__ import annotations

import tempfile
from pathlib import Path

from click.testing import CliRunner
from hypothesis import given, settings

from tests.cli.conftest import written
from tests.journal.strategies import any_lines
from tests.journal.test_audit import renumbered
from wakeful.cli.main import main
from wakeful.facts.lines import Admitted, Line

LOOKING = (
    ("status",),
    ("events", "--limit", "0"),
    ("processes", "--all"),
    ("stats",),
    ("trust",),
    ("learning",),
    ("export", "--stable"),
)


@settings(max_examples=25, deadline=None)
@given(any_lines(60))
def test_every_command_that_looks_prints_any_typed_lines(lines: list[Line]) -> None:
    events = {line.record.event.id for line in lines if isinstance(line.record, Admitted) and line.record.event.id}
    with tempfile.TemporaryDirectory() as folder:
        path = written(renumbered(lines), Path(folder) / "any.db")
        for arguments in (*LOOKING, *(("why", event) for event in events)):
            result = CliRunner().invoke(main, [*arguments, "--journal", str(path)])
            assert result.exit_code == 0, (arguments, result.output)
        assert CliRunner().invoke(main, ["audit", "--journal", str(path)]).exit_code in (0, 1)
