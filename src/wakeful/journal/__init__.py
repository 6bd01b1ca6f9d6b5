"""The append-only record: SQLite by default, memory for what need not survive."""

from wakeful.journal.memory import MemoryJournal
from wakeful.journal.sqlite import SqliteJournal, open_journal

__all__ = ["MemoryJournal", "SqliteJournal", "open_journal"]
