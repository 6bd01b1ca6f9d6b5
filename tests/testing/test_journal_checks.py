from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

from wakeful.contracts.journal import Journal, JournalError
from wakeful.facts.packs import Entry, expanded, last_position
from wakeful.journal import MemoryJournal, open_journal
from wakeful.testing import ContractBroken, check_journal


class Careful(MemoryJournal):
    """Looks at every position, not only at the first."""

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        unpacked = [line.position for line in expanded(lines)]
        if unpacked != list(range(self.last + 1, self.last + 1 + len(unpacked))):
            raise JournalError("positions")
        super().commit(lines, state, blobs)


class Careless(MemoryJournal):
    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        self._entries.extend(lines)
        self._ends.extend(last_position(each) for each in lines)
        super().commit((), state, blobs)


class Hasty(Careful):
    """Keeps the blobs of a commit that it refuses."""

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        super().commit((), {}, blobs)
        super().commit(lines, state, {})


class Clinging(Careful):
    """Never deletes state."""

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        super().commit(lines, {key: value for key, value in state.items() if value is not None}, blobs)


def test_the_journals_of_the_project_keep_their_contract(tmp_path: Path) -> None:
    check_journal(MemoryJournal, durable=False)
    check_journal(lambda: open_journal(tmp_path / "mind.db"), durable=True)


@pytest.mark.parametrize(
    ("make", "durable", "why"),
    [
        (Careless, False, "do not follow"),
        (Hasty, False, "no blob 'lost'"),
        (Clinging, False, "the state is"),
        (Careful, True, "come back as they were committed"),
    ],
)
def test_a_journal_that_breaks_its_contract_is_caught(make: Callable[[], Journal], durable: bool, why: str) -> None:
    with pytest.raises(ContractBroken, match=why):
        check_journal(make, durable)
