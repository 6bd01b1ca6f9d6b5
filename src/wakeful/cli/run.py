"""`wakeful run SOURCE`: the main job. A source in, every event treated, everything journaled, a summary out."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import click
import msgspec

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import alpha_option, delta_option, json_option, option, print_json, retention_options
from wakeful.cli.progress import Progress, Stop, stoppable
from wakeful.cli.sources import Source, default_journal, find_source
from wakeful.cli.summary import print_summary
from wakeful.contracts.bridge import Item
from wakeful.contracts.journal import JournalError
from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.deliberation import REASONERS, SettingsError, from_environment
from wakeful.deliberation import make as make_reasoner
from wakeful.drivers import garbage
from wakeful.drivers.assembly import assemble
from wakeful.drivers.poison import CrashMark
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.simulated import AT_ONCE, SimulatedDriver
from wakeful.drivers.spending import KINDS, spent
from wakeful.facts.events import Draft, Observation
from wakeful.facts.lines import Opened
from wakeful.facts.settings import Gating, MindSettings, Selecting
from wakeful.journal.acts import ActSpool
from wakeful.journal.retention import Retention
from wakeful.journal.sqlite import SqliteJournal, open_journal
from wakeful.journal.views import Summary, View, summary
from wakeful.treatments.registry import Registry

#: How many events a simulated robot, which never ends, meets in one run unless --events says otherwise.
SIMULATED_EVENTS = 1000


class ThisRun(View, frozen=True):
    """What this run added to its journal, which may hold earlier ones."""

    received: int
    admitted: int
    duplicate: int
    refused: int
    items: int
    elapsed_s: float
    events_per_second: float
    interrupted: bool


class Speed(click.ParamType[float]):
    """``max``, or how many times faster than the source's own time."""

    name = "max|1|N"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Seconds of source time per second; 0 for as fast as the machine goes."""
        if value == "max":
            return 0.0
        try:
            speed = float(str(value))
        except ValueError:
            speed = 0.0
        if not 0 < speed < float("inf"):
            self.fail(f"{value!r} is neither 'max' nor a positive number", param, ctx)
        return speed


@click.command("run")
@click.argument("source")
@option("--domain", metavar="NAME|FILE.toml", default=None, help="The domain. Without it: recognised from the source.")
@option(
    "--journal",
    type=click.Path(path_type=Path, dir_okay=False),
    default=None,
    help="The journal to write or go on with. Without it: one per source in the state directory.",
)
@option(
    "--speed",
    type=Speed(),
    default="max",
    show_default=True,
    help="As fast as possible, in the source's own time (1), or N times that.",
)
@option(
    "--events",
    type=click.IntRange(min=1),
    default=None,
    help=f"Stop after so many events; a simulated robot after {SIMULATED_EVENTS:,} unless told otherwise.",
)
@option("--seed", type=int, default=0, show_default=True, help="Of simulation and training.")
@option("--reasoner", type=click.Choice(sorted(REASONERS)), default="guidelines", show_default=True, help="Who deliberates.")
@option(
    "--consult/--no-consult",
    default=None,
    help="Whether treatments put typed questions of their own to the reasoner. Without it: to a model yes, to guidelines no.",
)
@option(
    "--primary-share",
    type=click.FloatRange(0.0, 0.95),
    default=0.0,
    show_default=True,
    help="Share of the steps that is kept free for the robot's own task.",
)
@option(
    "--learner",
    type=click.Choice(["two_heads", "pooled", "boosted"]),
    default="two_heads",
    show_default=True,
    help="What is trained to select treatments: the network alone, or joined by decision lists and trees; boosted: "
    "LightGBM's trees in place of wakeful's own (extra boosting).",
)
@option(
    "--gate",
    type=click.Choice(["benefit", "threshold", "guarantee"]),
    default="benefit",
    show_default=True,
    help="When a treatment may be automatic: where deliberation would do no better, from the paper's threshold on, or where its "
    "risk is held under --alpha.",
)
@alpha_option(0.05)
@delta_option(0.05)
@option(
    "--audit-rate",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=0.2,
    show_default=True,
    help="Under the guarantee: the probability with which an automatic event's outcome counts as evidence.",
)
@option(
    "--novelty-rate",
    type=click.FloatRange(0.0, 1.0, max_open=True),
    default=0.01,
    show_default=True,
    help="Share of familiar events that may be taken for unfamiliar ones, and get a provisional treatment.",
)
@option("--robot", default=None, metavar="NAME", help="The robot's name, where the source does not say it.")
@retention_options
@json_option
@click.pass_context
def run_command(
    context: click.Context,
    source: str,
    domain: str | None,
    journal: Path | None,
    speed: float,
    events: int | None,
    seed: int,
    reasoner: str,
    consult: bool | None,
    primary_share: float,
    learner: Selecting,
    gate: Gating,
    alpha: float,
    delta: float,
    audit_rate: float,
    novelty_rate: float,
    robot: str | None,
    keep_days: float,
    keep_events: int,
    keep_megabytes: int,
    as_json: bool,
) -> None:
    """Read SOURCE, register its events, treat every one, journal everything, learn, and sum up.

    SOURCE is a recording (xlsx, csv, ulg, bag, db3, mcap, JSON lines), '-' for JSON lines on standard input, or the name of a
    domain with a simulator (service_robot, vda5050). Ctrl-C stops cleanly; the same command goes on where it stopped.
    """
    found = find_source(source, domain, seed)
    if robot:
        found = msgspec.structs.replace(found, items=_for_robot(found.items, robot))
    limit = events if events is not None else SIMULATED_EVENTS if found.endless else None
    path = journal or default_journal(found)
    if journal is not None and not journal.parent.is_dir():
        raise Mistake(f"there is no directory {journal.parent} for the journal; make it, or name another place with --journal")
    began_s = time.monotonic()
    retention = Retention(days=keep_days, events=keep_events, megabytes=keep_megabytes)
    with stoppable() as stop, open_journal(path, retention=retention) as opened:
        _check_domain(opened, found, path)
        thinker = _reasoner(reasoner, found, opened)
        before = summary(opened, strange=0) if opened.last else None
        consults = reasoner == "openai" if consult is None else consult
        settings = MindSettings(
            seed=seed,
            primary_share=primary_share,
            consult=consults,
            learner=learner,
            gate=gate,
            alpha=alpha,
            delta=delta,
            audit_rate=audit_rate,
            novelty_rate=novelty_rate,
        )
        items = _drive(found, opened, thinker, settings, speed, limit, stop)
        told = summary(opened)
    this = _this_run(told, before, items, time.monotonic() - began_s, bool(stop.signal))
    if as_json:
        print_json(
            {**msgspec.to_builtins(told), "events_per_second": this.events_per_second, "journal": str(path), "this_run": this}
        )
    else:
        print_summary(told, items, this.elapsed_s, this.events_per_second)
        click.echo(f"\njournal: {path}\nlook closer with: wakeful why EVENT, wakeful stats, wakeful audit", err=True)
    if stop.signal:
        click.echo("stopped; the same command goes on from here", err=True)
        context.exit(128 + stop.signal)


def _drive(
    source: Source,
    journal: SqliteJournal,
    reasoner: Reasoner,
    settings: MindSettings,
    speed: float,
    limit: int | None,
    stop: Stop,
) -> int:
    """Read the source to its end, to the limit of events, or until a stop is asked for. Returns the items that were done."""
    kernel, learner = assemble(source.domain, settings)
    pace = (lambda seconds: stop.pause(seconds / speed)) if speed else None
    try:
        beside = (ActSpool(journal.path), CrashMark(journal.path), Heart.from_environment())
        driver = SimulatedDriver(kernel, journal, reasoner, learner, pace, *beside)
    except msgspec.DecodeError as error:
        raise JournalError(
            f"{journal.path} is damaged: it cannot be recovered from ({error}); restore it from a backup, or begin a new one"
        ) from error
    garbage.settle()
    progress = Progress(source.total)
    received = kernel.counts.received
    items = 0
    # A recording never keeps anybody waiting for its next item, as standard input may.
    at_once = AT_ONCE if limit is None and source.total is not None else 1
    try:
        for position in driver.run(source.name, source.digest, source.items, at_once):
            items += 1
            progress.show(position + 1, kernel.counts.admitted)
            if stop.asked or (limit is not None and kernel.counts.received - received >= limit):
                break
    finally:
        # What was done is committed, whatever ended the loop.
        driver.close()
        progress.clear()
    return items


def _check_domain(journal: SqliteJournal, source: Source, path: Path) -> None:
    """One journal, one domain: another's events could not be recovered under this one's words."""
    for line in journal.lines_of(kinds=("opened",)):
        if isinstance(line.record, Opened) and line.record.domain != source.domain.spec.name:
            raise Mistake(
                f"{path} was made with the domain {line.record.domain}, this source has {source.domain.spec.name}: "
                "name another file with --journal, or the domain with --domain"
            )


def _reasoner(name: str, source: Source, journal: SqliteJournal) -> Reasoner:
    """The reasoner, its budget charged with what earlier runs of the journal spent."""
    registry = Registry()
    meanings = {treatment: registry.get(treatment).says for treatment in registry.names()}
    try:
        so_far = spent(journal.lines_of(kinds=KINDS), name)
        return make_reasoner(name, source.domain.spec, from_environment(os.environ), meanings, so_far)
    except (SettingsError, ReasonerError) as error:
        raise Mistake(str(error)) from error


def _for_robot(items: Callable[[int], Iterable[Item]], robot: str) -> Callable[[int], Iterable[Item]]:
    def named(after: int) -> Iterable[Item]:
        for item in items(after):
            if isinstance(item, Observation | Draft) and not item.robot:
                yield msgspec.structs.replace(item, robot=robot)
            else:
                yield item

    return named


def _this_run(told: Summary, before: Summary | None, items: int, elapsed_s: float, interrupted: bool) -> ThisRun:
    received = told.received - (before.received if before else 0)
    return ThisRun(
        received=received,
        admitted=told.admitted - (before.admitted if before else 0),
        duplicate=told.duplicate - (before.duplicate if before else 0),
        refused=told.refused - (before.refused if before else 0),
        items=items,
        elapsed_s=round(elapsed_s, 6),
        events_per_second=round(received / elapsed_s, 3) if elapsed_s else 0.0,
        interrupted=interrupted,
    )
