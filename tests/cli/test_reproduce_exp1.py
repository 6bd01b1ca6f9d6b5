"""`wakeful reproduce exp1`: Table 2's rows on all variants, figures, and who deliberated."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from wakeful.cli.main import main
from wakeful.experiments.exp1_treatment import METHODS, METRICS


def test_rows_figures_and_nothing_else_on_standard_output(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    arguments = ["reproduce", "exp1", "--seeds", "1", "--first-seed", "5000", "--json", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    rows = json.loads(done.stdout)
    assert {(row["method"], row["workload"], row["metric"]) for row in rows} == {
        (method, variant, metric) for method in METHODS for variant in "ABC" for metric in METRICS
    }
    assert {row["table"] for row in rows} == {"2"}
    published = [row for row in rows if row["paper_mean"] is not None]
    assert len(published) == 35
    assert {row["workload"] for row in published} == {"A"}
    assert all(row["sd"] is None and row["n_seeds"] == 1 for row in rows)
    assert json.loads((tmp_path / "exp1.json").read_text()) == rows
    for name in ("table2", "reliability", "risk_coverage", "calls"):
        assert "<svg" in (tmp_path / f"exp1_{name}.svg").read_text()


def test_an_endpoint_that_is_not_named_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WAKEFUL_OPENAI_BASE_URL", raising=False)
    monkeypatch.delenv("OPENAI_BASE_URL", raising=False)
    done = CliRunner().invoke(main, ["reproduce", "exp1", "--seeds", "1", "--reasoner", "openai"])
    assert done.exit_code != 0
    assert "WAKEFUL_OPENAI_BASE_URL" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
