"""A circuit breaker: an endpoint that keeps failing is left alone for a while."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from threading import Lock

from wakeful.contracts.reasoner import ReasonerError


class CircuitOpen(ReasonerError):
    """The endpoint failed too often lately; it was not called."""


class Circuit(StrEnum):
    """closed: calls go through. open: none does. half_open: one trial call decides."""

    CLOSED = "closed"
    OPEN = "open"
    HALF_OPEN = "half_open"


class Breaker:
    """Opens after ``failures`` failed calls in a row, and lets one trial through each ``pause_s`` until one succeeds.

    ``admit`` gives a ticket, with which the call's end is reported. A call that was admitted before the circuit
    last changed says nothing about it now: its report is passed over.

    Args:
        failures: how many in a row open the circuit.
        pause_s: how long it stays open before a trial.
        clock: seconds that never run back.
    """

    def __init__(self, failures: int, pause_s: float, clock: Callable[[], float]) -> None:
        self._limit = failures
        self._pause_s = pause_s
        self._clock = clock
        self._failed = 0
        self._opened_s: float | None = None
        self._trial = False
        self._epoch = 0
        self._lock = Lock()

    @property
    def circuit(self) -> Circuit:
        """Where the circuit stands now."""
        with self._lock:
            return self._circuit()

    def check(self) -> None:
        """Raises CircuitOpen where ``admit`` would; takes nothing."""
        with self._lock:
            self._refuse_if_open()

    def admit(self) -> int:
        """Let one call through.

        Returns:
            The ticket for ``succeeded``, ``failed`` or ``withdrawn``, one of which must follow.

        Raises:
            CircuitOpen: the circuit is open, or half open with its trial under way.
        """
        with self._lock:
            self._refuse_if_open()
            if self._circuit() is Circuit.HALF_OPEN:
                self._trial = True
            return self._epoch

    def succeeded(self, ticket: int) -> None:
        """The endpoint answered."""
        with self._lock:
            if ticket == self._epoch:
                self._failed = 0
                if self._opened_s is not None:
                    self._change(None)

    def failed(self, ticket: int) -> None:
        """The endpoint failed, or did not answer in time."""
        with self._lock:
            if ticket == self._epoch:
                self._failed += 1
                if self._opened_s is not None or self._failed >= self._limit:
                    self._change(self._clock())

    def withdrawn(self, ticket: int) -> None:
        """The call was given up for a reason that is not the endpoint's; another may be the trial."""
        with self._lock:
            if ticket == self._epoch:
                self._trial = False

    def _circuit(self) -> Circuit:
        if self._opened_s is None:
            return Circuit.CLOSED
        return Circuit.HALF_OPEN if self._clock() - self._opened_s >= self._pause_s else Circuit.OPEN

    def _refuse_if_open(self) -> None:
        circuit = self._circuit()
        if circuit is Circuit.OPEN or (circuit is Circuit.HALF_OPEN and self._trial):
            raise CircuitOpen(
                f"the reasoner's endpoint failed {self._failed} times in a row; it is tried once every {self._pause_s:g} s"
            )

    def _change(self, opened_s: float | None) -> None:
        self._opened_s = opened_s
        self._trial = False
        self._epoch += 1
