"""`wakeful why` tells the story of one event in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.cli.conftest import Wakeful, written
from tests.journal.builder import Book
from wakeful.domains import load
from wakeful.facts.events import Relation
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.forest import ForestSettings
from wakeful.learning.pooled import Pooled, PooledSettings
from wakeful.learning.rule_search import SearchSettings
from wakeful.selection.features import Encoder
from wakeful.treatments.registry import Registry


def test_the_story_names_candidates_gate_requests_result_and_what_happened_since(
    wakeful: Wakeful, book: Book, journal: Path
) -> None:
    told = " ".join(wakeful("why", book.event_of(1)[:8], "--journal", journal).stdout.split())
    for expected in (
        "joint_current of joint_3",
        "planning",
        "confidence 0.800 reaches the threshold 0.700",
        "asks for evidence camera|joint_3, and waits",
        "is preempted by process 2 (grip_lost of gripper)",
        "Result of diagnosis, confidence 0.70",
        "joint 3 runs warm",
        "the world showed protective_stop; the forecast was none",
        "contradicted",
        "Reopening: process 4 thinks again about what process 1 concluded",
        "diagnosis 0.900 → 0.600: contradicted",
    ):
        assert expected in told, expected


def test_an_automatic_decision_names_its_model_and_the_experience_it_rests_on(
    wakeful: Wakeful, book: Book, journal: Path
) -> None:
    automatic = json.loads(wakeful("events", "--journal", journal, "--mode", "auto", "--json").stdout)[0]["id"]
    told = wakeful("why", automatic, "--journal", journal).stdout
    assert "diagnosis, automatically; model version 1" in told
    assert "nearest validated experience" in told
    assert "no outcome came within 30.0 s, which counts as none; the forecast was none: supported" in told


def test_an_open_process_says_that_it_still_waits(wakeful: Wakeful, journal: Path) -> None:
    waiting = json.loads(wakeful("processes", "--journal", journal, "--state", "waiting", "--json").stdout)[0]["event"]
    assert "now waiting" in wakeful("why", waiting, "--journal", journal).stdout


def test_json_holds_the_whole_story(wakeful: Wakeful, book: Book, journal: Path) -> None:
    told = json.loads(wakeful("why", book.event_of(1), "--journal", journal, "--json").stdout)
    assert [process["role"] for process in told["processes"]] == ["root", "child", "reopening"]


def test_an_unknown_event_suggests_close_ones(wakeful: Wakeful, book: Book, journal: Path) -> None:
    result = wakeful("why", book.event_of(1)[:5] + "zz", "--journal", journal)
    assert result.exit_code == 1
    assert result.stdout == ""
    assert book.event_of(1) in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_text_from_the_world_cannot_steer_the_terminal(wakeful: Wakeful, tmp_path: Path) -> None:
    book = Book()
    process = book.admit("\x1b[2Jkind\x07", "arm\nerror: all is lost")
    book.run_through(process)
    path = written(list(book.lines()), tmp_path / "hostile.db")
    for arguments in (("why", book.event_of(process)), ("events",), ("processes", "--all")):
        assert not {"\x1b", "\x07"} & set(wakeful(*arguments, "--journal", path).stdout)


def test_a_sample_is_drawn_by_its_seed(wakeful: Wakeful, journal: Path) -> None:
    first, again, other = (
        [
            told["event"]["id"]
            for told in json.loads(wakeful("why", "--sample", 3, "--seed", seed, "--journal", journal, "--json").stdout)
        ]
        for seed in (0, 0, 1)
    )
    assert first == again != other
    assert len(first) == 3
    assert wakeful("why", "--sample", 3, "--journal", journal).stdout.count("\nDecision\n") >= 3


def test_an_event_and_a_sample_exclude_each_other(wakeful: Wakeful, journal: Path) -> None:
    assert wakeful("why", "abc", "--sample", 3, "--journal", journal).exit_code == 2


def test_a_journal_cannot_name_code_to_run(wakeful: Wakeful, tmp_path: Path) -> None:
    evil = tmp_path / "evil"
    evil.mkdir()
    (evil / "domain.toml").write_text('name = "evil"\nversion = 1\nsays = "a domain with code"\n')
    (evil / "detectors.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w').close()\nDETECTORS = {{}}\n")
    book = Book(domain=str(evil))
    book.train(1, 0, 1)
    process = book.admit(mode="auto", model=1)
    path = written(list(book.lines()), tmp_path / "evil.db", book.blobs)
    told = wakeful("why", book.event_of(process), "--journal", path)
    assert "is not on this machine" in " ".join(told.stdout.split())
    assert not (tmp_path / "ran").exists()


def test_weights_that_are_damaged_leave_the_rest_of_the_story(wakeful: Wakeful, tmp_path: Path) -> None:
    book = Book(domain="service_robot")
    book.train(1, 0, 1)
    process = book.admit(mode="auto", model=1)
    book.run_through(process)
    path = written(list(book.lines()), tmp_path / "damaged.db", book.blobs)
    result = wakeful("why", book.event_of(process), "--journal", path)
    assert result.exit_code == 0
    assert "cannot be recomputed" in result.stdout
    assert "joint 3 runs warm" in result.stdout


def test_the_learned_rules_that_spoke_are_said_in_words(wakeful: Wakeful, tmp_path: Path) -> None:
    shipped = load("service_robot").spec
    encoder = Encoder(shipped, shipped.treatments or Registry().names())
    # What has changed, as the event has, needs a diagnosis; anything else memory.
    x = np.random.default_rng(0).random((60, encoder.size)).round()
    x[:, encoder.relations[Relation.CHANGED]] = np.tile([1.0, 0.0, 0.0], 20)
    none = np.full(60, -1)
    job = TrainingJob(
        training=1, base_version=0, base_weights=b"", watermark=60, seed=0, epochs=2, treatments=("diagnosis", "memory"),
        labels=shipped.outcome.labels, features=x, treatment=np.tile([0, 1, 1], 20), result=none, refuted=none,
        weight=np.ones(60), held_back=np.arange(60) % 4 == 0,
    )  # fmt: skip
    quick = PooledSettings(
        rules=SearchSettings(chains=1, steps=120, steps_again=40), forest=ForestSettings(rounds=4), joined_from=10
    )
    book = Book(domain="service_robot", domain_version=shipped.version)
    book.train(1, 0, 1, weights=Pooled(quick).train(job)[1])
    process = book.admit(mode="auto", model=1)
    told = " ".join(
        wakeful(
            "why", book.event_of(process), "--journal", written(list(book.lines()), tmp_path / "w.db", book.blobs)
        ).stdout.split()
    )
    assert "against memory, in nats: network" in told
    assert "learned rules that spoke" in told
    assert "relation is changed: diagnosis with 0.9" in told
    assert "from 20 experiences" in told
