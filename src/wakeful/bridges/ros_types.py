"""How raw ROS messages are decoded: by the definitions that a recording brings, else by those of ROS distributions.

Everything here needs the extra ``ros``; it is imported in one place, where it is wanted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final, Literal, TypeAlias

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

#: A decoded message: an instance of a class that is made from its definition.
Message: TypeAlias = Any
Decode: TypeAlias = Callable[[bytes], Message]
Encoding = Literal["ros1", "cdr"]

_SEPARATOR: Final = "=" * 80 + "\n"
#: Recordings before ROS 2 Iron bring no definitions. Types changed between distributions, so several are tried.
_DISTRIBUTIONS: Final[dict[Encoding, tuple[Stores, ...]]] = {
    "ros1": (Stores.ROS1_NOETIC,),
    "cdr": (Stores.ROS2_HUMBLE, Stores.ROS2_GALACTIC, Stores.ROS2_FOXY, Stores.ROS2_ELOQUENT, Stores.ROS2_DASHING, Stores.LATEST),
}


class Undecoded(ValueError):
    """A message that could not be decoded; the message says why."""


class Decoders:
    """Makes a decoder for each (type, definition), once. A definition that can't be understood spoils its own messages only."""

    def __init__(self) -> None:
        self._made: dict[tuple[Encoding, str, str], _Decoder] = {}
        self._distributions: dict[Stores, Typestore] = {}

    def decode(self, raw: bytes, kind: str, definition: str, encoding: Encoding, *, idl: bool = False) -> Message:
        """The decoded message.

        Args:
            raw: the serialised message.
            kind: its type in the ROS 2 manner, ``nav_msgs/msg/Odometry``.
            definition: the recording's definition of the type; empty where it brings none.
            idl: whether that is OMG IDL instead of a ROS message definition.

        Raises:
            Undecoded: the type is not known, or the bytes are not of that type.
        """
        key = (encoding, kind, definition)
        if (decoder := self._made.get(key)) is None:
            decoder = self._made[key] = _Decoder(kind, self._candidates(kind, definition, encoding, idl))
        return decoder(raw)

    def _candidates(self, kind: str, definition: str, encoding: Encoding, idl: bool) -> Iterator[Decode]:
        if definition:
            try:
                yield _by(_learned(kind, definition, idl), kind, encoding)
            except Exception as failure:
                # The parsers of definitions raise errors of their grammar's library beside their own.
                yield _refusing(f"its definition can't be understood: {type(failure).__name__}: {failure}")
        for name in _DISTRIBUTIONS[encoding]:
            if name not in self._distributions:
                self._distributions[name] = get_typestore(name)
            if kind in self._distributions[name].fielddefs:
                yield _by(self._distributions[name], kind, encoding)


class _Decoder:
    """Tries the candidates until one fits the bytes (their length tells), the one that fitted last first."""

    def __init__(self, kind: str, candidates: Iterator[Decode]) -> None:
        self._kind = kind
        self._tried: list[Decode] = []
        self._untried = candidates

    def __call__(self, raw: bytes) -> Message:
        reason = ""
        for decode in self._all():
            try:
                message = decode(raw)
            except Exception as failure:
                # Generated decoders raise whatever the bytes make them run into; there is no narrower type to name.
                reason = reason or (str(failure) if isinstance(failure, Undecoded) else f"{type(failure).__name__}: {failure}")
                continue
            if self._tried[0] is not decode:
                self._tried.remove(decode)
                self._tried.insert(0, decode)
            return message
        raise Undecoded(f"not a {self._kind}: {reason or 'the type is not known, and the recording brings no definition of it'}")

    def _all(self) -> Iterator[Decode]:
        yield from tuple(self._tried)
        for decode in self._untried:
            self._tried.append(decode)
            yield decode


def _learned(kind: str, definition: str, idl: bool) -> Typestore:
    store = get_typestore(Stores.EMPTY)
    if not idl:
        store.register(get_types_from_msg(definition, kind))
    elif definition.startswith(f"{_SEPARATOR}IDL: "):
        for part in definition.split(_SEPARATOR)[1:]:
            store.register(get_types_from_idl(part.split("\n", 1)[1]))
    else:
        store.register(get_types_from_idl(definition))
    return store


def _by(store: Typestore, kind: str, encoding: Encoding) -> Decode:
    if kind not in store.fielddefs:
        raise Undecoded("it does not define that type")
    if encoding == "ros1":
        return lambda raw: store.deserialize_ros1(raw, kind)
    return lambda raw: store.deserialize_cdr(raw, kind)


def _refusing(reason: str) -> Decode:
    def refuse(_: bytes) -> Message:
        raise Undecoded(reason)

    return refuse
