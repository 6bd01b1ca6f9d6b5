"""Every file that wakeful makes is its owner's alone, whatever the umask; and no name from outside leads out of its folder."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from wakeful.cli.options import state_directory
from wakeful.cli.sources import Source, default_journal
from wakeful.domains import load
from wakeful.facts.inputs import Act
from wakeful.journal import open_journal
from wakeful.journal.acts import ActSpool
from wakeful.journal.lock import FileLock


def test_a_runs_files_are_its_owners_alone_under_the_most_open_umask(tmp_path: Path) -> None:
    journal = tmp_path / "state" / "wakeful" / "mind.db"
    journal.parent.mkdir(parents=True)
    environment = {**os.environ, "XDG_STATE_HOME": str(tmp_path / "state"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    script = "import os, sys; os.umask(0); sys.argv[0] = 'wakeful'; from wakeful.cli.main import main; main()"

    def wakeful(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", script, *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120, env=environment)

    assert wakeful("run", "service_robot", "--events", "20", "--journal", str(journal)).returncode == 0
    with open_journal(journal):  # somebody writes it, so that an act must be handed over
        ActSpool(journal).put(Act(who="ann", act="hold", process=1, why="a test"))
    assert wakeful("run", "service_robot", "--events", "5").returncode == 0
    found = {path.relative_to(tmp_path / "state" / "wakeful") for path in journal.parent.rglob("*")}
    assert {Path("mind.db"), Path("mind.db.lock"), Path("mind.db.running"), Path("mind.db.acts")} <= found
    for path in journal.parent.rglob("*"):
        assert path.stat().st_mode & 0o077 == 0, f"{path.name} is open to others: {oct(path.stat().st_mode)}"


def test_a_lock_and_a_journal_that_are_there_already_keep_their_modes(tmp_path: Path) -> None:
    journal = tmp_path / "mind.db"
    open_journal(journal).close()
    assert journal.stat().st_mode & 0o777 == 0o600
    FileLock(journal).release()
    assert (tmp_path / "mind.db.lock").stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "/etc/cron.d/x", "..", "a/b\\c", "x\0y", "\u202e.db", "con.db", "~root", "$(reboot)", "a" * 400]
)
def test_a_sources_name_never_leads_its_journal_out_of_the_state_directory(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    source = Source(name=name, digest=name, domain=load("jsonl"), items=lambda _: ())
    path = default_journal(source)
    assert path.parent == state_directory()
    assert path.name.isascii() or all(letter.isalnum() or letter in "-_." for letter in path.name)
    assert len(path.name.encode()) < 200
    assert "\0" not in path.name


def test_a_source_named_by_its_content_is_only_text_in_the_journal(tmp_path: Path) -> None:
    hostile = "../../outside"
    lines = [{"event": {"kind": hostile, "entity": hostile, "fields": {hostile: hostile}}}]
    (tmp_path / "in.jsonl").write_text("\n".join(json.dumps(line) for line in lines))
    before = set(tmp_path.parent.iterdir())
    command = [sys.executable, "-m", "wakeful", "run", str(tmp_path / "in.jsonl"), "--domain", "jsonl"]
    done = subprocess.run(
        [*command, "--journal", str(tmp_path / "m.db")], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert set(tmp_path.parent.iterdir()) == before
    assert {path.name.split(".db")[0] for path in tmp_path.iterdir()} == {"in.jsonl", "m"}
