"""A plain watchdog: starts a command, hears its heartbeat by systemd's protocol, starts it again when it crashes or stalls."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import msgspec

#: The signals that are handed on to the command; after one of the first two it is not started again.
ENDING = (signal.SIGTERM, signal.SIGINT)
HANDED_ON = (*ENDING, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2)

#: Between being told that it has stalled (SIGABRT, so that it can say where) and being killed.
GRACE_S = 2.0

#: An exit with this code is a wrong command line: trying again would not mend it.
USAGE = 2

_DATAGRAM_BYTES = 4096


class WatchSettings(msgspec.Struct, frozen=True, kw_only=True):
    """How a command is watched.

    ``stall_s``: without a heartbeat for so long it has stalled. ``start_s``: so long it may take until it is ready; 0: it is not
    expected to say so, and is watched for its end alone until it does. ``stop_s``: so long it may take to end when asked to.
    ``give_up_after``: failures in a row after which it is left; 0: never. ``steady_s``: a run that was ready for so long ends a
    row. ``backoff_s``: before the first new start of a row, twice that before the next, at most ``longest_backoff_s``.
    """

    stall_s: float = 30.0
    start_s: float = 300.0
    stop_s: float = 90.0
    give_up_after: int = 10
    steady_s: float = 60.0
    backoff_s: float = 0.5
    longest_backoff_s: float = 30.0


class Ended(msgspec.Struct, frozen=True):
    """How one run of the command ended: its exit code (128 and the signal's number where one ended it), and in which words."""

    code: int
    how: str
    ready_s: float
    """For how long it had been ready."""
    asked: bool
    """Whether it had been told to end."""


class Watchdog:
    """Runs one command until it ends in good order, is told to end, or fails too often.

    The command is the leader of a process group of its own; signals go to it alone, a kill to the whole group. It
    finds the socket in ``NOTIFY_SOCKET`` and the limit in ``WATCHDOG_USEC``; ``wakeful run`` and live minds speak the protocol.

    Args:
        command: the program with its arguments.
        settings: when it has stalled, and when to give up.
        environment: the command's; the socket's variables are added.
        say: told what happens, one sentence at a time.
    """

    def __init__(
        self, command: Sequence[str], settings: WatchSettings, environment: Mapping[str, str], say: Callable[[str], None]
    ) -> None:
        self._command = list(command)
        self._settings = settings
        self._environment = dict(environment)
        self._say = say
        self._ending = 0
        self._pid = 0
        self._ready_at_s: float | None = None
        self._heard_at_s = 0.0
        self._status = ""

    def run(self) -> int:
        """Watch until it is over; returns the exit code to end with: the command's own of its last run.

        Raises:
            OSError: the command cannot be started at all.
        """
        waits_for = {*HANDED_ON, signal.SIGCHLD}
        before = signal.pthread_sigmask(signal.SIG_BLOCK, waits_for)
        folder = Path(tempfile.mkdtemp(prefix="wakeful-watch-"))  # its owner's alone: nobody else can send a heartbeat
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
                heard.bind(str(folder / "notify"))
                heard.setblocking(False)
                return self._runs(heard, folder / "notify")
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def _runs(self, heard: socket.socket, address: Path) -> int:
        failures = 0
        while True:
            self._start(address)
            ended = self._until_it_ends(heard)
            if ended.code == 0 or ended.asked or (ended.code == USAGE and not ended.ready_s):
                return ended.code
            failures = 1 if ended.ready_s >= self._settings.steady_s else failures + 1
            if self._settings.give_up_after and failures >= self._settings.give_up_after:
                self._say(f"{ended.how}; given up after {failures} failures in a row")
                return ended.code
            wait_s = min(self._settings.backoff_s * 2 ** (failures - 1), self._settings.longest_backoff_s)
            self._say(f"{ended.how}; starting again in {wait_s:g} s (failure {failures} in a row)")
            if self._pause(wait_s):
                return 128 + self._ending

    def _start(self, address: Path) -> None:
        environment = {
            **self._environment,
            "NOTIFY_SOCKET": str(address),
            "WATCHDOG_USEC": str(round(self._settings.stall_s * 1e6)),
            # Whoever is killed for a stall says on its standard error where it was.
            "PYTHONFAULTHANDLER": self._environment.get("PYTHONFAULTHANDLER", "1"),
        }
        environment.pop("WATCHDOG_PID", None)  # the command may be a wrapper: whoever speaks the protocol is meant
        self._ready_at_s, self._heard_at_s, self._status = None, time.monotonic(), ""
        self._pid = os.posix_spawnp(self._command[0], self._command, environment, setpgroup=0, setsigmask=())

    def _until_it_ends(self, heard: socket.socket) -> Ended:
        tick_s = min(0.2, self._settings.stall_s / 8)
        began_s = time.monotonic()
        told_at_s: float | None = None
        why = ""
        while True:
            self._hand_on(tick_s)
            self._hear(heard)
            now_s = time.monotonic()
            pid, status = os.waitpid(self._pid, os.WNOHANG)
            if pid:
                self._kill(signal.SIGKILL)  # what it may have left behind in its group
                ready_s = now_s - self._ready_at_s if self._ready_at_s is not None else 0.0
                code = os.waitstatus_to_exitcode(status)
                how = why or (f"ended by {_name(-code)}" if code < 0 else f"ended with code {code}")
                return Ended(
                    code=128 - code if code < 0 else code,
                    how=f"process {self._pid} {how} after {now_s - began_s:.1f} s",
                    ready_s=ready_s,
                    asked=bool(self._ending),
                )
            limit_s = self._limit_s()
            if told_at_s is not None:
                if now_s - told_at_s > GRACE_S:
                    self._kill(signal.SIGKILL)
            elif limit_s and now_s - self._heard_at_s > limit_s:
                why = f"{self._lateness()} for {now_s - self._heard_at_s:.1f} s and was killed" + (
                    f" (last heard: {self._status})" if self._status else ""
                )
                told_at_s = now_s
                self._kill(signal.SIGABRT)

    def _limit_s(self) -> float:
        if self._ending:
            return self._settings.stop_s
        return self._settings.stall_s if self._ready_at_s is not None else self._settings.start_s

    def _lateness(self) -> str:
        if self._ending:
            return "did not end"
        return "stalled" if self._ready_at_s is not None else "did not become ready"

    def _hear(self, heard: socket.socket) -> None:
        while True:
            try:
                text = heard.recv(_DATAGRAM_BYTES).decode(errors="replace")
            except BlockingIOError:
                return
            for line in text.splitlines():
                name, _, value = line.partition("=")
                if name == "READY" and self._ready_at_s is None:
                    self._ready_at_s = self._heard_at_s = time.monotonic()
                elif name == "WATCHDOG" and not self._ending:
                    self._heard_at_s = time.monotonic()
                elif name == "STATUS":
                    self._status = "".join(letter if letter.isprintable() else " " for letter in value)[:200]

    def _hand_on(self, within_s: float) -> None:
        """Wait at most so long for a signal; hand it on, and remember that it is to end."""
        came = signal.sigtimedwait((*HANDED_ON, signal.SIGCHLD), within_s)
        if came is None or came.si_signo == signal.SIGCHLD:
            return
        if came.si_signo in ENDING and not self._ending:
            self._ending, self._heard_at_s = came.si_signo, time.monotonic()
        os.kill(self._pid, came.si_signo)  # it is not reaped yet: the number is still its own

    def _pause(self, seconds: float) -> bool:
        """Wait before the next start; whether it was told to end meanwhile."""
        until_s = time.monotonic() + seconds
        while (left_s := until_s - time.monotonic()) > 0 and not self._ending:
            came = signal.sigtimedwait((*HANDED_ON, signal.SIGCHLD), left_s)
            if came is not None and came.si_signo in ENDING:
                self._ending = came.si_signo
        return bool(self._ending)

    def _kill(self, number: int) -> None:
        try:
            os.killpg(self._pid, number)
        except (ProcessLookupError, PermissionError):
            return  # nobody is left in the group


def _name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
