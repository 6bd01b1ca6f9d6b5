"""`wakeful experience`: what one robot learned from teaches another, once, and stays known as the first one's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.cli.conftest import Wakeful
from wakeful.cli.main import main
from wakeful.facts.lines import Decided, Imported, TrainingAsked
from wakeful.journal.audit import audit
from wakeful.journal.experience import carried, read_experience
from wakeful.journal.sqlite import open_journal
from wakeful.journal.views import history

pytest.importorskip("pyarrow")


def run(seed: int, events: int, path: Path) -> None:
    done = CliRunner().invoke(
        main, ["run", "service_robot", "--events", str(events), "--seed", str(seed), "--journal", str(path)]
    )
    assert done.exit_code == 0, done.output


@pytest.fixture(scope="module")
def teacher(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("teacher") / "robot.db"
    run(1, 120, path)
    return path


@pytest.fixture
def table(teacher: Path, tmp_path: Path, wakeful: Wakeful) -> Path:
    out = tmp_path / "experience.parquet"
    done = wakeful("experience", "export", "--journal", teacher, "--out", out)
    assert done.exit_code == 0, done.output
    return out


def test_a_table_reads_back_as_the_journals_experiences(teacher: Path, table: Path) -> None:
    with open_journal(teacher, read_only=True) as journal:
        made = list(carried(journal))
        assert len(made) == len({each.process for each in (gained.experience for gained in history(journal).gained.values())})
    assert made
    assert list(read_experience(table)) == made


def test_a_new_robot_that_imported_experience_has_a_model_before_its_first_outcome(
    table: Path, tmp_path: Path, wakeful: Wakeful
) -> None:
    path = tmp_path / "pupil.db"
    taken = json.loads(wakeful("experience", "import", table, "--journal", path, "--json").stdout)
    assert taken["imported"] > 50
    run(2, 40, path)
    with open_journal(path, read_only=True) as journal:
        assert audit(journal).ok
        records = [line.record for line in journal.lines()]
    asked = next(record for record in records if isinstance(record, TrainingAsked))
    assert asked.watermark == taken["imported"]
    assert any(isinstance(record, Decided) and record.decision.model == 1 for record in records)


def test_what_is_imported_twice_counts_once_and_keeps_its_origin(
    teacher: Path, table: Path, tmp_path: Path, wakeful: Wakeful
) -> None:
    path = tmp_path / "pupil.db"
    first = json.loads(wakeful("experience", "import", table, "--journal", path, "--json").stdout)
    second = json.loads(wakeful("experience", "import", table, "--journal", path, "--json").stdout)
    assert (second["imported"], second["known"]) == (0, first["imported"])
    own = json.loads(wakeful("experience", "import", table, "--journal", teacher, "--json").stdout)
    assert own["imported"] == 0
    again = tmp_path / "again.parquet"
    assert wakeful("experience", "export", "--journal", path, "--out", again).exit_code == 0
    places = [(each.origin, each.origin_id) for each in read_experience(table)]
    assert [(each.origin, each.origin_id) for each in read_experience(again)] == places


def test_imported_experience_is_no_event_and_no_trust(table: Path, tmp_path: Path, wakeful: Wakeful) -> None:
    path = tmp_path / "pupil.db"
    wakeful("experience", "import", table, "--journal", path)
    with open_journal(path, read_only=True) as journal:
        read = history(journal)
        assert {type(line.record) for line in journal.lines()} == {Imported}
    assert not read.events
    assert not read.trusted


def test_experience_of_another_domain_is_left_unless_it_is_asked_for(table: Path, tmp_path: Path, wakeful: Wakeful) -> None:
    path = tmp_path / "vehicle.db"
    done = CliRunner().invoke(main, ["run", "vda5050", "--events", "3", "--journal", str(path)])
    assert done.exit_code == 0, done.output
    left = json.loads(wakeful("experience", "import", table, "--journal", path, "--json").stdout)
    assert left["imported"] == 0
    assert left["foreign"] > 0


def test_a_file_that_is_no_table_of_experience_is_one_clear_error(tmp_path: Path, wakeful: Wakeful) -> None:
    junk = tmp_path / "junk.parquet"
    junk.write_bytes(b"PAR1 not really")
    done = wakeful("experience", "import", junk, "--journal", tmp_path / "new.db")
    assert done.exit_code == 1
    assert "cannot be read as a Parquet table" in done.output
