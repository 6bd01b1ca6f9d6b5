"""ROS messages as a recording holds them, and how they become observations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Final

import msgspec

from wakeful.bridges.content import excerpt, extra
from wakeful.bridges.instants import LATEST_NS
from wakeful.bridges.plain import TooLarge, plain
from wakeful.bridges.ros_messages import stamp_ns, values_of
from wakeful.contracts.bridge import Item
from wakeful.facts.events import Observation, Undecodable
from wakeful.facts.values import Value

if TYPE_CHECKING:
    from wakeful.bridges.ros_types import Encoding

MAX_MESSAGE_BYTES: Final = 64_000_000
_PEEK_MESSAGES: Final = 5_000


class RawMessage(msgspec.Struct, frozen=True):
    """One message, undecoded. ``kind`` is its type in the ROS 2 manner; ``definition`` is empty where the recording has none."""

    topic: str
    kind: str
    received_ns: int
    data: bytes
    encoding: str = "cdr"
    definition: str = ""
    idl: bool = False


class Broken(msgspec.Struct, frozen=True):
    """A part of the recording that no message could be taken from, and why."""

    reason: str
    excerpt: str = ""


Raws = Iterable[RawMessage | Broken]


def observations(source: str, raws: Raws, after: int = -1) -> Iterator[Item]:
    """Each raw message as one item at its own position; those up to ``after`` are passed over undecoded."""
    decoding = _Decoding()
    for position, raw in enumerate(raws):
        if position <= after:
            continue
        if isinstance(raw, Broken):
            yield Undecodable(source=source, position=position, reason=raw.reason, excerpt=raw.excerpt)
            continue
        try:
            at_ns, clock, values = decoding.of(raw)
        except ValueError as failure:
            yield Undecodable(source=source, position=position, reason=f"{raw.topic}: {failure}", excerpt=excerpt(raw.data[:80]))
            continue
        yield Observation(source=source, position=position, topic=raw.topic, at_ns=at_ns, values=values, clock=clock)


def channels(raws: Raws, topics: Iterable[str] = ()) -> tuple[str, ...]:
    """The channels of a recording's beginning: what the first decodable message of each topic carries.

    ``topics`` are those that the recording is known to have; one that didn't come yet is listed with its ``_type`` alone.
    """
    decoding = _Decoding()
    found: dict[str, list[str]] = {}
    for raw, _ in zip(raws, range(_PEEK_MESSAGES), strict=False):
        if isinstance(raw, RawMessage) and raw.topic not in found:
            try:
                found[raw.topic] = sorted(_names(decoding.of(raw)[2]))
            except ValueError:
                continue
    for topic in topics:
        found.setdefault(topic, ["_type"])
    return tuple(f"{topic}/{name}" for topic in sorted(found) for name in found[topic])


def _names(values: Mapping[str, Value], prefix: str = "") -> Iterator[str]:
    for name, value in values.items():
        yield f"{prefix}{name}"
        if isinstance(value, Mapping):
            yield from _names(value, f"{prefix}{name}.")


class _Decoding:
    """Decodes raw messages of every encoding. Raises ValueError, whose message says why a message could not be decoded."""

    def __init__(self) -> None:
        with extra("ros", "a ROS recording"):
            from wakeful.bridges.ros_types import Decoders  # noqa: PLC0415
        self._decoders = Decoders()

    def of(self, raw: RawMessage) -> tuple[int, str, dict[str, Value]]:
        """(time, clock, values) of a message."""
        if not -LATEST_NS < raw.received_ns < LATEST_NS:
            raise ValueError(f"received at {raw.received_ns} ns: no instant")
        if len(raw.data) > MAX_MESSAGE_BYTES:
            raise ValueError(f"a message of {len(raw.data):,} bytes; the limit is {MAX_MESSAGE_BYTES:,}")
        if raw.encoding == "json":
            return raw.received_ns, "receive", _json(raw.data)
        if raw.encoding not in ("cdr", "ros1"):
            raise ValueError(f"its encoding {raw.encoding!r} is not read here (cdr, ros1 and json are)")
        encoding: Encoding = "ros1" if raw.encoding == "ros1" else "cdr"
        message = self._decoders.decode(raw.data, raw.kind, raw.definition, encoding, idl=raw.idl)
        try:
            values, stamp = values_of(message, raw.kind), stamp_ns(message, raw.received_ns)
        except (AttributeError, TypeError, IndexError, OverflowError) as failure:
            raise ValueError(f"not shaped like a {raw.kind}: {failure}") from failure
        return (raw.received_ns, "receive", values) if stamp is None else (stamp, "header", values)


def _json(data: bytes) -> dict[str, Value]:
    try:
        value = plain(msgspec.json.decode(data))
    except (msgspec.DecodeError, RecursionError, TooLarge) as failure:
        raise ValueError(f"not JSON that can be read: {failure}") from failure
    return dict(value) if isinstance(value, Mapping) else {"value": value}
