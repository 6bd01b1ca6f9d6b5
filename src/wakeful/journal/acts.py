"""Acts handed to whoever writes a journal: a folder beside it, one file an act, for operators at another terminal."""

from __future__ import annotations

import os
import stat
import time
from pathlib import Path
from uuid import uuid4

import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.facts.inputs import Act

_SUFFIX = ".act"
_SET_ASIDE = ".refused"
_MODE_FOLDER, _MODE_FILE = 0o700, 0o600


class Handed(msgspec.Struct, frozen=True):
    """One act as it was found in the folder."""

    act: Act
    file: Path


class ActSpool:
    """The folder ``<journal>.acts``. An act is renamed into it whole, read in the order of being handed in, and taken out once
    its record is durable; what is read twice because of a crash acts once, by its id.

    Only files of the user who runs the mind (or of root) are taken, from a folder that nobody else may write.

    Args:
        journal: the journal's file.
    """

    def __init__(self, journal: Path) -> None:
        self.folder = journal.with_name(journal.name + ".acts")

    def put(self, act: Act) -> Act:
        """Hand in an act; returns it with the id under which its record will be found.

        Raises:
            JournalError: the folder cannot be written, or is open to others.
        """
        act = msgspec.structs.replace(act, id=act.id or uuid4().hex)
        name = f"{time.time_ns():020d}-{act.id}"
        try:
            self.folder.mkdir(mode=_MODE_FOLDER, exist_ok=True)
            if not self._ours():
                raise JournalError(f"{self.folder} belongs to somebody else, or others may write it; remove it and try again")
            new = self.folder / f"{name}.new"
            with os.fdopen(os.open(new, os.O_CREAT | os.O_EXCL | os.O_WRONLY, _MODE_FILE), "wb") as file:
                file.write(msgspec.json.encode(act))
                file.flush()
                os.fsync(file.fileno())
            new.rename(self.folder / f"{name}{_SUFFIX}")
        except OSError as error:
            raise JournalError(f"{self.folder} cannot be written: {error.strerror}; the act was not handed over") from error
        return act

    def waiting(self) -> list[Handed]:
        """The acts that were handed in, oldest first. One that cannot be read is set aside under ``.refused``."""
        try:
            names = sorted(name for name in os.listdir(self.folder) if name.endswith(_SUFFIX))
        except OSError:
            return []  # nobody has handed in anything
        if not names or not self._ours():
            return []
        found = (self._read(self.folder / name) for name in names)
        return [handed for handed in found if handed is not None]

    def done(self, handed: list[Handed]) -> None:
        """Their records are durable."""
        for each in handed:
            each.file.unlink(missing_ok=True)

    def _read(self, file: Path) -> Handed | None:
        try:
            opened = os.open(file, os.O_RDONLY | os.O_NOFOLLOW)
            with os.fdopen(opened, "rb") as content:
                owner = os.fstat(opened).st_uid
                act = msgspec.json.decode(content.read(), type=Act)
        except FileNotFoundError:
            return None  # another writer of the same journal was faster
        except (OSError, msgspec.DecodeError):
            act, owner = None, -1
        if act is None or not act.id or owner not in (os.geteuid(), 0):
            file.rename(file.with_suffix(_SET_ASIDE))
            return None
        return Handed(act, file)

    def _ours(self) -> bool:
        found = self.folder.stat()
        return found.st_uid in (os.geteuid(), 0) and not stat.S_IMODE(found.st_mode) & 0o022
