"""A disk below SQLite that fails as it is told: full, read-only, broken, slow, without power, rotten. Repeatable by its seed.

    with FaultyDisk(seed=7) as disk:
        journal = open_journal(path, vfs=disk.name)
        disk.fail("full")             # and later disk.mend()
        disk.cut_power()              # from here on every access fails
        journal.close()
        disk.restore_power("some")    # the files hold what survived

Shared memory (``-shm``) and locks are the real ones: it is the journal and its write-ahead file that fail.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from random import Random
from types import TracebackType
from typing import Literal

import apsw

#: ``full``: a write that makes a file longer is refused. ``read-only``: every write is. ``broken``: every write and sync fails.
Fault = Literal["full", "read-only", "broken"]

#: What of the writes since the last sync survives a loss of power: all, none, or any of their sectors, by the seed.
Survival = Literal["all", "none", "some"]

SECTOR_BYTES = 512

_ERRORS: dict[str, Callable[[str], apsw.Error]] = {
    "full": apsw.FullError,
    "read-only": apsw.ReadOnlyError,
    "broken": apsw.IOError,
}

_NAMES = iter(range(1 << 62))


class _Kept:
    """What of one file is sure to survive, and what has been written to it since."""

    def __init__(self, content: bytes | None) -> None:
        self.durable = None if content is None else bytearray(content)
        self.since: list[tuple[int, bytes | None]] = []

    def write(self, offset: int, data: bytes | None) -> None:
        """Data at an offset; None: the file was cut there."""
        self.since.append((offset, data))

    def sync(self) -> None:
        """All of it is durable."""
        self.durable = self.after(lambda: True)
        self.since.clear()

    def after(self, survives: Callable[[], bool]) -> bytearray:
        """The content if each sector written since the last sync survives or not."""
        content = bytearray(self.durable or b"")
        for offset, data in self.since:
            if data is None:
                if survives():
                    del content[offset:]
                continue
            for start in range(0, len(data), SECTOR_BYTES):
                if survives():
                    _put(content, offset + start, data[start : start + SECTOR_BYTES])
        return content


class FaultyDisk(apsw.VFS):
    """A VFS of SQLite over the real one. Register it for a while with ``with``, and open files with ``vfs=disk.name``.

    Args:
        seed: of what survives a loss of power, and of which bits rot.
        sleep: how a slow disk waits; a test gives its own, which does not.
    """

    def __init__(self, seed: int = 0, sleep: Callable[[float], None] = time.sleep) -> None:
        self.name = f"wakeful-faulty-{next(_NAMES)}"
        self.writes = 0
        self.syncs = 0
        self._random = Random(seed)
        self._sleep = sleep
        self._sync_s = 0.0
        self._fault: Fault | None = None
        self._healthy_writes = 0
        self._dead = False
        self._kept: dict[str, _Kept] = {}
        super().__init__(self.name, "")

    def __enter__(self) -> FaultyDisk:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.unregister()

    # --- what a test tells it ---

    def fail(self, fault: Fault, after_writes: int = 0) -> None:
        """From now on, or after so many more writes, fail in that way until ``mend``."""
        self._fault, self._healthy_writes = fault, after_writes

    def mend(self) -> None:
        """Space again, writable again, whole again."""
        self._fault = None

    def slow(self, sync_s: float) -> None:
        """Each sync takes so long; 0 is fast again."""
        self._sync_s = sync_s

    def cut_power(self) -> None:
        """From now on every access fails, until ``restore_power``. Close what is open in between: its errors are the disk's."""
        self._dead = True

    def restore_power(self, survival: Survival = "none") -> None:
        """Give each file what was synced, and what else survived: writes may be lost, torn in sectors and out of order."""
        chance = {"all": 1.0, "none": 0.0, "some": 0.5}[survival]
        for name, kept in self._kept.items():
            if kept.durable is None and (survival == "none" or not kept.since):
                Path(name).unlink(missing_ok=True)
            else:
                Path(name).write_bytes(kept.after(lambda: self._random.random() < chance))
            Path(name + "-shm").unlink(missing_ok=True)
        self._kept.clear()
        self._dead = False

    def rot(self, path: Path, bits: int = 1, after_byte: int = 0) -> list[int]:
        """Flip bits of a file that nobody has open; returns at which bytes."""
        content = bytearray(path.read_bytes())
        places = [self._random.randrange(after_byte, len(content)) for _ in range(bits)]
        for place in places:
            content[place] ^= 1 << self._random.randrange(8)
        path.write_bytes(content)
        return places

    def tear(self, path: Path, lost_bytes: int = SECTOR_BYTES) -> None:
        """The end of a file that nobody has open was never written."""
        content = path.read_bytes()
        path.write_bytes(content[: max(0, len(content) - lost_bytes)])

    def excepthook(self, etype: object, evalue: object, etraceback: object) -> bool:  # noqa: ARG002  # apsw's own signature
        """A fault where SQLite takes no error is not printed: it was asked for."""
        return True

    # --- what SQLite asks of it ---

    def xOpen(self, name: str | apsw.URIFilename | None, flags: list[int]) -> apsw.VFSFile:
        self.check_power()
        return _File(self, name, flags)

    def xDelete(self, filename: str, syncdir: bool) -> None:
        self.check_power()
        self._kept.pop(filename, None)
        super().xDelete(filename, syncdir)

    def check_power(self) -> None:
        """Raises apsw.IOError while there is none."""
        if self._dead:
            raise apsw.IOError("the disk has no power")

    def written(self, name: str, offset: int, data: bytes | None, longer: bool) -> None:
        """A write, or a cut, is about to be done; raises what it fails with."""
        self.check_power()
        self.writes += 1
        if self._fault is not None:
            if self._healthy_writes > 0:
                self._healthy_writes -= 1
            elif self._fault != "full" or longer:
                raise _ERRORS[self._fault](f"the disk is {self._fault}")
        if name in self._kept:
            self._kept[name].write(offset, data)

    def synced(self, name: str) -> None:
        """A sync is about to be done."""
        self.check_power()
        self.syncs += 1
        if self._sync_s:
            self._sleep(self._sync_s)
        if self._fault == "broken" and self._healthy_writes <= 0:
            raise apsw.IOError("the disk is broken")
        if name in self._kept:
            self._kept[name].sync()

    def keep(self, name: str) -> None:
        """Remember what of a file is durable: what it held when it was first opened."""
        if name not in self._kept:
            path = Path(name)
            self._kept[name] = _Kept(path.read_bytes() if path.exists() else None)


class _File(apsw.VFSFile):
    """One open file of the disk; temporary ones, which have no name, survive nothing and are not kept."""

    def __init__(self, disk: FaultyDisk, name: str | apsw.URIFilename | None, flags: list[int]) -> None:
        self._disk = disk
        self._name = name.filename() if isinstance(name, apsw.URIFilename) else name or ""
        if self._name:
            disk.keep(self._name)
        super().__init__("", name, flags)

    def excepthook(self, etype: object, evalue: object, etraceback: object) -> bool:  # noqa: ARG002  # apsw's own signature
        """As the disk's own."""
        return True

    def xRead(self, amount: int, offset: int) -> bytes:
        self._disk.check_power()
        return super().xRead(amount, offset)

    def xWrite(self, data: bytes, offset: int) -> None:
        self._disk.written(self._name, offset, bytes(data), offset + len(data) > super().xFileSize())
        super().xWrite(data, offset)

    def xTruncate(self, newsize: int) -> None:
        self._disk.written(self._name, newsize, None, longer=False)
        super().xTruncate(newsize)

    def xSync(self, flags: int) -> None:
        self._disk.synced(self._name)
        super().xSync(flags)

    def xFileSize(self) -> int:
        self._disk.check_power()
        return super().xFileSize()


def _put(content: bytearray, offset: int, data: bytes) -> None:
    if len(content) < offset:
        content.extend(bytes(offset - len(content)))
    content[offset : offset + len(data)] = data
