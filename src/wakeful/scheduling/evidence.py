"""Evidence that came before it was asked for: kept for a declared time, bounded, and delivered."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from wakeful.facts.evidence import Evidence

_KEPT = msgspec.json.Decoder(tuple[Evidence, ...])
#: Under this and its topic and key a piece of evidence stands in the keyed state.
KEPT = "evidence/"

#: At most so many pieces are kept of one (topic, key), and so many keys in all; the oldest go first.
MAX_PER_KEY = 64
MAX_KEYS = 4096


class EvidenceShelf:
    """Kept evidence by (topic, key), newest last. Its state is committed key by key.

    Args:
        keep_ns: for how long a topic's evidence is kept, by topic; other topics ``default_keep_ns``.
    """

    def __init__(self, keep_ns: Mapping[str, int], default_keep_ns: int) -> None:
        self._keep_ns = dict(keep_ns)
        self._default_keep_ns = default_keep_ns
        self._shelf: dict[str, tuple[Evidence, ...]] = {}
        self._dirty: dict[str, None] = {}

    def put(self, evidence: Evidence) -> bool:
        """Keep it; False when the same id is there already."""
        name = f"{evidence.topic}\x1f{evidence.key}"
        kept = self._shelf.pop(name, ())
        if any(each.id == evidence.id for each in kept):
            self._shelf[name] = kept
            return False
        oldest_ns = _came_ns(evidence) - self._keep_ns.get(evidence.topic, self._default_keep_ns)
        fresh = tuple(each for each in kept if _came_ns(each) >= oldest_ns)
        self._shelf[name] = (*fresh, evidence)[-MAX_PER_KEY:]
        self._dirty[name] = None
        while len(self._shelf) > MAX_KEYS:
            gone = next(iter(self._shelf))
            del self._shelf[gone]
            self._dirty[gone] = None
        return True

    def holds(self, topic_key: str) -> bool:
        """Whether anything at all is kept under ``topic_key``."""
        return topic_key in self._shelf

    def of(self, topic_key: str, since_ns: int) -> tuple[Evidence, ...]:
        """What is kept under ``topic_key`` and came no longer than its retention before ``since_ns``."""
        topic = topic_key.partition("\x1f")[0]
        oldest_ns = since_ns - self._keep_ns.get(topic, self._default_keep_ns)
        return tuple(each for each in self._shelf.get(topic_key, ()) if _came_ns(each) >= oldest_ns)

    def changed(self) -> dict[str, bytes | None]:
        """The state to commit since the last call."""
        parts: dict[str, bytes | None] = {}
        for name in self._dirty:
            kept = self._shelf.get(name)
            parts[KEPT + name] = msgspec.json.encode(kept) if kept else None
        self._dirty.clear()
        return parts

    def restore(self, state: Mapping[str, bytes]) -> None:
        """Take up what was committed. The order of keys by age is that of their newest piece."""
        found = {key[len(KEPT) :]: _KEPT.decode(value) for key, value in state.items() if key.startswith(KEPT)}
        self._shelf = dict(sorted(found.items(), key=lambda item: (_came_ns(item[1][-1]), item[0])))


def _came_ns(evidence: Evidence) -> int:
    """When it came; before that was recorded, journals told only when it had been observed."""
    return evidence.received_ns or evidence.at_ns
