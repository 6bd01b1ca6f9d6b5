"""Known weaknesses of what the lock file names, by pip-audit. Says so where nobody could be asked; never passes silently.

    ./run audit

Exit 0: none is known, or nobody could be asked and WAKEFUL_CI_STRICT is not set. Exit 1: there is one, or strict and not asked.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import msgspec

#: Advisories that don't apply here, each with its reason. Empty is best.
NOT_APPLICABLE: dict[str, str] = {}

#: pip-audit's services, in the order in which they are asked.
SERVICES = ("pypi", "osv")


class Weakness(msgspec.Struct):
    """One known weakness, as pip-audit tells it."""

    id: str
    fix_versions: list[str] = []


class Dependency(msgspec.Struct):
    """One package with what is known against it."""

    name: str
    version: str = ""
    skip_reason: str = ""
    vulns: list[Weakness] = []


class Report(msgspec.Struct):
    """pip-audit's whole report."""

    dependencies: list[Dependency]


def locked(folder: Path) -> Path:
    """What the lock file names for the package and its extras, as a requirements file."""
    file = folder / "requirements.txt"
    command = [os.environ.get("UV", "uv"), "export", "--frozen", "--quiet", "--no-dev", "--extra", "all", "--no-emit-project"]
    with file.open("w") as out:
        subprocess.run([*command, "--no-hashes"], stdout=out, check=True)
    return file


def asked(requirements: Path, service: str) -> Report | None:
    """What that service knows; None where it could not be asked, or knows none of the packages (a mirror without advisories)."""
    command = [sys.executable, "-m", "pip_audit", "--requirement", str(requirements), "--no-deps", "--disable-pip"]
    options = ["--progress-spinner", "off", "--format", "json", "--timeout", "15", "--vulnerability-service", service]
    done = subprocess.run([*command, *options], capture_output=True, text=True, timeout=600, check=False)
    try:
        report = msgspec.convert(json.loads(done.stdout), Report, strict=False)
    except (json.JSONDecodeError, msgspec.ValidationError):
        return None
    return report if any(not each.skip_reason for each in report.dependencies) else None


def main() -> int:
    """Print what was found, or that nobody could be asked."""
    with tempfile.TemporaryDirectory() as folder:
        requirements = locked(Path(folder))
        reports = {service: report for service in SERVICES if (report := asked(requirements, service)) is not None}
    if not reports:
        print(
            f"advisories: SKIPPED: neither of {', '.join(SERVICES)} could be asked from this machine; nothing is known either way"
        )
        return 1 if os.environ.get("WAKEFUL_CI_STRICT") else 0
    service, report = next(iter(reports.items()))
    unknown = [each.name for each in report.dependencies if each.skip_reason]
    found = [(each, weak) for each in report.dependencies for weak in each.vulns if weak.id not in NOT_APPLICABLE]
    for each, weak in found:
        print(f"advisories: {each.name} {each.version}: {weak.id}, mended in {', '.join(weak.fix_versions) or 'no version yet'}")
    if unknown:
        print(f"advisories: not known to {service}: {', '.join(unknown)}")
    print(f"advisories: {len(report.dependencies) - len(unknown)} packages asked about at {service}, {len(found)} weaknesses")
    return 1 if found or unknown else 0


if __name__ == "__main__":
    sys.exit(main())
