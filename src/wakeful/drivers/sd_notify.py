"""systemd's notify protocol, in a few lines: readiness, a status line, and a heartbeat that stops when the mind does.

The same datagrams go to systemd (``Type=notify``, ``WatchdogSec=``) and to ``wakeful watch``; see sd_notify(3).
"""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar

T = TypeVar("T")

#: A status line is cut to this length: it is for a person's eye.
LONGEST_STATUS = 200

#: So many heartbeats fit into the time after which the supervisor takes the mind for stalled.
BEATS_PER_LIMIT = 3


class Notifier:
    """Datagrams to the supervisor's socket. One that cannot be sent is lost: the mind never waits for its supervisor.

    Args:
        address: the socket's path; one that begins with ``@`` lies in the abstract namespace.
        limit_s: after how many seconds without a heartbeat the supervisor acts; None: it does not.
    """

    def __init__(self, address: str, limit_s: float | None = None) -> None:
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self.limit_s = limit_s
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)

    @classmethod
    def from_environment(cls, environment: Mapping[str, str], pid: int) -> Notifier | None:
        """As ``NOTIFY_SOCKET``, ``WATCHDOG_USEC`` and ``WATCHDOG_PID`` say; None where no supervisor listens."""
        address = environment.get("NOTIFY_SOCKET", "")
        if not address.startswith(("/", "@")):
            return None
        limit = environment.get("WATCHDOG_USEC", "")
        for_us = environment.get("WATCHDOG_PID", str(pid)) == str(pid)
        limit_s = int(limit) / 1e6 if limit.isdecimal() and int(limit) and for_us else None
        return cls(address, limit_s)

    def tell(self, *assignments: str) -> bool:
        """Send ``NAME=value`` lines; whether they were taken."""
        text = "\n".join(each.replace("\n", " ") for each in assignments)
        try:
            self._socket.sendto(text.encode(), socket.MSG_DONTWAIT, self._address)
        except OSError:
            return False  # the supervisor is gone or busy: it is the one who acts on silence
        return True

    def close(self) -> None:
        """Let go of the socket."""
        self._socket.close()


class Heart:
    """Beats towards the supervisor as long as the mind's pump goes on: a thread of its own passes on that there was progress.

    The pump says ``beat`` whenever it has got on, and rests where it waits for its source or for a reasoner. A pump that neither
    gets on nor rests is stalled, and so is one whose interpreter is held: then no beat is sent, and the supervisor acts.

    Args:
        notifier: where to; None: nobody listens, and nothing is sent.
    """

    def __init__(self, notifier: Notifier | None = None) -> None:
        self._notifier = notifier
        self._beats = 0
        self._resting = 0
        self._stopped = threading.Event()
        self._thread: threading.Thread | None = None
        self._says: Callable[[], str] = str

    @classmethod
    def from_environment(cls) -> Heart:
        """Beats for whoever supervises this process, if anybody does."""
        return cls(Notifier.from_environment(os.environ, os.getpid()))

    @property
    def every_s(self) -> float | None:
        """How often the pump must have got on; None where nobody minds."""
        limit_s = self._notifier.limit_s if self._notifier is not None else None
        return None if limit_s is None else limit_s / BEATS_PER_LIMIT

    def ready(self, says: Callable[[], str]) -> None:
        """The mind has recovered and takes events from here on. ``says`` gives the status line; it is called in the thread."""
        if self._notifier is None:
            return
        self._says = says
        self._notifier.tell("READY=1", f"STATUS={says()[:LONGEST_STATUS]}")
        if self.every_s is not None and self._thread is None:
            self._thread = threading.Thread(target=self._pass_on, name="wakeful-heart", daemon=True)
            self._thread.start()

    def beat(self) -> None:
        """The pump has got on."""
        self._beats += 1

    def over(self, items: Iterable[T]) -> Iterable[T]:
        """The same items; to wait for the next one is to rest, to have it is to get on."""
        return items if self.every_s is None else self._over(iter(items))

    def _over(self, items: Iterator[T]) -> Iterator[T]:
        while True:
            with self:
                try:
                    item = next(items)
                except StopIteration:
                    return
            yield item

    def __enter__(self) -> None:
        """Within it the pump rests: it waits for somebody outside, who has a limit of his own."""
        self._resting += 1

    def __exit__(self, *_: object) -> None:
        self._resting -= 1
        self._beats += 1

    def _pass_on(self) -> None:
        passed = -1
        while self._notifier is not None and not self._stopped.wait(self.every_s):
            if self._beats != passed or self._resting:
                passed = self._beats
                self._notifier.tell("WATCHDOG=1", f"STATUS={self._says()[:LONGEST_STATUS]}")

    def stop(self, why: str = "") -> None:
        """The mind ends in good order: the supervisor is told, and the thread is let go of."""
        if self._notifier is None:
            return
        self._notifier.tell("STOPPING=1", f"STATUS={why or 'stopping'}")
        self._stopped.set()
        if self._thread is not None:
            self._thread.join()
        self._notifier.close()
        self._notifier = None
