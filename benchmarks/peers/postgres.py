"""A PostgreSQL server of our own for one benchmark: in a temporary folder, on a Unix socket, as an ordinary user."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_PLACES = (*sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True),)
_ACCOUNT = "postgres"


def found() -> Path | None:
    """Where the server's programs are; None where PostgreSQL is not installed, or only root could start it."""
    if os.getuid() == 0 and _ACCOUNT not in {each.pw_name for each in pwd.getpwall()}:
        return None
    own = shutil.which("initdb")
    places = [Path(own).parent] if own else []
    return next((place for place in [*_PLACES, *places] if (place / "initdb").exists() and (place / "postgres").exists()), None)


@contextmanager
def server(folder: Path) -> Iterator[tuple[str, int]]:
    """A running server: its socket's folder, and the process whose CPU time (with its children's) is the server's."""
    programs = found()
    if programs is None:
        raise FileNotFoundError("PostgreSQL is not installed")
    data = folder / "data"
    data.mkdir(parents=True)
    account = _ACCOUNT if os.getuid() == 0 else None
    if account:
        for each in (folder, data):
            shutil.chown(each, account)
    command = [programs / "initdb", "-D", data, "-U", "w", "-A", "trust", "-N"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, user=account, cwd="/")
    settings = {
        "listen_addresses": "",
        "unix_socket_directories": str(folder),
        "shared_buffers": "256MB",
        "max_connections": "100",
    }
    words = [word for name, value in settings.items() for word in ("-c", f"{name}={value}")]
    running = subprocess.Popen(
        [programs / "postgres", "-D", data, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, user=account, cwd="/"
    )
    try:
        while subprocess.run([programs / "pg_isready", "-h", folder], stdout=subprocess.DEVNULL, check=False).returncode:
            if running.poll() is not None:
                raise RuntimeError("the PostgreSQL server did not start")
        yield str(folder), running.pid
    finally:
        running.terminate()
        running.wait()


def database(socket: str, name: str) -> str:
    """A fresh database's address, as SQLAlchemy takes it."""
    programs = found()
    subprocess.run([str(programs / "createdb"), "-h", socket, "-U", "w", name], check=True)  # type: ignore[operator]
    return f"postgresql+psycopg://w@/{name}?host={socket}"


def cpu_s(process: int) -> float:
    """User and system time of a server: of the process, its children, and those that have ended."""
    ticks = sum(_ticks(Path(f"/proc/{process}/stat"))[:4])
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(_fields(stat)[1]) == process:
                ticks += sum(_ticks(stat)[:2])
        except (FileNotFoundError, ProcessLookupError):
            continue
    return ticks / os.sysconf("SC_CLK_TCK")


def _fields(stat: Path) -> list[str]:
    return stat.read_text().rpartition(")")[2].split()


def _ticks(stat: Path) -> list[int]:
    return [int(each) for each in _fields(stat)[11:15]]
