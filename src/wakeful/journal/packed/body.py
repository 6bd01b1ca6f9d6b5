"""The body of a row: the entries of one commit, or a part of them, as msgpack, and back."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any, get_args

import msgspec
from msgspec import inspect

from wakeful.facts.lines import AnyRecord, Compacted, Line
from wakeful.facts.packs import AnyBurst, Entry, Pack, expanded
from wakeful.journal.packed.coders import Coder, Coders, Turn, UnknownField, struct_type
from wakeful.journal.packed.quick_reading import quick_readers
from wakeful.journal.packed.quick_writing import quick_writers
from wakeful.journal.packed.words import UnknownWord, Words

#: How a body is written. ``PLAIN`` is msgpack; ``SQUEEZED`` is that through zlib, for rows that are seldom read.
PLAIN, SQUEEZED = 0, 1

#: What a body may be broken by: whoever reads one says where it stands.
BROKEN = (msgspec.DecodeError, msgspec.ValidationError, UnknownWord, UnknownField, ValueError, TypeError, KeyError, IndexError)

#: So much a squeezed body may hold: a file from somebody else may claim terabytes.
_LARGEST_BYTES = 256_000_000

#: The tag of a line that msgpack cannot say (an integer of more than 64 bits): its record is JSON.
_JSON = "json"

_BURSTS: tuple[type, ...] = get_args(AnyBurst)
_RECORDS: tuple[type, ...] = get_args(AnyRecord)


def _unsqueezed(body: bytes) -> bytes:
    stream = zlib.decompressobj()
    try:
        content = stream.decompress(body, _LARGEST_BYTES)
    except zlib.error as error:
        raise ValueError(str(error)) from error
    if not stream.eof:
        raise ValueError(f"it ends in the middle, or holds more than {_LARGEST_BYTES:,} bytes")
    return content


class BodyWriter:
    """Writes bodies.

    Args:
        words: the journal's words; new ones must be committed with the body.
    """

    def __init__(self, words: Words) -> None:
        self._words = words
        self._schema = _schema()
        self._text = msgspec.json.encode(self._schema).decode()
        coders = Coders(words, self._schema)
        self._writers = {cls: _writer(coders, cls) for cls in (*_BURSTS, *_RECORDS)}
        self._writers.update(quick_writers(words, self._schema, lambda cls: _writer(coders, cls)))
        self._encode = msgspec.msgpack.Encoder().encode
        self._json = msgspec.json.Encoder().encode

    def write(self, entries: Iterable[Entry]) -> bytes:
        """The body of entries that follow one another."""
        words, writers = self._words, self._writers
        tags, at_ns = words.tags, 0
        plain: list[Any] = [words.constant(self._text)]
        for entry in entries:
            said = entry.burst if isinstance(entry, Pack) else entry.record
            cls = said.__class__
            plain.append((tags.get(cls) or words.tag(cls), entry.at_ns - at_ns, writers[cls](said)))
            at_ns = entry.at_ns
        try:
            return self._encode(plain)
        except OverflowError:
            return self._encode([plain[0], *self._in_json(entries)])

    def _in_json(self, entries: Iterable[Entry]) -> Iterator[tuple[bytes, int, bytes]]:
        at_ns = 0
        for line in expanded(entries):
            yield self._words.constant(_JSON), line.at_ns - at_ns, self._json(line.record)
            at_ns = line.at_ns


class BodyReader:
    """Reads bodies, also those of an earlier wakeful: what they lack has its default.

    Args:
        words: the journal's words.
    """

    def __init__(self, words: Words) -> None:
        self._words = words
        self._coders: dict[bytes, _ByTag] = {}
        self._decode = msgspec.msgpack.Decoder().decode
        self._record = msgspec.json.Decoder(AnyRecord).decode

    def read(self, position: int, body: bytes, form: int = PLAIN) -> Iterator[Entry]:
        """The entries of a body whose first line has that position.

        Raises:
            BROKEN: it is no body, or names what is not there.
        """
        schema, *plain = self._decode(_unsqueezed(body) if form == SQUEEZED else body)
        coders = self._coders.get(schema) or self._learn(schema)
        at_ns = 0
        for tag, since_ns, said in plain:
            at_ns += since_ns
            packed, coder = coders[tag] if tag in coders else self._tagged(coders, tag)
            value = self._record(said) if coder.read is None else coder.read(said)
            if packed:
                yield Pack(position, at_ns, value)
                position += value.count
            else:
                if isinstance(value, Compacted):
                    position += value.lines - 1
                yield Line(position, at_ns, value)
                position += 1

    def _learn(self, schema: bytes) -> _ByTag:
        names = msgspec.json.decode(self._words.text(schema), type=dict[str, tuple[str, ...]])
        fields = {**_schema(), **names}
        coders = Coders(self._words, fields)
        by_name = {cls.__name__: (cls in _BURSTS, coders.of(struct_type(cls))) for cls in (*_BURSTS, *_RECORDS)}
        for cls, read in quick_readers(self._words, fields, lambda cls: _reader(coders, cls)).items():
            by_name[cls.__name__] = (cls in _BURSTS, Coder(None, read))
        by_name[_JSON] = (False, Coder())
        self._coders[schema] = known = _ByTag(by_name)
        return known

    def _tagged(self, coders: _ByTag, tag: bytes) -> tuple[bool, Coder]:
        name = self._words.text(tag)
        found = coders.by_name.get(name)
        if found is None:
            raise UnknownField(f"there is no record {name!r}")
        coders[tag] = found
        return found


class _ByTag(dict[bytes, tuple[bool, Coder]]):
    """The coders of one schema by the tags under which they have been met."""

    def __init__(self, by_name: Mapping[str, tuple[bool, Coder]]) -> None:
        super().__init__()
        self.by_name = by_name


def _writer(coders: Coders, cls: type) -> Turn:
    write = coders.of(struct_type(cls)).write
    if write is None:
        raise TypeError(f"{cls.__name__} has no fields to write")
    return write


def _reader(coders: Coders, cls: type) -> Turn:
    read = coders.of(struct_type(cls)).read
    if read is None:
        raise TypeError(f"{cls.__name__} has no fields to read")
    return read


@cache
def _schema() -> dict[str, tuple[str, ...]]:
    """The fields of every struct that an entry may hold, in the order in which they are written."""
    found: dict[str, tuple[str, ...]] = {}
    waiting: list[inspect.Type] = [struct_type(cls) for cls in (*_BURSTS, *_RECORDS)]
    while waiting:
        kind = waiting.pop()
        match kind:
            case inspect.StructType(cls=cls, fields=fields):
                if cls.__name__ not in found:
                    found[cls.__name__] = tuple(field.name for field in fields)
                    waiting.extend(field.type for field in fields)
            case inspect.UnionType(types=types):
                waiting.extend(types)
            case inspect.VarTupleType(item_type=item):
                waiting.append(item)
            case inspect.DictType(value_type=value):
                waiting.append(value)
            case _:
                pass
    return dict(sorted(found.items()))
