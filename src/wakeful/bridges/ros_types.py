"""How raw ROS messages are decoded: from the definitions that a recording brings, else from those of a ROS distribution.

Everything here needs the extra ``ros``; bridges import it in one place, where it is wanted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, Literal, TypeAlias

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

#: A decoded message: an instance of a class that is made from its definition.
Message: TypeAlias = Any
Decode: TypeAlias = Callable[[bytes], Message]
Encoding = Literal["ros1", "cdr"]

_SEPARATOR: Final = "=" * 80 + "\n"
#: Recordings before ROS 2 Iron bring no definitions; the newest such distribution first.
_DISTRIBUTIONS: Final[dict[Encoding, tuple[Stores, ...]]] = {
    "ros1": (Stores.ROS1_NOETIC,),
    "cdr": (Stores.ROS2_HUMBLE, Stores.ROS2_GALACTIC, Stores.ROS2_FOXY, Stores.ROS2_ELOQUENT, Stores.ROS2_DASHING, Stores.LATEST),
}


class Undecoded(ValueError):
    """A message that could not be decoded; the message says why."""


class Decoders:
    """Makes a decoder for each (type, definition), once. A definition that can't be understood spoils its own messages only."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str, str], Decode] = {}
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
            decoder = self._made[key] = self._make(kind, definition, encoding, idl)
        try:
            return decoder(raw)
        except Undecoded:
            raise
        except Exception as failure:
            # Generated decoders raise whatever the bytes make them run into; there is no narrower type to name.
            raise Undecoded(f"not a {kind}: {type(failure).__name__}: {failure}") from failure

    def _make(self, kind: str, definition: str, encoding: Encoding, idl: bool) -> Decode:
        if not definition:
            return self._guessing(kind, encoding)
        try:
            return _by(self._learned(kind, definition, idl), kind, encoding)
        except Exception as failure:
            # The parsers of definitions raise errors of their grammar's library beside their own.
            return _refusing(f"the definition of {kind} can't be understood: {type(failure).__name__}: {failure}")

    def _learned(self, kind: str, definition: str, idl: bool) -> Typestore:
        store = get_typestore(Stores.EMPTY)
        if not idl:
            store.register(get_types_from_msg(definition, kind))
        elif definition.startswith(f"{_SEPARATOR}IDL: "):
            for part in definition.split(_SEPARATOR)[1:]:
                store.register(get_types_from_idl(part.split("\n", 1)[1]))
        else:
            store.register(get_types_from_idl(definition))
        return store

    def _guessing(self, kind: str, encoding: Encoding) -> Decode:
        """A decoder for a type without definition: that of the first distribution whose definition fits the bytes.

        Types changed between distributions; a message of another one has another length, which decoding checks.
        """
        stores = [self._distribution(name) for name in _DISTRIBUTIONS[encoding]]
        fitting = [_by(store, kind, encoding) for store in stores if kind in store.fielddefs]
        if not fitting:
            return _refusing(f"the type {kind} is not known, and the recording brings no definition of it")

        def decode(raw: bytes) -> Message:
            first: Exception | None = None
            for decoder in fitting:
                try:
                    message = decoder(raw)
                except Exception as failure:
                    first = first or failure
                    continue
                fitting.remove(decoder)
                fitting.insert(0, decoder)
                return message
            raise first or Undecoded(f"no definition of {kind} fits")

        return decode

    def _distribution(self, name: Stores) -> Typestore:
        if name not in self._distributions:
            self._distributions[name] = get_typestore(name)
        return self._distributions[name]


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


def ros2_name(kind: str) -> str:
    """A type's name in the ROS 2 manner.

    >>> ros2_name("nav_msgs/Odometry"), ros2_name("nav_msgs/msg/Odometry")
    ('nav_msgs/msg/Odometry', 'nav_msgs/msg/Odometry')
    """
    parts = kind.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else kind
