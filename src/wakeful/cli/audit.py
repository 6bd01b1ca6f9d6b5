"""`wakeful audit`: prove, or refute, that nothing was ignored."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.options import journal_option, json_option, print_json, reading
from wakeful.cli.terminal import on_terminal, say, width
from wakeful.journal.audit import Audit, audit
from wakeful.journal.wording.words import count, plain


@click.command("audit")
@journal_option
@json_option
@click.pass_context
def audit_command(context: click.Context, journal: Path | None, as_json: bool) -> None:
    """Walk a journal line by line and prove or refute what wakeful promises.

    Ends with 0 when every check holds, else with 1 and the first offending line.
    """
    with reading(journal) as opened:
        report = audit(opened)
    if as_json:
        print_json(report)
    else:
        _print(report)
    context.exit(0 if report.ok else 1)


def _print(report: Audit) -> None:
    widest = max(len(name) for name in report.checks)
    for name, finding in report.checks.items():
        verdict = "FAILED" if not finding.ok else "skip  " if finding.skipped else "ok    "
        text = f"{verdict}  {name.ljust(widest)}  {finding.checked:>9,} checked  {finding.skipped or finding.says}"
        say(text[: width()] if on_terminal() else text, fg=None if finding.ok else "red")
        if finding.first_offender:
            offender = finding.first_offender
            where = f"first at line {offender.position} ({offender.record})"
            say(f"        {count(finding.count, 'offence')}, {where}: {plain(offender.says)}")
    say()
    if report.ok:
        say(f"{count(report.lines, 'line')}: nothing was ignored, lost or done twice.", fg="green", bold=True)
    elif report.first_offender:
        first = report.first_offender
        say(f"first offending line: {first.position} ({first.record}): {plain(first.says)}", fg="red", bold=True)
