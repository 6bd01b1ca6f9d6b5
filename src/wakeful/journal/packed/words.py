"""Words: strings that a journal says again and again, written as their numbers. The table stands in the journal itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable

#: A word's number has at most three bytes: what has ten is an identity in hex.
MOST_WORDS = 1 << 16
_IDENTITY_BYTES = 10
_IDENTITY_DIGITS = 2 * _IDENTITY_BYTES

#: Longer strings are never words, and a string becomes one when it is written for the so-manieth time within a while.
_LONGEST = 200
_OFTEN = 6
_WATCHED = 8192

#: What stands between the names of a mapping's fields, where they are written as one word.
BETWEEN = "\x1f"


Reload = Callable[[], Iterable[tuple[int, str]]]


class UnknownWord(Exception):
    """A row names a word that the journal's table does not have."""


class Words(dict[str, "bytes | str"]):
    """From strings to how they are written: ``words[text]`` is a number as bytes, or the text itself.

    Looking up a string that is no word counts it; it becomes one, listed in ``new`` until ``settled``, once it was often seen.

    Args:
        known: the table of the journal, by number.
        reload: reads the table again, for a reader beside a writer that adds to it.
    """

    def __init__(
        self, known: Iterable[tuple[int, str]] = (), reload: Callable[[], Iterable[tuple[int, str]]] | None = None
    ) -> None:
        super().__init__()
        self._reload = reload
        self._texts: dict[bytes, str] = {}
        self._seen: dict[str, int] = {}
        self._next = 1
        self.new: list[tuple[int, str]] = []
        self.constants: dict[int, tuple[object, bytes]] = {}
        """Objects that are words as a whole, by their identity; each is kept, so that its identity stays its own."""
        self.tags: dict[type, bytes] = {}
        """The names of classes that are words."""
        self[""] = ""
        for number, text in known:
            self._take(number, text)

    def __missing__(self, text: str) -> bytes | str:
        if len(text) > _LONGEST:
            return text
        count = self._seen.get(text, 0) + 1
        if count < _OFTEN:
            if len(self._seen) >= _WATCHED:
                self._seen.clear()
            self._seen[text] = count
            return text
        self._seen.pop(text, None)
        return self.constant(text) if self._next < MOST_WORDS else text

    def constant(self, text: str) -> bytes:
        """The number of a text that is a word from its first use, however long it is."""
        found = self.get(text)
        if isinstance(found, bytes):
            return found
        number = self._next
        self.new.append((number, text))
        return self._take(number, text)

    def tag(self, cls: type) -> bytes:
        """The number of a class's name."""
        self.tags[cls] = number = self.constant(cls.__name__)
        return number

    def identity(self, text: str) -> bytes | str:
        """How an identity is written: ten bytes where it is 20 hex digits."""
        if len(text) == _IDENTITY_DIGITS:
            try:
                written = bytes.fromhex(text)
            except ValueError:
                return self[text]
            if written.hex() == text:
                return written
        return self[text] if text else text

    def settled(self) -> None:
        """The new words are durable."""
        self.new.clear()

    def withdraw(self) -> None:
        """What new words there still are could not be written: nothing knows them."""
        if not self.new:
            return
        for number, text in self.new:
            del self[text], self._texts[_written(number)]
        self._next -= len(self.new)
        self.new.clear()
        self.constants.clear()
        self.tags.clear()

    def text(self, written: bytes | str) -> str:
        """What was written, as a string.

        Raises:
            UnknownWord: the table has no such number.
        """
        if isinstance(written, str):
            return written
        found = self._texts.get(written)
        if found is not None:
            return found
        if len(written) == _IDENTITY_BYTES:
            return written.hex()
        if self._reload is not None:
            for number, text in self._reload():
                self._take(number, text)
        if written not in self._texts:
            raise UnknownWord(f"there is no word {int.from_bytes(written, 'big')}")
        return self._texts[written]

    def _take(self, number: int, text: str) -> bytes:
        written = _written(number)
        self[text] = written
        self._texts[written] = text
        self._next = max(self._next, number + 1)
        return written


def _written(number: int) -> bytes:
    return number.to_bytes((number.bit_length() + 7) // 8, "big")
