"""`wakeful domains` and `treatments`: what wakeful knows on this machine."""

from __future__ import annotations

import click

from wakeful.cli.options import json_option, print_json
from wakeful.cli.terminal import say, table
from wakeful.contracts.domain import DomainError
from wakeful.domains import load, names
from wakeful.facts.domain import DomainSpec
from wakeful.journal.views import View
from wakeful.treatments.registry import Registry


class DomainRow(View, frozen=True):
    """One domain as `wakeful domains --json` lists it."""

    name: str
    version: int
    says: str
    recognised_by: tuple[str, ...]
    simulator: bool
    outcomes: tuple[str, ...]
    detectors: int
    guidelines: int
    error: str = ""


class TreatmentRow(View, frozen=True):
    """One treatment as `wakeful treatments --json` lists it."""

    name: str
    version: int
    says: str
    result: str
    error: str = ""


@click.command("domains")
@json_option
def domains_command(as_json: bool) -> None:
    """List the domains: what each is for, how a source is recognised as one, whether it has a simulator."""
    rows = [_domain(name) for name in names()]
    if as_json:
        print_json(rows)
        return
    table(
        ["domain", "sources", "simulator", "outcomes", "says"],
        [
            [
                row.name,
                ", ".join(row.recognised_by) or "by name only",
                "yes" if row.simulator else "no",
                ", ".join(row.outcomes),
                row.error or row.says,
            ]
            for row in rows
        ],
    )


def _domain(name: str) -> DomainRow:
    try:
        domain = load(name)
    except DomainError as error:
        return DomainRow(
            name=name,
            version=0,
            says="",
            recognised_by=(),
            simulator=False,
            outcomes=(),
            detectors=0,
            guidelines=0,
            error=str(error),
        )
    spec = domain.spec
    return DomainRow(
        name=name,
        version=spec.version,
        says=spec.says,
        recognised_by=_recognised(spec),
        simulator=domain.simulate(0) is not None,
        outcomes=spec.outcome.labels,
        detectors=len(spec.detect),
        guidelines=len(spec.guideline),
    )


def _recognised(spec: DomainSpec) -> tuple[str, ...]:
    return spec.recognise.suffixes or spec.recognise.bridges


@click.command("treatments")
@json_option
def treatments_command(as_json: bool) -> None:
    """List the treatments: wakeful's own and those of installed packages."""
    registry = Registry()
    rows = [
        TreatmentRow(name=found.name, version=found.version, says=found.says, result=found.result.__name__)
        for found in (registry.get(name) for name in registry.names())
    ]
    rows += [TreatmentRow(name=name, version=0, says="", result="", error=why) for name, why in registry.broken.items()]
    if as_json:
        print_json(rows)
        return
    table(
        ["treatment", "version", "result", "says"],
        [[row.name, str(row.version), row.result, row.error or row.says] for row in rows],
        ["version"],
    )
    if any(row.error for row in rows):
        say("a treatment that does not load is never chosen; mend or remove its package", fg="yellow")
