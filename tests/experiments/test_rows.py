"""Rows: means, deviations, and distances from the paper's cells."""

from __future__ import annotations

import pytest

from wakeful.experiments.rows import Row, paper_cells, row, table_cells


def test_a_row_carries_the_papers_cell_and_the_distance_in_its_deviations() -> None:
    found = row("3", "suspend_resume", "high", "completion", [70.0, 80.0])
    assert found is not None
    assert (found.mean, found.sd, found.n_seeds) == (75.0, pytest.approx(7.071068), 2)
    assert (found.paper_mean, found.paper_sd) == (67.13, 7.94)
    assert found.z == pytest.approx((75.0 - 67.13) / 7.94, abs=1e-6)
    assert found.standard_errors == pytest.approx(10**0.5 * (75.0 - 67.13) / 7.94, abs=1e-5)


def test_what_the_paper_does_not_have_is_null() -> None:
    found = row("4", "deadline_aware", "high", "completion", [1.0])
    assert found == Row("4", "deadline_aware", "high", "completion", 1.0, None, 1)


def test_a_published_deviation_of_zero_gives_a_distance_only_where_ours_is_the_same_figure() -> None:
    same, other = (row("4", "suspend_resume", "high", "critical_miss", [value]) for value in (0.0, 1.0))
    assert same is not None
    assert other is not None
    assert (same.z, other.z) == (0.0, None)


def test_seeds_with_nothing_to_count_are_left_out_and_a_row_without_any_is_none() -> None:
    found = row("4", "sequential", "low", "critical_deadline", [None, 50.0])
    assert found is not None
    assert (found.mean, found.n_seeds) == (50.0, 1)
    assert row("4", "sequential", "low", "critical_deadline", [None]) is None


def test_another_workloads_published_cell_can_stand_beside_a_row() -> None:
    found = row("3", "sequential", "low_2", "completion", [100.0], beside="low")
    assert found is not None
    assert (found.workload, found.paper_mean, found.z) == ("low_2", 100.0, 0.0)


def test_every_published_cell_of_tables_3_and_4_is_there_once() -> None:
    tables = [cell.table for cell in paper_cells().values()]
    assert (tables.count("3"), tables.count("4")) == (16, 32)


def test_cells_are_printed_as_the_paper_prints_them() -> None:
    found = row("3", "sequential", "medium", "completion", [80.0, 90.0])
    assert found is not None
    assert table_cells([found])[0][3:5] == ["86.42 ± 13.00", "85.00 ± 7.07"]
