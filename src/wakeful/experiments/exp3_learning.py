"""Experiment 3: continuous learning, revision and reuse (Sec. IV-D, Tables 5 and 6), with the learner and memory that ship.

    wakeful reproduce exp3

A robot that has learned from 198 materials meets 64 events: 28 familiar ones, 6 of new types, 24 of four signatures whose outcome
has changed, and the new types again. Each event's validation comes later (``worlds/service_drift.py``). ``exp3_baselines.py``
has the paper's methods, ``exp3_wakeful.py`` the product's, ``exp3_reasoner.py`` the stand-in whom all of them ask.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context
from statistics import fmean

from wakeful.contracts.learner import Learner
from wakeful.experiments.exp3_baselines import AlwaysLLM, Method, Said, TwoHeaded
from wakeful.experiments.exp3_figures import draw
from wakeful.experiments.exp3_trust import Course, courses, told_of
from wakeful.experiments.exp3_wakeful import Once, Wakeful
from wakeful.experiments.rows import Progress, Reproduced, Row, row
from wakeful.experiments.worlds.service_drift import REPETITIONS, VARIANTS, DriftWorld, Met, Stage, Variant, world
from wakeful.facts.values import Fact
from wakeful.learning.pooled import Pooled

#: The project's ten seeds: of the first 200, those whose worlds are the most typical in what they contain.
#: No method had run on them then.
SEEDS = (26, 41, 67, 75, 118, 158, 164, 167, 170, 191)

METHODS: dict[str, Callable[[DriftWorld], Method]] = {
    "always_llm": AlwaysLLM,
    "offline_multihead": partial(TwoHeaded, updates=False),
    "continual_outcome_only": partial(TwoHeaded, treats=False),
    "proposed": TwoHeaded,
    "wakeful": Wakeful,
}
RUNS_PER_SEED = len(METHODS) * len(VARIANTS)

REPEATED = tuple(f"drift_joint_rep{number}" for number in range(1, REPETITIONS + 1))
METRICS: dict[str, str] = {
    "treatment": "5",
    "outcome": "5",
    "joint": "5",
    "automatic": "5",
    "reasoner_calls": "5",
    "novel_first_joint": "6",
    "novel_reuse_joint": "6",
    "novel_reuse_automatic": "6",
    "drift_initial_joint": "6",
    "drift_late_joint": "6",
    "delayed_revision": "6",
    **dict.fromkeys(REPEATED, "6"),
}
"""Metric → the paper's table that it stands in; the repetitions are its figure's."""
LATE = 4
"""From this repetition on it is late."""


class Measured(Fact, frozen=True):
    """One run: its figures by metric, what it said of the changed events, and, of ``wakeful``, what it knew before and after.

    ``kept``: accuracy in percent, treatment and outcome together, on familiar events before and after the stream: those of the
    stream, and 200 that were never met. ``noise`` is what it took for the share of wrong validations, event by event.
    """

    figures: dict[str, float | None]
    courses: tuple[Course, ...]
    kept: tuple[float, float, float, float] | None = None
    noise: tuple[float, ...] = ()


Results = dict[tuple[str, str], list[Measured]]
"""(method, variant) → one run per seed, in the order of the seeds."""


# --- one run ---


def run(method: Method, of: DriftWorld) -> Iterator[Said]:
    """Event by event what a method concludes. A validation is told before the first event that comes after it is there."""
    said: list[Said] = []
    waiting = list(range(len(of.stream)))
    for place, met in enumerate(of.stream):
        for earlier in [each for each in waiting if each < place and of.stream[each].known_from <= place]:
            waiting.remove(earlier)
            method.learn(earlier, of.stream[earlier], said[earlier])
        said.append(method.decide(place, met))
        yield said[-1]
    for earlier in waiting:
        method.learn(earlier, of.stream[earlier], said[earlier])


def one(name: str, variant: Variant, seed: int, learner: Learner | None = None) -> Measured:
    """One method on one world; ``learner`` is ``wakeful``'s, where it is not one of its own."""
    of = world(variant, seed)
    method = Wakeful(of, learner) if name == "wakeful" else METHODS[name](of)
    if not isinstance(method, Wakeful):
        said = list(run(method, of))
        return Measured(figures=figures(of, said), courses=courses(of, said))
    familiar = [met for met in of.stream if met.stage == "familiar"]
    before = method.accuracy(familiar), method.accuracy(of.held)
    said, noise = [], []
    for each in run(method, of):
        said.append(each)
        noise.append(method.memory.noise)
    after = method.accuracy(familiar), method.accuracy(of.held)
    return Measured(
        figures=figures(of, said), courses=courses(of, said), kept=(before[0], after[0], before[1], after[1]), noise=tuple(noise)
    )


def figures(of: DriftWorld, said: Sequence[Said]) -> dict[str, float | None]:
    """Tables 5 and 6 of one run; percent but for the calls. Joint is right where treatment and outcome both are.

    Delayed revision: of the signatures that were wrong at their first repetition, the share that is right at the last.
    """
    met = list(zip(of.stream, said, strict=True))
    joint = [(event, right(event, each)) for event, each in met]
    first = {event.signature: good for event, good in joint if event.repetition == 1}
    last = {event.signature: good for event, good in joint if event.repetition == REPETITIONS}
    found: dict[str, float | None] = {
        "treatment": _percent(event.treatment == each.treatment for event, each in met),
        "outcome": _percent(event.outcome == each.outcome for event, each in met),
        "joint": _percent(good for _, good in joint),
        "automatic": _percent(each.mode == "auto" for each in said),
        "reasoner_calls": float(sum(each.mode != "auto" for each in said)),
        "novel_first_joint": _percent(_of(joint, "novel")),
        "novel_reuse_joint": _percent(_of(joint, "reuse")),
        "novel_reuse_automatic": _percent(each.mode == "auto" for event, each in met if event.stage == "reuse"),
        "drift_initial_joint": _percent(good for event, good in joint if event.repetition == 1),
        "drift_late_joint": _percent(good for event, good in joint if event.repetition >= LATE),
        "delayed_revision": _percent(last[name] for name, good in first.items() if not good),
    }
    for number, name in enumerate(REPEATED, 1):
        found[name] = _percent(good for event, good in joint if event.repetition == number)
    return found


def right(met: Met, said: Said) -> bool:
    """Whether treatment and outcome both are."""
    return met.treatment == said.treatment and met.outcome == said.outcome


def _of(joint: Iterable[tuple[Met, bool]], stage: Stage) -> Iterator[bool]:
    return (good for met, good in joint if met.stage == stage)


def _percent(flags: Iterable[bool]) -> float | None:
    counted = list(flags)
    return 100.0 * sum(counted) / len(counted) if counted else None


# --- all runs ---


def of_seed(seed: int, methods: Sequence[str], variants: Sequence[Variant]) -> dict[tuple[str, str], Measured]:
    """Every method on every variant of one seed's world. What is the same before the stream, is trained once."""
    learner = Once(Pooled())
    return {(name, variant.name): one(name, variant, seed, learner) for variant in variants for name in methods}


def measure_all(
    seeds: Sequence[int],
    progress: Progress,
    methods: Sequence[str] = tuple(METHODS),
    variants: Sequence[Variant] = VARIANTS,
    workers: int = 2,
) -> Results:
    """Every method on every variant of every seed's world, ``workers`` seeds at a time in processes of their own.

    Args:
        seeds: of the worlds; each method meets the same ones.
        progress: told after each seed how many runs are done, and how many events they had.
        methods: by name.
        variants: of the world.
        workers: 1 keeps to this process.
    """
    found: dict[int, dict[tuple[str, str], Measured]] = {}
    runs = len(methods) * len(variants)
    events = 64
    if workers == 1 or len(seeds) == 1:
        for seed in seeds:
            found[seed] = of_seed(seed, methods, variants)
            progress(runs * len(found), runs * events * len(found))
    else:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            asked = {pool.submit(of_seed, seed, methods, variants): seed for seed in seeds}
            for done in as_completed(asked):
                found[asked[done]] = done.result()
                progress(runs * len(found), runs * events * len(found))
    return {key: [found[seed][key] for seed in seeds] for key in found[seeds[0]]}


def rows(results: Results) -> list[Row]:
    """Means and sample standard deviations over the seeds; the paper's cells stand beside ``clean``."""
    found = (
        row(table, method, variant, metric, [each.figures[metric] for each in measured])
        for (method, variant), measured in results.items()
        for metric, table in METRICS.items()
    )
    return [each for each in found if each is not None]


def reproduce(seeds: Sequence[int], progress: Progress) -> Reproduced:
    """Tables 5 and 6 for all variants, with what was kept, how trust moved, and the recovery figure."""
    results = measure_all(seeds, progress)
    found = rows(results)
    ours = {variant: measured for (method, variant), measured in results.items() if method == "wakeful"}
    said = [_above(results, variant.name) for variant in VARIANTS]
    said += [_kept(variant, measured) for variant, measured in ours.items()]
    said += told_of([each for measured in ours["noisy"] for each in measured.courses])
    said.append(
        "Taken for the share of wrong validations at the end: "
        + ", ".join(f"{variant} {fmean(each.noise[-1] for each in measured):.1%}" for variant, measured in ours.items())
        + "."
    )
    noisy = {name: [each for run in results[name, "noisy"] for each in run.courses] for name in ("proposed", "wakeful")}
    return Reproduced(found, [*said, *_outside(found)], partial(draw, found, noisy))


# --- what the runs say ---


def _above(results: Results, variant: str) -> str:
    """By how much ours is above the paper's method on the same worlds."""
    pairs = zip(results["wakeful", variant], results["proposed", variant], strict=True)
    steps = [(ours.figures["joint"] or 0.0) - (theirs.figures["joint"] or 0.0) for ours, theirs in pairs]
    return f"wakeful above proposed on {variant}, joint: {fmean(steps):+.2f} points."


def _kept(variant: str, measured: Sequence[Measured]) -> str:
    kept = [each.kept for each in measured if each.kept is not None]
    before, after, held_before, held_after = (fmean(each[place] for each in kept) for place in range(4))
    return (
        f"Familiar events before and after the 64, {variant}: the stream's own {before:.2f} and {after:.2f} %, "
        f"200 never met {held_before:.2f} and {held_after:.2f} %."
    )


def _outside(found: Sequence[Row]) -> list[str]:
    """The cells further than one published standard deviation from the paper's."""
    far = [each for each in found if each.paper_mean is not None and (each.z is None or abs(each.z) > 1.0)]
    listed = ", ".join(
        f"{each.method} {each.metric} "
        + (f"(z {each.z:+.2f})" if each.z is not None else f"({each.mean:.2f}; published {each.paper_mean:.2f} ± 0)")
        for each in far
    )
    return [f"Further than one published standard deviation: {listed or 'none'}."]
