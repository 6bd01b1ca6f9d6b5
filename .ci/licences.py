"""The licences of what the package and its extras bring: permissive ones only, each named by its own package.

./run audit
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, metadata

#: Words that a permissive licence is named with: SPDX identifiers, and the classifiers of older packages.
PERMISSIVE = re.compile(r"\b(MIT|0?BSD|Apache|PSF-2\.0|Python Software Foundation|ISC|Zlib|CC0-1\.0|Unlicense)\b")
RESTRICTIVE = re.compile(r"GPL|AGPL|SSPL|Commons Clause|non-?commercial|Business Source|Proprietary", re.IGNORECASE)

#: Packages that name their licence in other words, with what they are under.
LOOKED_UP = {"apsw": "any OSI-approved licence, at the user's choice"}


def packages() -> list[str]:
    """The names in the lock file for the package and its extras."""
    command = [os.environ.get("UV", "uv"), "export", "--frozen", "--quiet", "--no-dev", "--extra", "all", "--no-emit-project"]
    text = subprocess.run([*command, "--no-hashes"], capture_output=True, text=True, check=True).stdout
    return sorted({re.split(r"[=;\s]", line)[0] for line in text.splitlines() if line[:1].isalpha()})


def licence(name: str) -> str | None:
    """How an installed package names its licence; None where it is not installed on this platform."""
    try:
        told = metadata(name)
    except PackageNotFoundError:
        return None
    classifiers = [each.split("::")[-1].strip() for each in told.get_all("Classifier") or [] if each.startswith("License")]
    return told.get("License-Expression") or "; ".join(classifiers) or (told.get("License") or "").partition("\n")[0]


def main() -> int:
    """Print each package whose licence is not known to be permissive; exit 1 where there is one."""
    looked_at = 0
    doubtful: list[str] = []
    for name in packages():
        named = licence(name)
        if named is None:
            continue
        looked_at += 1
        if name not in LOOKED_UP and (RESTRICTIVE.search(named) or not PERMISSIVE.search(named)):
            doubtful.append(f"{name}: {named or 'names none'}")
    for each in doubtful:
        print(f"licences: {each}")
    print(f"licences: {looked_at} packages, {len(doubtful)} not known to be permissive")
    return 1 if doubtful else 0


if __name__ == "__main__":
    sys.exit(main())
