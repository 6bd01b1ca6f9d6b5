"""Secrets in the tree, by detect-secrets, beside a baseline of what was looked at and is none (made-up keys in tests).

./run audit                                          what is new is an error
uv run --group audit python .ci/secret_scan.py --accept   takes what there is into the baseline, after a person has looked at it
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from detect_secrets.core.secrets_collection import SecretsCollection
from detect_secrets.settings import default_settings

ROOT = Path(__file__).parents[1]
BASELINE = ROOT / ".secrets.baseline"
NOT_SCANNED = {"uv.lock", ".secrets.baseline"}


def files() -> list[str]:
    """What is committed or about to be; without git, everything that is no build product."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode == 0:
        names = listed.stdout.splitlines()
    else:
        parts = ("src", "tests", "docs", "examples", "benchmarks", ".ci")
        names = [str(path.relative_to(ROOT)) for part in parts for path in (ROOT / part).rglob("*")]
    return sorted({name for name in names if name not in NOT_SCANNED and (ROOT / name).is_file()})


def main() -> int:
    """Print each finding that is not in the baseline; exit 1 where there is one."""
    found = SecretsCollection(str(ROOT))
    with default_settings():
        found.scan_files(*files())
    every = sorted(
        (str(Path(each.filename).relative_to(ROOT)), each.line_number, each.type, each.secret_hash)
        for listed in found.data.values()
        for each in listed
    )
    if "--accept" in sys.argv[1:]:
        rows = [{"file": file, "type": kind, "hash": digest} for file, _, kind, digest in every]
        BASELINE.write_text(json.dumps(rows, indent=1) + "\n")
        print(f"secrets: {len(rows)} findings taken into {BASELINE.name}")
        return 0
    known = {(row["file"], row["hash"]) for row in json.loads(BASELINE.read_text())}
    new = [row for row in every if (row[0], row[3]) not in known]
    for file, line, kind, _ in new:
        print(f"secrets: {file}:{line}: {kind}")
    print(f"secrets: {len(files())} files scanned, {len(new)} findings that nobody has looked at")
    return 1 if new else 0


if __name__ == "__main__":
    sys.exit(main())
