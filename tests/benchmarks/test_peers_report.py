"""The report: medians and ranges of runs, and which stage a sample belongs to."""

from __future__ import annotations

import signal
import time

from benchmarks.peers.profiled import Sampler, floor_stages, stage_of
from benchmarks.peers.report import Found, row_of, stages, table

FLOOR: Found = {"decode": {"each": 2.0, "together": 1.0}, "append": {"rows": 3.0, "many": 4.0}, "raw file": {"write": 1.0}}


def ran(cpu_us: float, right: bool = True, **more: object) -> Found:
    return {
        "events": 10,
        "events_per_second": 1e6 / cpu_us,
        "cpu_us_per_event": cpu_us,
        "admit": [1.0, cpu_us, 3.0],
        "step": None,
        "resume": [1.0, 2.0, 3.0],
        "bytes_per_event": 100.0,
        "peak_mb": 50.0,
        "base_mb": 40.0,
        "threads": 1,
        "right": right,
        **more,
    }


def test_a_row_has_the_medians_and_the_range() -> None:
    runs = [ran(30.0), ran(10.0), ran(500.0)]
    row = row_of("asyncio", "", runs, {"lost": 3, "repeated": 0, "in_doubt": 1, "kills": 2}, {"rate": 0.0})
    assert (row["cpu_us_per_event"], row["cpu_us_range"]) == (30.0, [10.0, 500.0])
    assert (row["p50_ms"], row["p99_ms"], row["step_p99_ms"]) == (1.0, 30.0, None)
    assert (row["lost"], row["in_doubt"], row["durable"], row["runs"]) == (3, 1, False, 3)


def test_one_wrong_run_makes_the_row_wrong_and_the_table_says_so() -> None:
    row = row_of("asyncio", "", [ran(1.0), ran(1.0, right=False)], None, {})
    assert row["right"] is False
    assert table([row]).splitlines()[-1].endswith("| NO |")


def test_the_floors_row_is_the_sum_of_its_faster_stages_and_the_assembled_program_stands_beside() -> None:
    runs = [ran(9.0, stages_us=FLOOR, floor_us=4.0), ran(11.0, stages_us=FLOOR, floor_us=4.5)]
    row = row_of("floor", "", runs, None, {})
    assert (row["cpu_us_per_event"], row["assembled_us"]) == (4.25, 10.0)
    assert "| decode | together | 1.00 | each 2.00 |" in stages(row)
    assert floor_stages({"stages_us": FLOOR}) == {"decode": 1.0, "journal": 3.0}


def test_a_sample_belongs_to_the_closest_module_that_a_stage_claims() -> None:
    assert stage_of("wakeful.learning.predictor") == "select"
    assert stage_of("wakeful.learning.plan") == "learn"
    assert stage_of("wakeful.journal.packed.row") == "journal"
    assert stage_of("numpy.linalg") == ""


def test_the_sampler_counts_cpu_time_and_lets_go_of_its_signal() -> None:
    with Sampler() as sampler:
        began = time.process_time()
        while time.process_time() - began < 0.1:
            pass
    assert sum(sampler.counts.values()) >= 5
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
