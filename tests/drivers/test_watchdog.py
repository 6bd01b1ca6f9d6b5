"""The plain watchdog, around real processes: small programs that crash, stall, succeed, or are told to end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

WATCH = [sys.executable, "-m", "wakeful", "watch", "--backoff-s", "0.01"]

#: What each small program begins with: counting its own starts, and speaking the protocol.
PREAMBLE = """
import os, signal, socket, sys, time
count = os.path.join(sys.argv[1], "starts")
with open(count, "a") as file:
    file.write("x")
starts = os.path.getsize(count)
supervisor = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
def tell(text):
    supervisor.sendto(text.encode(), os.environ["NOTIFY_SOCKET"])
"""


def program(folder: Path, body: str) -> list[str]:
    file = folder / "program.py"
    file.write_text(PREAMBLE + body)
    return [sys.executable, str(file), str(folder)]


def watch(folder: Path, body: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = [*WATCH, *options, "--", *program(folder, body)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def starts(folder: Path) -> int:
    return (folder / "starts").stat().st_size


def test_a_command_that_succeeds_is_run_once(tmp_path: Path) -> None:
    done = watch(tmp_path, "print('done')")
    assert (done.returncode, done.stdout, done.stderr, starts(tmp_path)) == (0, "done\n", "", 1)


def test_a_command_that_crashes_is_started_again_until_it_succeeds(tmp_path: Path) -> None:
    done = watch(tmp_path, "if starts < 4: os.kill(os.getpid(), signal.SIGKILL)")
    assert (done.returncode, starts(tmp_path)) == (0, 4)
    assert done.stderr.count("ended by SIGKILL") == 3


def test_a_command_that_fails_too_often_is_left_with_its_own_code(tmp_path: Path) -> None:
    done = watch(tmp_path, "sys.exit(7)", "--give-up-after", "3")
    assert (done.returncode, starts(tmp_path)) == (7, 3)
    assert "given up after 3 failures in a row" in done.stderr


def test_one_that_is_killed_too_often_is_left_with_the_signals_code(tmp_path: Path) -> None:
    done = watch(tmp_path, "os.kill(os.getpid(), signal.SIGSEGV)", "--give-up-after", "1")
    assert done.returncode == 128 + signal.SIGSEGV


def test_a_wrong_command_line_is_not_tried_again(tmp_path: Path) -> None:
    done = watch(tmp_path, "sys.exit(2)")
    assert (done.returncode, starts(tmp_path)) == (2, 1)


def test_a_program_that_is_not_there_is_one_clear_error(tmp_path: Path) -> None:
    done = subprocess.run([*WATCH, "--", str(tmp_path / "nothing")], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "cannot be started" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_command_that_stalls_says_where_and_is_started_again(tmp_path: Path) -> None:
    body = "tell('READY=1\\nSTATUS=7 admitted')\ndef spin():\n    while True: pass\nif starts == 1: spin()"
    done = watch(tmp_path, body, "--stall-s", "2")
    assert (done.returncode, starts(tmp_path)) == (0, 2)
    assert "stalled" in done.stderr
    assert "7 admitted" in done.stderr
    assert "in spin" in done.stderr, "the trace of where it hung is missing"


def test_one_that_ignores_the_abort_is_killed_all_the_same(tmp_path: Path) -> None:
    body = "signal.signal(signal.SIGABRT, signal.SIG_IGN)\ntell('READY=1')\nif starts == 1: time.sleep(60)"
    done = watch(tmp_path, body, "--stall-s", "2")
    assert (done.returncode, starts(tmp_path)) == (0, 2)


def test_one_that_beats_is_left_alone(tmp_path: Path) -> None:
    body = "tell('READY=1')\nfor _ in range(12):\n    time.sleep(0.5)\n    tell('WATCHDOG=1')"
    done = watch(tmp_path, body, "--stall-s", "4")
    assert (done.returncode, starts(tmp_path)) == (0, 1)


def test_one_that_never_becomes_ready_is_started_again_unless_it_need_not(tmp_path: Path) -> None:
    done = watch(tmp_path, "if starts == 1: time.sleep(60)", "--start-s", "4")
    assert (done.returncode, starts(tmp_path)) == (0, 2)
    assert "did not become ready" in done.stderr
    done = watch(tmp_path, "time.sleep(0.5)", "--start-s", "0", "--stall-s", "0.1")
    assert (done.returncode, starts(tmp_path)) == (0, 3)


def test_what_it_started_itself_does_not_outlive_it(tmp_path: Path) -> None:
    body = (
        "import subprocess\nchild = subprocess.Popen(['sleep', '60'])\n"
        "open(os.path.join(sys.argv[1], 'child'), 'w').write(str(child.pid))\nos.kill(os.getpid(), signal.SIGKILL)"
    )
    watch(tmp_path, body, "--give-up-after", "1")
    child = Path("/proc") / (tmp_path / "child").read_text()
    until_s = time.monotonic() + 10
    while child.exists() and "Z" not in (child / "stat").read_text().split()[2] and time.monotonic() < until_s:
        time.sleep(0.01)
    assert not child.exists() or "Z" in (child / "stat").read_text().split()[2]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_told_to_end_it_hands_that_on_and_starts_nothing_again(number: int, tmp_path: Path) -> None:
    body = (
        "def stop(number, frame):\n    open(os.path.join(sys.argv[1], 'got'), 'w').write(str(number))\n    sys.exit(5)\n"
        f"signal.signal({int(number)}, stop)\ntell('READY=1')\nopen(os.path.join(sys.argv[1], 'up'), 'w').close()\ntime.sleep(60)"
    )
    watching = subprocess.Popen([*WATCH, "--", *program(tmp_path, body)], stderr=subprocess.PIPE, text=True)
    until_s = time.monotonic() + 30
    while not (tmp_path / "up").exists() and time.monotonic() < until_s:
        time.sleep(0.01)
    watching.send_signal(number)
    _, errors = watching.communicate(timeout=30)
    assert watching.returncode == 5, errors
    assert (tmp_path / "got").read_text() == str(int(number))
    assert starts(tmp_path) == 1


def test_one_that_does_not_end_when_told_to_is_killed(tmp_path: Path) -> None:
    body = (
        "signal.signal(signal.SIGTERM, signal.SIG_IGN)\nsignal.signal(signal.SIGABRT, signal.SIG_IGN)\n"
        "tell('READY=1')\nopen(os.path.join(sys.argv[1], 'up'), 'w').close()\ntime.sleep(60)"
    )
    watching = subprocess.Popen([*WATCH, "--stop-s", "0.2", "--", *program(tmp_path, body)], stderr=subprocess.PIPE, text=True)
    until_s = time.monotonic() + 30
    while not (tmp_path / "up").exists() and time.monotonic() < until_s:
        time.sleep(0.01)
    watching.terminate()
    watching.communicate(timeout=30)
    assert watching.returncode == 128 + signal.SIGKILL
    assert starts(tmp_path) == 1


def test_a_real_run_becomes_ready_and_ends_in_good_order(tmp_path: Path) -> None:
    run = [sys.executable, "-m", "wakeful", "run", "service_robot", "--events", "30", "--journal", str(tmp_path / "mind.db")]
    environment = {**os.environ, "WAKEFUL_STALL_S": "20"}
    done = subprocess.run([*WATCH, "--", *run], capture_output=True, text=True, timeout=120, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    assert "watch:" not in done.stderr
    assert "30 admitted" in done.stdout
