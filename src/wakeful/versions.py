"""Model versions: which one selects, and which are at hand for a rollback."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from wakeful.facts.experience import ModelCard
from wakeful.learning.cells import Cells
from wakeful.selection.selector import Selector

#: Accepted model versions whose weights stay at hand for a rollback; older ones are in the journal, for a rollback at rest.
KEPT_VERSIONS = 8


class Versions:
    """The newest accepted versions by number, each with its weights, and the one in use.

    Args:
        selector: decides with the version in use.
        cells: divide experience as that version does.
    """

    def __init__(self, selector: Selector, cells: Cells) -> None:
        self._selector = selector
        self._cells = cells
        self._weights = b""
        self._kept: dict[int, tuple[ModelCard, bytes]] = {}

    def accept(self, card: ModelCard, weights: bytes) -> None:
        """A version was accepted: it stays at hand, and perhaps the oldest does not."""
        self._kept[card.version] = (card, weights)
        while len(self._kept) > KEPT_VERSIONS:
            del self._kept[next(iter(self._kept))]

    def restore(self, accepted: Iterable[ModelCard], blobs: Mapping[str, bytes]) -> None:
        """Take up the newest versions of a journal, whose weights it has."""
        for card in list(accepted)[-KEPT_VERSIONS:]:
            if card.blob in blobs:
                self.accept(card, blobs[card.blob])

    def use(self, card: ModelCard, weights: bytes) -> None:
        """Select with that version.

        Raises:
            ValueError: it was fitted to other fields than the domain has now; the version in use stays.
        """
        self._selector.use(card, weights)
        self._weights = weights
        self._cells.use()

    def find(self, version: int) -> tuple[ModelCard, bytes] | None:
        """A version with its weights; None where it is not at hand."""
        return self._kept.get(version)

    def listed(self) -> str:
        """The versions at hand, for a message."""
        return ", ".join(map(str, self._kept)) or "none"

    def base(self, version: int) -> bytes:
        """The weights that a training goes on from: that version's, where another is in use by a rollback; else those in use."""
        card = self._selector.card
        found = self._kept.get(version)
        return found[1] if card is not None and card.version != version and found is not None else self._weights
