"""Bodies: whatever a mind may write is read again as it was, in few bytes."""

from __future__ import annotations

import zlib
from typing import Any, get_args

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import inspect

from tests.journal.packed.facts import any_of
from wakeful.facts.lines import AnyRecord, Compacted, Concluded, Created, Duplicate, Line, Noted
from wakeful.facts.packs import AnyBurst, Covered, Entry, Pack, Ran, Validated, last_position
from wakeful.facts.values import Raw
from wakeful.journal.packed import body as bodies
from wakeful.journal.packed.body import BROKEN, SQUEEZED, BodyReader, BodyWriter
from wakeful.journal.packed.coders import Coders, UnknownField
from wakeful.journal.packed.quick_reading import quick_readers
from wakeful.journal.packed.quick_writing import quick_writers
from wakeful.journal.packed.words import UnknownWord, Words

_BURSTS, _RECORDS = get_args(AnyBurst), get_args(AnyRecord)

sayings = st.sampled_from((*_BURSTS, *_RECORDS)).flatmap(any_of)


def placed(sayings: list[Any], at_ns: int = 10**18) -> list[Entry]:
    entries: list[Entry] = []
    for count, said in enumerate(sayings):
        position = last_position(entries[-1]) + 1 if entries else 1
        if isinstance(said, Compacted):
            said = msgspec.structs.replace(said, first=position, lines=count % 3 + 1)  # noqa: PLW2901
            position += count % 3
        entries.append((Pack if isinstance(said, _BURSTS) else Line)(position, at_ns + count, said))
    return entries


@settings(max_examples=60, deadline=None)
@given(st.lists(sayings, max_size=6), st.booleans())
def test_any_entries_are_read_as_they_were_written(said: list[Any], reopened: bool) -> None:
    words = Words()
    entries = placed(said)
    writer = BodyWriter(words)
    for _ in range(8):  # by the last time what is said often is a word
        body = writer.write(entries)
    reader = BodyReader(Words(words.new) if reopened else words)
    assert list(reader.read(1, body)) == entries
    assert list(reader.read(1, zlib.compress(body), SQUEEZED)) == entries


@settings(max_examples=40, deadline=None)
@given(st.sampled_from((Covered, Ran, Validated)).flatmap(any_of))
def test_the_writers_by_hand_write_what_the_general_ones_do(burst: Any) -> None:
    by_hand, by_type = Words(), Words()
    quick = quick_writers(by_hand, bodies._schema(), lambda cls: general(by_hand, cls))
    encode = msgspec.msgpack.encode
    for _ in range(8):
        assert encode(quick[type(burst)](burst)) == encode(general(by_type, type(burst))(burst))


@settings(max_examples=80, deadline=None)
@given(st.sampled_from((Covered, Ran, Validated)).flatmap(any_of))
def test_the_readers_by_hand_read_what_the_general_ones_do(burst: Any) -> None:
    words = Words()
    write = general(words, type(burst))
    by_hand = quick_readers(words, bodies._schema(), lambda cls: bodies._reader(Coders(words, bodies._schema()), cls))
    by_type = bodies._reader(Coders(words, bodies._schema()), type(burst))
    for _ in range(8):
        plain = msgspec.msgpack.encode(write(burst))
        read = by_hand[type(burst)](msgspec.msgpack.decode(plain))
        assert read == by_type(msgspec.msgpack.decode(plain)) == burst
        assert msgspec.json.encode(read) == msgspec.json.encode(by_type(msgspec.msgpack.decode(plain)))


def general(words: Words, cls: type) -> Any:
    return bodies._writer(Coders(words, bodies._schema()), cls)


def test_the_writers_by_hand_know_the_facts_as_they_are() -> None:
    words = Words()
    assert set(quick_writers(words, bodies._schema(), lambda _: lambda fact: fact)) == {Covered, Ran, Validated}


def test_a_fact_with_other_fields_is_left_to_the_general_writers() -> None:
    schema = {**bodies._schema(), "Stamp": ("source_ns",)}
    assert quick_writers(Words(), schema, lambda _: lambda fact: fact) == {}
    assert quick_readers(Words(), schema, lambda _: lambda fact: fact) == {}


def test_an_integer_that_msgpack_cannot_say_is_kept_all_the_same() -> None:
    entries = placed([Noted(what="test", detail="", process=2**70), Noted(what="other", detail="")])
    words = Words()
    assert list(BodyReader(words).read(1, BodyWriter(words).write(entries))) == entries


def test_what_is_said_again_and_again_takes_three_bytes() -> None:
    words = Words()
    writer = BodyWriter(words)
    entries = placed([Duplicate(event="0123456789abcdef0123", source="a source with a long name", position=7)] * 50)
    sizes = [len(writer.write(entries)) for _ in range(2)]
    assert sizes[1] < 50 * 25


def test_words_that_could_not_be_committed_are_written_anew() -> None:
    words = Words()
    writer = BodyWriter(words)
    entries = placed([Noted(what="something", detail="")] * 20)
    writer.write(entries)
    words.withdraw()
    assert not words.new
    body = writer.write(entries)
    assert list(BodyReader(Words(words.new)).read(1, body)) == entries


def test_a_body_of_an_earlier_wakeful_lacks_what_came_later(monkeypatch: pytest.MonkeyPatch) -> None:
    words = Words()
    entries = placed([Created(process=1, event="e", treatment="memory", criticality=2, deadline_ns=5)])
    now = bodies._schema()
    with monkeypatch.context() as patch:
        patch.setattr(bodies, "_schema", lambda: {**now, "Created": now["Created"][:4]})
        body = BodyWriter(words).write(entries)
    (line,) = BodyReader(words).read(1, body)
    assert line.record == Created(process=1, event="e", treatment="memory", criticality=2)  # type: ignore[union-attr]


def test_a_body_of_a_later_wakeful_is_not_guessed_at(monkeypatch: pytest.MonkeyPatch) -> None:
    words = Words()
    text = msgspec.json.encode({**bodies._schema(), "Noted": ("what", "detail", "colour")}).decode()
    body = msgspec.msgpack.encode([words.constant(text)])
    with pytest.raises(UnknownField, match="Noted has no field colour"):
        list(BodyReader(words).read(1, body))


def test_a_number_that_is_no_word_is_named() -> None:
    words = Words()
    body = BodyWriter(words).write(placed([Noted(what="x", detail="")]))
    with pytest.raises(UnknownWord, match="there is no word 1"):
        list(BodyReader(Words()).read(1, body))


def test_a_reader_hears_of_words_that_came_after_it_had_begun() -> None:
    words = Words()
    reader = BodyReader(Words((), lambda: words.new))
    entries = placed([Noted(what="x", detail="")])
    assert list(reader.read(1, BodyWriter(words).write(entries))) == entries


@settings(max_examples=40, deadline=None)
@given(st.lists(sayings, min_size=1, max_size=3), st.data())
def test_a_flipped_bit_is_an_error_that_is_known_or_other_entries(said: list[Any], data: st.DataObject) -> None:
    words = Words()
    body = bytearray(BodyWriter(words).write(placed(said)))
    body[data.draw(st.integers(0, len(body) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    try:
        read = list(BodyReader(words).read(1, bytes(body)))
    except BROKEN:
        return
    assert all(isinstance(each, Line | Pack) for each in read)


def test_every_kind_of_entry_has_a_writer() -> None:
    writers = BodyWriter(Words())._writers
    assert set(writers) == {*_BURSTS, *_RECORDS}


def test_a_result_is_carried_to_the_byte() -> None:
    text = b'{"type": "memory",  "says":"\xc3\xa9"}'
    words = Words()
    entries = placed([Concluded(process=1, event="e", treatment="memory", mode="auto", result=Raw(text))])
    (line,) = BodyReader(words).read(1, BodyWriter(words).write(entries))
    assert bytes(line.record.result) == text  # type: ignore[union-attr]


def test_type_info_of_every_fact_is_one_that_can_be_written() -> None:
    for cls in (*_BURSTS, *_RECORDS):
        assert isinstance(inspect.type_info(cls), inspect.StructType)
