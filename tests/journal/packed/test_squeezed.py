"""A squeezed body is unpacked within a limit, and one that is none is broken, never a crash."""

from __future__ import annotations

import zlib

import pytest

from wakeful.journal.packed import body
from wakeful.journal.packed.body import BROKEN, SQUEEZED, BodyReader
from wakeful.journal.packed.words import Words


@pytest.mark.parametrize("squeezed", [b"", b"no zlib", zlib.compress(b"x" * 100)[:-6], zlib.compress(bytes(10_000))])
def test_what_is_no_squeezed_body_or_too_large_a_one_is_broken(squeezed: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(body, "_LARGEST_BYTES", 1_000)
    with pytest.raises(BROKEN):
        list(BodyReader(Words()).read(1, squeezed, SQUEEZED))
