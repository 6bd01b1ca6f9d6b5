"""`wakeful reproduce`: rows and nothing else as JSON, tables with the paper beside ours, files where they are asked for."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from wakeful.cli import reproduce
from wakeful.cli.main import main

METHODS = {"task_bounded", "sequential", "reactive_priority", "suspend_resume", "deadline_aware", "clairvoyant"}
LOADS = {"low", "medium", "high", "bursty_delayed"}
KEYS = {"table", "method", "workload", "metric", "mean", "sd", "n_seeds", "paper_mean", "paper_sd", "z"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduced")


@pytest.fixture(scope="module")
def printed(folder: Path) -> str:
    pytest.importorskip("matplotlib")
    done = CliRunner().invoke(main, ["reproduce", "exp2", "--seeds", "2", "--first-seed", "1000", "--json", "--out", str(folder)])
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    return done.stdout


def test_json_is_one_array_of_rows_of_the_declared_shape(printed: str) -> None:
    rows = json.loads(printed)
    assert all(set(row) == KEYS for row in rows)
    assert {row["method"] for row in rows} == METHODS
    assert {row["workload"] for row in rows} == LOADS | {f"{load}_2" for load in LOADS}
    assert {row["n_seeds"] for row in rows if row["metric"] == "completion"} == {2}
    published = [row for row in rows if row["paper_mean"] is not None]
    assert all(row["method"] in METHODS - {"deadline_aware", "clairvoyant"} for row in published)
    assert len(published) == 96
    for row in published:
        if row["z"] is not None and row["paper_sd"]:
            assert row["z"] == pytest.approx((row["mean"] - row["paper_mean"]) / row["paper_sd"], abs=1e-5)


def test_rows_and_figures_are_written_to_the_folder(printed: str, folder: Path) -> None:
    assert json.loads((folder / "exp2.json").read_text()) == json.loads(printed)
    assert (folder / "exp2_completion.png").read_bytes()[:4] == b"\x89PNG"
    assert "<svg" in (folder / "exp2_completion.svg").read_text()


def test_text_shows_the_papers_figure_ours_and_the_distance() -> None:
    done = CliRunner().invoke(main, ["reproduce", "exp2", "--seeds", "1"])
    assert done.exit_code == 0, done.output
    assert "Table 3: mean ± sample standard deviation over 1 seed" in done.output
    line = next(line for line in done.output.splitlines() if line.startswith("suspend_resume\thigh\tcompletion\t"))
    assert line.split("\t")[3] == "67.13 ± 7.94"
    assert "published cells within one published standard deviation" in done.output
    assert "deadline_aware on high, of the clairvoyant's" in done.output


@pytest.mark.parametrize(
    ("count", "first", "seeds"),
    [(None, None, (5, 3, 9)), (2, None, (5, 3)), (5, None, (5, 3, 9, 10, 11)), (None, 40, (40, 41, 42)), (2, 40, (40, 41))],
)
def test_seeds_are_the_lists_or_consecutive_ones(count: int | None, first: int | None, seeds: tuple[int, ...]) -> None:
    assert reproduce.chosen_seeds((5, 3, 9), count, first) == seeds


def test_an_unknown_experiment_is_one_line_that_names_those_that_there_are() -> None:
    done = CliRunner().invoke(main, ["reproduce", "exp9"])
    assert done.exit_code == 2
    assert "exp2" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
