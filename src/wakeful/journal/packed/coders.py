"""Coders: how a value of one type becomes plain data of few bytes, and back. Made from the types of the facts themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from operator import attrgetter
from typing import Any, TypeAlias

import msgspec
from msgspec import inspect

from wakeful.facts.choices import Basis
from wakeful.facts.values import NOTHING, Field, Raw
from wakeful.journal.packed.words import BETWEEN, Words

#: Plain data: what msgpack can say.
Plain: TypeAlias = "None | bool | int | float | str | bytes | list[Plain] | tuple[Plain, ...]"

#: From a value to plain data, or back: of which type is known only to who made it from that type.
Turn: TypeAlias = Callable[[Any], Any]

#: Fields that say something new each time: no use to look for words in them.
_FREE = frozenset(
    {"says", "why", "because", "reason", "excerpt", "detail", "entity", "key", "by", "args", "error", "who", "digest"}
)

#: Fields that hold an identity, mostly of 20 hex digits.
_IDENTITIES = frozenset({"id", "event", "outcome"})


class Coder(msgspec.Struct, frozen=True):
    """How values of one type are written and read; None: as they are."""

    write: Turn | None = None
    read: Turn | None = None


class UnknownField(Exception):
    """A row was written with a field that this wakeful does not know."""


class Coders:
    """Makes the coders of types, each once.

    Args:
        words: the strings that are written as numbers.
        schema: the fields of each struct, by its name, in the order in which they are written.
    """

    def __init__(self, words: Words, schema: Mapping[str, tuple[str, ...]]) -> None:
        self._words = words
        self._schema = schema
        self._made: dict[type, Coder] = {}
        self._text = Coder(words.__getitem__, words.text)
        self._free = Coder(None, words.text)
        self._identity = Coder(words.identity, words.text)

    def of(self, kind: inspect.Type) -> Coder:
        """The coder of a type as msgspec sees it."""
        match kind:
            case inspect.StructType(cls=cls):
                return self._struct(cls)
            case inspect.StrType() | inspect.LiteralType():
                strings = not isinstance(kind, inspect.LiteralType) or all(isinstance(each, str) for each in kind.values)
                return self._text if strings else Coder()
            case inspect.EnumType(cls=cls):
                members = {str(each): each for each in cls}
                return Coder(None, members.__getitem__)
            case inspect.FloatType():
                return Coder(None, float)
            case inspect.RawType():
                return Coder(_raw, lambda value: NOTHING if value is None else Raw(value))
            case inspect.VarTupleType(item_type=item):
                return _many(self.of(item))
            case inspect.DictType(value_type=value):
                return _Mapping(self._words, self.of(value)).coder()
            case inspect.UnionType(types=types):
                return self._union(types)
            case _:
                return Coder()

    def field(self, name: str, kind: inspect.Type) -> Coder:
        """The coder of a field: what its name says it holds may be written in fewer bytes, or with less ado."""
        if isinstance(kind, inspect.StrType):
            return self._free if name in _FREE else self._identity if name in _IDENTITIES else self._text
        return self.of(kind)

    def _union(self, types: tuple[inspect.Type, ...]) -> Coder:
        """None or one other type; or a field's value, which tells by itself what it is."""
        others = [each for each in types if not isinstance(each, inspect.NoneType)]
        if len(others) > 1:
            return Coder(self._write_field, self._read_field)
        one = self.of(others[0])
        write, read = one.write, one.read
        return Coder(
            None if write is None else lambda value: None if value is None else write(value),
            None if read is None else lambda value: None if value is None else read(value),
        )

    def _write_field(self, value: Field) -> Plain:
        return self._words[value] if isinstance(value, str) else value

    def _read_field(self, value: Any) -> Field:
        if isinstance(value, bytes | str):
            return self._words.text(value)
        return tuple(float(each) for each in value) if isinstance(value, list) else value

    def _struct(self, cls: type) -> Coder:
        if cls not in self._made:
            self._made[cls] = self._basis() if cls is Basis else _Fields(self, cls, self._schema[cls.__name__]).coder()
        return self._made[cls]

    def _basis(self) -> Coder:
        """A basis is the same for thousands of events: it is one word."""
        encode, decode = msgspec.json.Encoder().encode, msgspec.json.Decoder(Basis).decode
        read: dict[bytes, Basis] = {}
        constants = self._words.constants  # by identity: hashing ten fields for each event would cost more

        def write(basis: Basis) -> bytes:
            found = constants.get(id(basis))
            if found is None:
                if len(constants) > _BASES:
                    constants.clear()
                found = constants[id(basis)] = (basis, self._words.constant(encode(basis).decode()))
            return found[1]

        def back(number: bytes) -> Basis:
            if number not in read:
                read[number] = decode(self._words.text(number))
            return read[number]

        return Coder(write, back)


_BASES = 256


class _Fields:
    """A struct's fields by their places."""

    def __init__(self, coders: Coders, cls: type, names: tuple[str, ...]) -> None:
        self._cls = cls
        self._names = names
        known = {field.name: field.type for field in struct_type(cls).fields}
        unknown = [name for name in names if name not in known]
        if unknown:
            raise UnknownField(f"{cls.__name__} has no field {unknown[0]}")
        turns = [coders.field(name, known[name]) for name in names]
        self._writes = [(place, each.write) for place, each in enumerate(turns) if each.write is not None]
        self._reads = [(place, each.read) for place, each in enumerate(turns) if each.read is not None]
        self._single = len(names) == 1
        self._get = attrgetter(*names)

    def coder(self) -> Coder:
        """Its two directions."""
        return Coder(self._write, self._read)

    def _write(self, value: object) -> list[Any]:
        plain: list[Any] = [self._get(value)] if self._single else list(self._get(value))
        for place, write in self._writes:
            plain[place] = write(plain[place])
        return plain

    def _read(self, plain: list[Any]) -> object:
        for place, read in self._reads:
            plain[place] = read(plain[place])
        return self._cls(**dict(zip(self._names, plain, strict=True)))


class _Mapping:
    """A mapping by strings: its names, which are mostly the same ones, as one word; then its values."""

    def __init__(self, words: Words, value: Coder) -> None:
        self._words = words
        self._value = value
        self._names: dict[bytes | str, list[str]] = {}

    def coder(self) -> Coder:
        """Its two directions."""
        return Coder(self._write, self._read)

    def _write(self, mapping: dict[str, object]) -> Plain:
        if not mapping:
            return None
        names = BETWEEN.join(mapping)
        # A name may hold what stands between names: then they are written one by one.
        head: Any = self._words[names] if names.count(BETWEEN) == len(mapping) - 1 else list(mapping)
        write = self._value.write
        values: Iterable[Any] = mapping.values() if write is None else map(write, mapping.values())
        return [head, *values]

    def _read(self, plain: list[Any] | None) -> dict[str, object]:
        if plain is None:
            return {}
        head, *values = plain
        names = head if isinstance(head, list) else self._split(head)
        read = self._value.read
        return dict(zip(names, values if read is None else map(read, values), strict=True))

    def _split(self, head: bytes | str) -> list[str]:
        found = self._names.get(head) if isinstance(head, bytes) else None
        if found is None:
            found = self._words.text(head).split(BETWEEN)
            if isinstance(head, bytes):
                self._names[head] = found
        return found


def _many(item: Coder) -> Coder:
    write, read = item.write, item.read
    return Coder(
        None if write is None else lambda values: [write(each) for each in values],
        tuple if read is None else lambda values: tuple(map(read, values)),
    )


def _raw(value: Raw) -> bytes | None:
    content = bytes(value)
    return None if content == b"null" else content


@cache
def struct_type(cls: type) -> inspect.StructType:
    """A struct's fields and their types, as msgspec sees them.

    Raises:
        TypeError: it is no struct.
    """
    found = inspect.type_info(cls)
    if not isinstance(found, inspect.StructType):
        raise TypeError(f"{cls.__name__} is no struct")
    return found
