"""Everything else that a state message says of a vehicle: safety, mode, power, motion, order, load."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot

import msgspec

from wakeful.domains.vda5050.lasting import Lasting
from wakeful.domains.vda5050.message import LEVELS, Place, StateMessage
from wakeful.domains.vda5050.sign import CRITICALITY, Sign
from wakeful.facts.domain import DetectorSpec
from wakeful.facts.events import Phase
from wakeful.facts.time import NS_PER_S, to_ns
from wakeful.facts.values import Field

WARNING, URGENT, FATAL = LEVELS.index("warning"), LEVELS.index("urgent"), LEVELS.index("fatal")
UNATTENDED = {"AUTOMATIC", "SEMIAUTOMATIC", "STARTUP", ""}
ENDED = {"FINISHED", "FAILED"}
ACTIONS = 256
QUIET_NS = 60 * NS_PER_S
"""A jump or a drop of the battery right after another is part of it."""


class Limits(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The detector's settings.

    Charge in percent; ``stall_s``: driving without getting anywhere; ``blind_stall_s``: the same where the vehicle tells no
    position; ``stuck_s``: an order without any progress; ``jump_m`` beyond what ``top_speed_m_s`` explains; ``unsure``: a
    localization score below it; ``silence_s``: the standard demands a message every 30 s.
    """

    low: float = 25.0
    critical: float = 10.0
    margin: float = 3.0
    drop: float = 10.0
    stall_s: float = 20.0
    blind_stall_s: float = 300.0
    stuck_s: float = 120.0
    moved_m: float = 0.3
    jump_m: float = 3.0
    top_speed_m_s: float = 3.0
    unsure: float = 0.3
    silence_s: float = 60.0

    @classmethod
    def of(cls, spec: DetectorSpec) -> Limits:
        """The settings that a domain gives. Raises ValueError naming an unknown one, or one of the wrong type."""
        try:
            return msgspec.convert(spec.settings, cls)
        except msgspec.ValidationError as error:
            known = ", ".join(cls.__struct_fields__)
            raise ValueError(f"detector {spec.detector}: settings: {error}; it knows {known}") from error


class Watched(msgspec.Struct):
    """What is remembered of one vehicle to see what changes. None: not told yet."""

    lasting: Lasting = msgspec.field(default_factory=Lasting)
    charge: float | None = None
    charging: bool | None = None
    dropped_ns: int | None = None
    place: Place | None = None
    placed_ns: int = 0
    jumped_ns: int | None = None
    anchor: Place | None = None
    travelled_m: float | None = None
    node_number: int | None = None
    moved_ns: int | None = None
    order: str = ""
    nodes_left: int = 0
    progress: str = ""
    progress_ns: int | None = None
    actions: dict[str, str] = {}
    loads: tuple[str, ...] | None = None


def look(message: StateMessage, memory: Watched, limits: Limits, at_ns: int) -> Iterator[Sign]:
    """What the message shows beside its errors. What it doesn't say is as it was."""
    yield from _safety(message, memory, at_ns)
    yield from _power(message, memory, limits, at_ns)
    moved = _moved(message, memory, limits, at_ns)
    yield from _position(message, memory, limits, at_ns)
    yield from _stall(message, memory, limits, at_ns)
    before = memory.actions
    yield from _actions(message, memory, at_ns)
    yield from _order(message, memory, limits, at_ns, moved)
    handled = before != memory.actions or "RUNNING" in memory.actions.values()
    yield from _load(message, memory, handled)


def _lasting(
    memory: Watched, kind: str, level: int, at_ns: int, says: str, what: str = "", fields: dict[str, Field] | None = None
) -> Iterator[Sign]:
    before = memory.lasting.open.get(kind)
    was = 0 if before is None else before.level
    phase = memory.lasting.see(kind, level, at_ns, what)
    if phase is not None:
        yield Sign(
            kind=kind,
            type=kind,
            phase=phase,
            level=level,
            criticality=CRITICALITY[level],
            rose=phase is Phase.CHANGED and level > was,
            stops=kind == "emergency_stop" and phase is Phase.RAISED,
            fields=fields or {},
            says=says if level else f"{kind.replace('_', ' ')} is over",
        )


def _safety(message: StateMessage, memory: Watched, at_ns: int) -> Iterator[Sign]:
    if message.stop:
        stopped = message.stop != "NONE"
        # A stop that releases itself is over when the way is free; the others need a person.
        level = 0 if not stopped else URGENT if message.stop == "AUTOACK" else FATAL
        says = f"emergency stop ({message.stop})"
        yield from _lasting(memory, "emergency_stop", level, at_ns, says, message.stop, {"stop": message.stop})
    if message.field_violation is not None:
        level = URGENT if message.field_violation else 0
        yield from _lasting(memory, "field_violation", level, at_ns, "something is in the protective field")
    if message.mode:
        attended = message.mode not in UNATTENDED
        level = (URGENT if message.mode == "INTERVENED" else WARNING) if attended else 0
        yield from _lasting(memory, "mode", level, at_ns, f"operating mode is {message.mode}", message.mode)
    if message.paused is not None:
        yield from _lasting(memory, "paused", WARNING if message.paused else 0, at_ns, "is paused")


def _power(message: StateMessage, memory: Watched, limits: Limits, at_ns: int) -> Iterator[Sign]:
    charge, charging = message.charge, message.charging
    if charging is not None:
        if memory.charging is not None and charging != memory.charging:
            says = f"{'began' if charging else 'ended'} charging" + ("" if charge is None else f" at {charge:.0f} %")
            yield Sign(kind="charging", says=says, criticality=0)
        memory.charging = charging
    if charge is None:
        return
    open_ = memory.lasting.open.get("battery")
    margin = limits.margin if open_ is not None else 0.0
    held = limits.margin if open_ is not None and open_.level == FATAL else 0.0
    level = FATAL if charge <= limits.critical + held else WARNING if charge <= limits.low + margin else 0
    words = "critically low" if level == FATAL else "low"
    yield from _lasting(memory, "battery", level, at_ns, f"battery is {words}: {charge:.0f} %")
    before, memory.charge = memory.charge, charge
    calm = memory.dropped_ns is None or not 0 <= at_ns - memory.dropped_ns < QUIET_NS
    if before is not None and before - charge >= limits.drop and calm:
        memory.dropped_ns = at_ns
        yield Sign(kind="battery_drop", says=f"battery fell from {before:.0f} to {charge:.0f} % at once", criticality=2)


def _moved(message: StateMessage, memory: Watched, limits: Limits, at_ns: int) -> bool:
    """Whether the vehicle has got anywhere since it last had."""
    moved = memory.moved_ns is None
    if message.node_number is not None and message.node_number != memory.node_number:
        memory.node_number, moved = message.node_number, True
    if message.travelled_m is not None and (
        memory.travelled_m is None or abs(message.travelled_m - memory.travelled_m) >= limits.moved_m
    ):
        memory.travelled_m, moved = message.travelled_m, True
    place, anchor = message.place, memory.anchor
    if place is not None and (
        anchor is None or place.map != anchor.map or hypot(place.x - anchor.x, place.y - anchor.y) >= limits.moved_m
    ):
        memory.anchor, moved = place, True
    if moved:
        memory.moved_ns = at_ns
    return moved


def _position(message: StateMessage, memory: Watched, limits: Limits, at_ns: int) -> Iterator[Sign]:
    place, before = message.place, memory.place
    if place is None:
        return
    open_ = "position" in memory.lasting.open
    unsure = place.score is not None and place.score < limits.unsure * (1.5 if open_ else 1.0)
    level = 0 if place.localized and not unsure else WARNING if place.localized else URGENT
    score = "" if place.score is None else f" (score {place.score:.2f})"
    says = f"position is {'lost' if level == URGENT else 'unsure'}{score}"
    yield from _lasting(memory, "position", level, at_ns, says)
    if before is not None and before.map == place.map and before.localized and place.localized:
        far_m = hypot(place.x - before.x, place.y - before.y)
        elapsed_s = max(0.0, (at_ns - memory.placed_ns) / NS_PER_S)
        calm = memory.jumped_ns is None or not 0 <= at_ns - memory.jumped_ns < QUIET_NS
        if far_m > limits.jump_m + limits.top_speed_m_s * elapsed_s and calm:
            memory.jumped_ns = at_ns
            says = f"position jumped by {far_m:.1f} m within {elapsed_s:.1f} s"
            yield Sign(kind="position_jump", says=says, criticality=1, fields={"jump_m": round(far_m, 2)})
    memory.place, memory.placed_ns = place, at_ns


def _stall(message: StateMessage, memory: Watched, limits: Limits, at_ns: int) -> Iterator[Sign]:
    if message.driving is None or memory.moved_ns is None:
        return
    held = message.paused or message.stop not in ("", "NONE") or message.field_violation
    if not message.driving or held:
        memory.moved_ns = at_ns
    blind = message.place is None and message.travelled_m is None
    elapsed_s = (at_ns - memory.moved_ns) / NS_PER_S
    stalled = elapsed_s >= (limits.blind_stall_s if blind else limits.stall_s)
    says = f"says that it drives but has got nowhere for {elapsed_s:.0f} s"
    yield from _lasting(memory, "stall", URGENT if stalled else 0, at_ns, says)


def _actions(message: StateMessage, memory: Watched, at_ns: int) -> Iterator[Sign]:
    if message.actions is None:
        return
    now = {action.id: action for action in message.actions}
    for action in now.values():
        level = URGENT if action.status == "FAILED" else WARNING if action.status == "RETRIABLE" else 0
        name = f"action {action.id}"
        phase = memory.lasting.see(name, level, at_ns)
        if phase is not None:
            words = f"action {action.type or action.id} is {action.status}" + (f": {action.result}" if action.result else "")
            yield _action(action.id, phase, level, words, action.type)
    for name in [name for name in memory.lasting.open if name.startswith("action ") and name[7:] not in now]:
        phase = memory.lasting.see(name, 0, at_ns)
        if phase is not None:
            yield _action(name[7:], phase, 0, f"action {name[7:]} is no longer listed", "")
    memory.actions = {action.id: action.status for action in list(now.values())[:ACTIONS]}


def _action(id_: str, phase: Phase, level: int, says: str, type_: str) -> Sign:
    return Sign(
        kind="action_failed",
        type="action_failed",
        references=(f"actionId={id_}",),
        phase=phase,
        level=level,
        criticality=CRITICALITY[level],
        fields={"action": type_} if type_ else {},
        says=says,
    )


def _order(message: StateMessage, memory: Watched, limits: Limits, at_ns: int, moved: bool) -> Iterator[Sign]:
    if message.order is not None:
        if memory.order and message.order != memory.order and memory.nodes_left > 0:
            left = f"{memory.nodes_left} node{'' if memory.nodes_left == 1 else 's'} to go"
            became = f"was replaced by order {message.order}" if message.order else "was dropped"
            says = f"order {memory.order} {became} with {left}"
            yield Sign(kind="order_replaced", says=says, criticality=1)
        memory.order = message.order
    if message.nodes_left is not None:
        memory.nodes_left = message.nodes_left
    open_actions = sum(status not in ENDED for status in memory.actions.values())
    statuses = ",".join(f"{id_}={status}" for id_, status in sorted(memory.actions.items()))
    progress = f"{memory.order}|{memory.nodes_left}|{message.node_number}|{statuses}"
    held = message.paused or message.mode not in UNATTENDED or message.stop not in ("", "NONE")
    if progress != memory.progress or moved or held or memory.progress_ns is None or at_ns < memory.progress_ns:
        memory.progress, memory.progress_ns = progress, at_ns
    pending = bool(memory.order) and (memory.nodes_left > 0 or open_actions > 0)
    stuck = pending and at_ns - memory.progress_ns >= to_ns(limits.stuck_s)
    says = f"order {memory.order} has made no progress for {(at_ns - memory.progress_ns) / NS_PER_S:.0f} s"
    yield from _lasting(memory, "order_stuck", URGENT if stuck else 0, at_ns, says)


def _load(message: StateMessage, memory: Watched, handled: bool) -> Iterator[Sign]:
    """A load that comes or goes while an action runs is the work itself; otherwise it is worth an event."""
    if message.loads is None:
        return
    before, memory.loads = memory.loads, message.loads
    if before is None or before == message.loads or handled:
        return
    says = f"carries {', '.join(message.loads) or 'nothing'} instead of {', '.join(before) or 'nothing'}"
    lost = len(message.loads) < len(before)
    yield Sign(kind="load", says=f"{says} although nothing was being handled", criticality=2 if lost else 1)
