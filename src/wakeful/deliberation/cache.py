"""Replies kept on disk, so that the same question to the same model is paid for once."""

from __future__ import annotations

import contextlib
import logging
import os
import tempfile
from collections.abc import Mapping
from hashlib import blake2b
from pathlib import Path

import msgspec

from wakeful.facts.asking import Reply

_log = logging.getLogger(__name__)
_LARGEST_BYTES = 1_000_000


def digest(*parts: str) -> str:
    """The name under which a reply is kept: 40 hex digits of model and prompt, each part delimited.

    >>> digest("ab", "c") != digest("a", "bc")
    True
    """
    together = blake2b(digest_size=20)
    for part in parts:
        data = part.encode("utf-8", "surrogatepass")
        together.update(len(data).to_bytes(8, "big") + data)
    return together.hexdigest()


def default_folder(environment: Mapping[str, str]) -> Path:
    """``$XDG_CACHE_HOME/wakeful/replies``, or ``~/.cache/…``; a relative XDG path counts as none, as its standard says."""
    base = Path(environment.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".cache") / "wakeful" / "replies"


class ReplyCache:
    """One JSON file a reply, in a folder that several processes may share: a file is there whole or not at all.

    What stands in a file is checked as if the endpoint had just said it; a file that cannot be read counts as absent.
    Neither question nor key is written, only the reply. A folder that cannot be written costs money, not answers: it is logged.

    Args:
        folder: made when first written, readable by its owner only.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get(self, name: str) -> Reply | None:
        """The reply kept under that digest, as if it had cost nothing; None where there is none."""
        path = self._path(name)
        try:
            with path.open("rb") as file:
                data = file.read(_LARGEST_BYTES + 1)
            reply = msgspec.json.decode(data[:_LARGEST_BYTES], type=Reply)
        except FileNotFoundError:
            return None
        except (OSError, msgspec.MsgspecError, UnicodeDecodeError) as error:
            _log.warning("passed over the cached reply %s: %s", path, error)
            return None
        return msgspec.structs.replace(reply, cost_usd=0.0, calls=0)

    def put(self, name: str, reply: Reply) -> None:
        """Keep a reply under that digest, in place of an older one."""
        path = self._path(name)
        try:
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            handle, draft = tempfile.mkstemp(dir=path.parent, suffix=".draft")  # mkstemp: readable by the owner only
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(msgspec.json.encode(reply))
                os.replace(draft, path)
            except OSError:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(draft)
                raise
        except OSError as error:
            _log.warning("could not keep a reply in %s: %s", self.folder, error)

    def _path(self, name: str) -> Path:
        return self.folder / name[:2] / f"{name}.json"
