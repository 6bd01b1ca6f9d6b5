"""The guarantee, measured: simulated deployments with delayed, selectively observed outcomes and a change half way.

    ./run python -m benchmarks.guarantee [--deployments 1000] [--events 4000] [--seed 0] [--picture FILE.svg]

Each deployment is one treatment of one robot: its model scores every event, and is wrong with a probability that the world
knows. The gate is the product's own, run over all deployments side by side; the true risk of the rule in force is computed,
not estimated. Prints what docs/guarantee.md shows.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from functools import lru_cache
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from benchmarks.deployments import SEEN_RIGHT, SEEN_WRONG, UNTOLD, WRONG_AFTER, Lived, World, guarded, thresholded
from wakeful.selection.guarantee import Guarantee, GuaranteeSettings
from wakeful.selection.guarantee.bets import Tally
from wakeful.selection.guarantee.bounds import clopper_pearson, error_free_needed
from wakeful.selection.guarantee.evidence import Evidence
from wakeful.selection.guarantee.watch import excess_bound

RATES = (0.05, 0.2, 0.5, 1.0)


def main() -> None:
    """Print the tables; draw the picture where one is wanted."""
    parse = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parse.add_argument("--deployments", type=int, default=1000)
    parse.add_argument("--events", type=int, default=4000)
    parse.add_argument("--seed", type=int, default=0)
    parse.add_argument("--picture", type=Path)
    given = parse.parse_args()
    own = GuaranteeSettings()
    print_sample_sizes(own)
    print_cost(own)
    lives = []
    for rate in RATES:
        settings = GuaranteeSettings(audit_rate=rate)
        world = World.make(given.deployments, given.seed)
        lives.append((settings, world, _timed(lambda s=settings, w=world: guarded(w, s, given.events, _name(s)))))
    for calibration, strict in ((42, True), (42, False), (420, False)):
        world = World.make(given.deployments, given.seed)
        lives.append((own, world, thresholded(world, own, given.events, calibration, strict)))
    world = World.make(given.deployments, given.seed)
    seen = _timed(lambda: guarded(world, own, given.events, "the same bets on what is seen by itself", audits=False))
    lives.append((own, world, seen))
    print(
        f"\n{given.deployments:,} deployments of {given.events:,} events, α = {own.alpha:g}, δ = {own.delta:g}, seed "
        f"{given.seed}. At event {given.events // 2:,} every answer becomes wrong with probability {WRONG_AFTER:g} at least. "
        f"Outcomes come 10 to 60 events late; of automatic answers that nobody asked about {SEEN_WRONG:.0%} of the wrong "
        f"and {SEEN_RIGHT:.0%} of the right are seen; {UNTOLD:.1%} of those asked about are never told and count as wrong."
    )
    print_before(lives)
    print_after(lives)
    if given.picture is not None:
        draw(lives, given.picture)


def _name(settings: GuaranteeSettings) -> str:
    return f"guarantee, audits {settings.audit_rate:.0%}"


def _timed(run: object) -> Lived:
    began_s = time.monotonic()
    lived: Lived = run()  # type: ignore[operator]
    print(f"{lived.name}: {time.monotonic() - began_s:.0f} s", file=sys.stderr)
    return lived


def print_sample_sizes(own: GuaranteeSettings) -> None:
    """How many outcomes it takes, and how the bound tightens with them."""
    needed = error_free_needed(own.alpha, own.delta)
    print(f"Without an error, {needed} outcomes hold a risk under {own.alpha:.0%} with {1 - own.delta:.0%}, looked at once;")
    print(
        f"looked at after every outcome {Tally().more_needed(0, own.alpha, own.delta)}, and {_first(own)} at the part of δ that a"
    )
    print("first certificate may use.\n\n| outcomes | errors | bound, one look | bound at every time |\n|---:|---:|---:|---:|")
    for cases in (42, 59, 88, 200, 500, 2000):
        for share in (0.0, 0.02):
            errors = round(share * cases)
            if share and not errors:
                continue
            tally = Tally()
            tally.errors += errors
            tally.quiet[1.0] += cases - errors
            every = float(tally.bound(own.delta)[0])
            print(f"| {cases:,} | {errors} | {clopper_pearson(errors, cases, own.delta):.3f} | {every:.3f} |")


def print_cost(own: GuaranteeSettings) -> None:
    """What the gate costs a decision, and an outcome."""
    gate, evidence, yes = Guarantee(own), Evidence(own), np.asarray(True)
    turns = 5000
    began_s = time.process_time()
    for turn in range(turns):
        gate.rule(str(turn), "treatment", "label", 1, 0.97)
    rule_s = time.process_time() - began_s
    began_s = time.process_time()
    for _ in range(turns):
        evidence.take(np.asarray(0), yes, ~yes, yes, own.audit_rate, yes)
        evidence.weigh()
        evidence.alarms()
    take_s = time.process_time() - began_s
    each_us = 1e6 * rule_s / turns, 1e6 * take_s / turns
    print(f"\nA decision costs {each_us[0]:.1f} µs (its draw), an outcome {each_us[1]:.0f} µs, however many came before.")


def _first(own: GuaranteeSettings) -> int:
    return Tally().more_needed(0, own.alpha, own.delta_of(1))


def print_before(lives: list[tuple[GuaranteeSettings, World, Lived]]) -> None:
    """What was promised and what was kept until the change."""
    print("\n| gate | true risk ever > α | share of errors so far ever > α | automatic at the end | automatic from event |")
    print("|---|---:|---:|---:|---:|")
    for _, _, lived in lives:
        began = lived.first[lived.first >= 0]
        median = f"{np.median(began):,.0f} ({len(began) / len(lived.first):.1%} of them)" if len(began) else "never"
        print(
            f"| {lived.name} | {_share(lived.above)} | {_share(lived.realised)} | {lived.automatic.mean():.1%} "
            f"({np.quantile(lived.automatic, 0.1):.0%} … {np.quantile(lived.automatic, 0.9):.0%}) | {median} |"
        )


def print_after(lives: list[tuple[GuaranteeSettings, World, Lived]]) -> None:
    """What the change cost, where it was of the declared size and the treatment was automatic."""
    print(
        "\n| gate | changed so | revoked before, without need | events to revocation: median, 95 % | errors until then: mean, "
        "95 % | in excess of α: mean, 95 % | stated B: median | more than B |"
    )
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for settings, world, lived in lives:
        some = lived.at_change
        found = some & (lived.delay >= 0)
        bounds = np.array([_bound(settings, int(delay)) for delay in world.delay])
        delay = f"{np.median(lived.delay[found]):,.0f}, {np.quantile(lived.delay[found], 0.95):,.0f}" if found.any() else "never"
        promised = lived.name.startswith("guarantee")
        after, excess = lived.after[some], (lived.after - lived.allowed)[some]
        print(
            f"| {lived.name} | {some.sum():,} | {(lived.revoked_before > 0).sum():,} | {delay} | {after.mean():.0f}, "
            f"{np.quantile(after, 0.95):.0f} | {excess.mean():.0f}, {np.quantile(excess, 0.95):.0f} | "
            + (f"{np.median(bounds[some]):.0f} | {(after > bounds[some]).mean():.2%} |" if promised else "none | – |")
        )


@lru_cache
def _bound(settings: GuaranteeSettings, delay: int) -> int:
    return excess_bound(settings.alpha, settings.to, settings.audit_rate, delay, settings.patience, settings.delta)


def _share(flags: np.ndarray) -> str:
    count = int(flags.sum())
    return f"{count / len(flags):.1%} (at most {clopper_pearson(count, len(flags), 0.025):.1%})"


def draw(lives: list[tuple[GuaranteeSettings, World, Lived]], path: Path) -> None:
    """Errors after the change, every deployment's, by gate."""
    import matplotlib as mpl  # noqa: PLC0415

    mpl.use("svg")
    from matplotlib import pyplot as plt  # noqa: PLC0415

    mpl.rcParams["svg.hashsalt"] = "wakeful"
    figure, axes = plt.subplots(figsize=(8, 4))
    for settings, world, lived in lives:
        after = np.quantile(lived.after[lived.at_change], np.linspace(0, 1, 101))
        style = "-" if lived.name.startswith("guarantee") else "--"
        (line,) = axes.plot(np.maximum(after, 0.9), np.linspace(0, 1, len(after)), style, label=lived.name)
        if lived.name.startswith("guarantee"):
            stated = np.median([_bound(settings, int(delay)) for delay in world.delay])
            axes.plot([stated], [1 - settings.delta], "v", color=line.get_color())
    axes.set_xscale("log")
    axes.set_xlabel("wrong automatic answers after the change, until revocation or the end (▾ stated B at 1 − δ)")
    axes.set_ylabel("share of deployments")
    axes.legend(fontsize=7, loc="lower right")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
