"""The stream of messages itself: numbers that are missing, come twice or out of order, a clock that runs back, silence.

Silence is told when the vehicle speaks again: until then there is no message of its own that could be registered."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.domains.vda5050.lasting import Lasting
from wakeful.domains.vda5050.message import StateMessage
from wakeful.domains.vda5050.sign import Sign
from wakeful.facts.events import Phase
from wakeful.facts.time import NS_PER_S

CLEAN_NS = 60 * NS_PER_S
"""A fault of the stream is over when it has not come again for so long."""

WARNING = 1


class Stream(msgspec.Struct):
    """What is remembered of a vehicle's messages. ``heard_ns`` is the latest time that a message carried."""

    lasting: Lasting = msgspec.field(default_factory=Lasting)
    header: int | None = None
    heard_ns: int | None = None
    fault_ns: dict[str, int] = {}


class Heard(msgspec.Struct):
    """What a message's number and time show; ``stale``: its content is older than what is known, or known already."""

    signs: list[Sign]
    stale: bool = False


def look(message: StateMessage, memory: Stream, at_ns: int, silence_ns: int) -> Heard:
    """Compare number and time with those of the message before it. The same number at a later time is no fault: there are
    vehicles that don't count."""
    last, heard_ns = memory.header, memory.heard_ns
    if last is None or heard_ns is None or message.header is None:
        memory.heard_ns = at_ns if heard_ns is None else max(heard_ns, at_ns)
        memory.header = message.header if message.header is not None else last
        return Heard([])
    step, back = message.header - last, at_ns < heard_ns
    faults: dict[str, str] = {}
    signs: list[Sign] = []
    stale = False
    if at_ns - heard_ns >= silence_ns:
        signs.append(Sign(kind="silence", says=f"had sent no state for {(at_ns - heard_ns) / NS_PER_S:.0f} s", criticality=2))
    if step == 0 and at_ns == heard_ns:
        faults["repeated"], stale = f"message {message.header} came twice", True
    elif step <= 0 and back:
        faults["order"], stale = f"message {message.header} came after {last}", True
    elif step < 0:
        signs.append(
            Sign(kind="restart", says=f"began to count its messages anew at {message.header} after {last}", criticality=1)
        )
    elif back:
        faults["clock"] = f"its clock ran back by {(heard_ns - at_ns) / NS_PER_S:.1f} s at message {message.header}"
    elif step > 1:
        missing = "1 message is" if step == 2 else f"{step - 1} messages are"
        faults["gap"] = f"stream: {missing} missing before number {message.header}"
    if not stale:
        memory.header = message.header
        memory.heard_ns = at_ns
    for name, says in faults.items():
        memory.fault_ns[name] = heard_ns if back else at_ns
        signs.append(_sign(name, memory.lasting.see(name, WARNING, memory.fault_ns[name]), says))
    signs.extend(_over(memory, at_ns, set(faults)))
    return Heard(signs, stale)


def _over(memory: Stream, at_ns: int, faults: set[str]) -> Iterator[Sign]:
    for name in [name for name in memory.lasting.open if name not in faults and name in memory.fault_ns]:
        if at_ns - memory.fault_ns[name] >= CLEAN_NS and memory.lasting.see(name, 0, at_ns) is Phase.CLEARED:
            del memory.fault_ns[name]
            yield _sign(name, Phase.CLEARED, "messages come in order again")


def _sign(name: str, phase: Phase | None, says: str) -> Sign:
    return Sign(
        kind="stream_fault", type=f"stream_{name}", phase=phase, level=WARNING, criticality=1, fields={"fault": name}, says=says
    )
