"""Learning: model versions have a lineage, and their weights are there."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import blake2b

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Compacted, Decided, Gained, Imported, Line, Published, TrainingAsked
from wakeful.journal.checks.check import Check


class Weights(Check):
    """The weights of every accepted version are there, and are what their digest says: decisions can be made again.

    Args:
        blob: the journal's blobs by name; raises JournalError where there is none.
    """

    name = "weights"
    says = "the weights of every accepted version are there, and are those that its card names"

    def __init__(self, blob: Callable[[str], bytes]) -> None:
        super().__init__()
        self._blob = blob

    def see(self, line: Line) -> None:
        """Look up what a card names."""
        record = line.record
        if not isinstance(record, Published) or not record.card.accepted:
            return
        self.checked += 1
        card = record.card
        try:
            weights = self._blob(card.blob)
        except JournalError as error:
            self.offend(line, f"version {card.version} cannot be loaded: {error}")
            return
        if blake2b(weights, digest_size=len(card.blob) // 2 or 1).hexdigest() != card.blob:
            self.offend(line, f"the weights of version {card.version} are not those that its card names")


class Lineage(Check):
    """Every model version was asked for, comes from a version that stood before it, and learned from what there was."""

    name = "lineage"
    says = "every model version has a lineage, and every decision names a version that was accepted before it"

    def __init__(self) -> None:
        super().__init__()
        self._asked: dict[int, TrainingAsked] = {}
        self._accepted = {0}
        self._versions = {0}
        self._experiences = 0

    def see(self, line: Line) -> None:
        """Follow a model from its training to the decisions it makes."""
        record = line.record
        match record:
            case Gained() | Imported():
                self._experiences += 1
            case Compacted():
                self._experiences += record.gained
            case TrainingAsked():
                self.checked += 1
                if record.base not in self._accepted:
                    self.offend(line, f"training {record.training} starts from version {record.base}, which was never accepted")
                elif record.watermark > self._experiences:
                    self.offend(
                        line, f"training {record.training} wants {record.watermark} experiences, there are {self._experiences}"
                    )
                self._asked[record.training] = record
            case Published():
                self.checked += 1
                self._publish(line, record)
            case Decided():
                self.checked += 1
                if record.decision.model not in self._accepted:
                    self.offend(line, f"process {record.process} was decided by version {record.decision.model}, never accepted")
            case _:
                pass

    def _publish(self, line: Line, record: Published) -> None:
        card = record.card
        asked = self._asked.pop(record.training, None)
        if asked is None:
            self.offend(line, f"version {card.version} answers training {record.training}, which is not under way")
        elif (asked.base, asked.watermark, asked.seed) != (card.base, card.watermark, card.seed):
            self.offend(line, f"version {card.version} is not what training {record.training} asked for")
        elif card.version in self._versions:
            self.offend(line, f"version {card.version} was published before")
        elif card.accepted and not card.blob:
            self.offend(line, f"version {card.version} was accepted without weights")
        self._versions.add(card.version)
        if card.accepted:
            self._accepted.add(card.version)
