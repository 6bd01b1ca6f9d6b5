"""`wakeful reproduce`: the paper's experiments on the product's own code, beside the paper's figures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import get_args

import click
import msgspec

from wakeful.cli.options import json_option, option, print_json
from wakeful.cli.progress import Progress as Bar
from wakeful.cli.terminal import heading, paragraph, say, table
from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation import SettingsError
from wakeful.experiments import exp1_treatment, exp2_figures, exp2_processing, exp2_variants, exp3_learning
from wakeful.experiments.exp1_asking import ReasonerName
from wakeful.experiments.report import Part, write_report
from wakeful.experiments.rows import Progress, Reproduced, Row, table_cells

_COLUMNS = ("method", "workload", "metric", "paper", "ours", "z", "s.e.")


class Experiment(msgspec.Struct, frozen=True):
    """One experiment as the command knows it. ``runs_per_seed`` is for the progress bar alone; ``reasoned`` is there in place of
    ``reproduce`` where somebody deliberates; ``draw`` where the rows alone make the figures."""

    seeds: tuple[int, ...]
    runs_per_seed: int
    reproduce: Callable[[Sequence[int], Progress], Reproduced] | None = None
    draw: Callable[[list[Row], Path], list[Path]] | None = None
    reasoned: Callable[[Sequence[int], Progress, ReasonerName], Reproduced] | None = None


_WORKLOADS = sum(len(parameters.loads) for parameters in exp2_processing.PARAMETER_SETS)

EXPERIMENTS: dict[str, Experiment] = {
    "exp1": Experiment(exp1_treatment.SEEDS, exp1_treatment.RUNS_PER_SEED, reasoned=exp1_treatment.reproduce),
    "exp2": Experiment(
        exp2_processing.SEEDS, _WORKLOADS * len(exp2_processing.METHODS), exp2_processing.reproduce, exp2_figures.draw_completion
    ),
    "exp2-untold": Experiment(
        exp2_processing.SEEDS,
        _WORKLOADS * len(exp2_variants.UNTOLD),
        exp2_variants.reproduce_untold,
        exp2_figures.draw_completion,
    ),
    "exp2-frontier": Experiment(
        exp2_processing.SEEDS, exp2_variants.FRONTIER_RUNS, exp2_variants.reproduce_frontier, exp2_variants.draw_frontier
    ),
    "exp3": Experiment(exp3_learning.SEEDS, exp3_learning.RUNS_PER_SEED, exp3_learning.reproduce),
}

ALL: dict[str, str] = {
    "exp1": "Experiment 1: event-dependent treatment",
    "exp2": "Experiment 2: continuous processing",
    "exp3": "Experiment 3: continuous learning, revision and reuse",
}
"""What ``all`` runs, with the headings of its report."""


@click.command("reproduce")
@click.argument("experiment", type=click.Choice([*EXPERIMENTS, "all"]))
@option("--seeds", "count", type=click.IntRange(min=1), default=None, help="How many seeds. Without it: the project's own list.")
@option("--first-seed", type=int, default=None, help="Seeds S, S+1, … in place of the project's own list.")
@option(
    "--reasoner",
    type=click.Choice(get_args(ReasonerName)),
    default="stand-in",
    help="Who deliberates, where somebody does. The stand-in errs at stated rates; openai is set up by the environment.",
)
@option("--out", type=click.Path(path_type=Path, file_okay=False), default=None, help="Write rows and figures to this folder.")
@json_option
def reproduce_command(
    experiment: str, count: int | None, first_seed: int | None, reasoner: ReasonerName, out: Path | None, as_json: bool
) -> None:
    """Run one of the paper's experiments and print its tables beside the paper's figures.

    z is the distance from the paper's mean in units of its standard deviation, s.e. in standard errors of its ten-seed mean.
    With all, the three experiments follow each other, and --out gets one report of them, in HTML and Markdown.
    """
    names = [*ALL] if experiment == "all" else [experiment]
    seeds = {name: chosen_seeds(EXPERIMENTS[name].seeds, count, first_seed) for name in names}
    bar = Bar(sum(EXPERIMENTS[name].runs_per_seed * len(of) for name, of in seeds.items()))
    parts: list[Part] = []
    written: list[Path] = []
    try:
        for name, of in seeds.items():
            found = _run(EXPERIMENTS[name], of, _after(bar, names[: names.index(name)], seeds), reasoner)
            files = _write(name, found, EXPERIMENTS[name], out) if out is not None else []
            written += files
            parts.append(Part(ALL.get(name, name), of, found, files))
    except (SettingsError, ReasonerError) as error:
        raise click.ClickException(str(error)) from error
    finally:
        bar.clear()
    if experiment == "all" and out is not None:
        written += write_report(parts, out)
    if as_json:
        print_json([row for part in parts for row in part.found.rows])
        return
    for part in parts:
        _print(part.found.rows, tuple(part.seeds))
        for remark in part.found.remarks:
            paragraph(remark, indent=0)
    for path in written:
        say(f"written: {path}")


def _run(chosen: Experiment, seeds: tuple[int, ...], progress: Progress, reasoner: ReasonerName) -> Reproduced:
    if chosen.reasoned is not None:
        return chosen.reasoned(seeds, progress, reasoner)
    return chosen.reproduce(seeds, progress) if chosen.reproduce is not None else Reproduced([])


def _after(bar: Bar, earlier: Sequence[str], seeds: dict[str, tuple[int, ...]]) -> Progress:
    """The bar's progress, where these experiments are done already."""
    done = sum(EXPERIMENTS[name].runs_per_seed * len(seeds[name]) for name in earlier)
    return lambda runs, events: bar.show(done + runs, events)


def chosen_seeds(own: tuple[int, ...], count: int | None, first_seed: int | None) -> tuple[int, ...]:
    """The experiment's own list, its beginning, or its continuation; or consecutive seeds from ``first_seed`` on."""
    if first_seed is not None:
        return tuple(range(first_seed, first_seed + (count if count is not None else len(own))))
    if count is None:
        return own
    # More than the list has: it is continued after its greatest.
    return (*own, *range(max(own) + 1, max(own) + 1 + count))[:count]


def _write(experiment: str, found: Reproduced, chosen: Experiment, out: Path) -> list[Path]:
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{experiment}.json"
    path.write_bytes(msgspec.json.format(msgspec.json.encode(found.rows), indent=2) + b"\n")
    if found.draw is not None:
        return [path, *found.draw(out)]
    return [path, *(chosen.draw(found.rows, out) if chosen.draw is not None else [])]


def _print(rows: list[Row], seeds: tuple[int, ...]) -> None:
    told = f"{len(seeds)} seed{'s' if len(seeds) > 1 else ''}"
    for name in sorted({each.table for each in rows}):
        heading(f"Table {name}: mean ± sample standard deviation over {told} ({_listed(seeds)})")
        table(_COLUMNS, table_cells([each for each in rows if each.table == name]), _COLUMNS[3:])
    compared = [each for each in rows if each.paper_mean is not None]
    within = [each for each in compared if each.z is not None and abs(each.z) <= 1.0]
    strict = [each for each in compared if each.standard_errors is not None and abs(each.standard_errors) <= 2.0]
    say()
    paragraph(
        f"{len(within)} of {len(compared)} published cells within one published standard deviation, {len(strict)} within two "
        "standard errors of the paper's ten-seed mean.",
        indent=0,
    )


def _listed(seeds: tuple[int, ...]) -> str:
    if len(seeds) > 2 and seeds == tuple(range(seeds[0], seeds[0] + len(seeds))):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(str(seed) for seed in seeds)
