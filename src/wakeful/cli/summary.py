"""The wording of a summary."""

from __future__ import annotations

from wakeful.cli.terminal import blocks, heading, paragraph, row, say
from wakeful.journal.overload import Backlog
from wakeful.journal.views import Share, StrangeEpisode, Summary
from wakeful.journal.wording.episodes import ending_words
from wakeful.journal.wording.words import count, duration, instant, percent, plain

#: With fewer events a tenth of them says nothing.
_LEAST_FOR_CURVE = 30


def print_summary(told: Summary, items: int, elapsed_s: float, events_per_second: float) -> None:
    """Print a summary: the strangest episodes first, then the counts, then how they went over time.

    Args:
        told: the summary of the whole journal.
        items: what this run read of its source.
        elapsed_s: how long that took.
        events_per_second: received in this run.
    """
    if told.strangest:
        heading("The strangest episodes")
        for episode in told.strangest:
            _episode(episode)
    heading(f"Summary of {plain(told.source)} ({told.domain})")
    print_state(told)
    if not told.admitted:
        what = "Nothing was received" if not told.received else "Nothing was admitted"
        paragraph(f"{what}: no event came of {count(items, 'item')}. Another domain may hear more: --domain NAME.")
    pace = f"{items / elapsed_s:,.0f} items and {events_per_second:,.1f} events a second" if elapsed_s else "nothing was read"
    row("throughput", f"{pace} ({count(items, 'item')} in {duration(elapsed_s)})")
    print_curve(told)


def print_state(told: Summary) -> None:
    """The counts of a summary, one a line."""
    row(
        "received",
        f"{told.received:,} = {told.admitted:,} admitted + {told.duplicate:,} duplicate + {told.refused:,} refused",
    )
    for reason, number in list(told.refused_because.items())[:3]:
        row("", f"refused {number:,}: {plain(reason, 100)}")
    row(
        "coverage",
        f"{percent(told.coverage)} of admitted events" + (f" ({told.uncovered:,} uncovered)" if told.uncovered else ""),
    )
    row(
        "completion", f"{percent(told.completion)} ({_named(told.completions)})" if told.completions else percent(told.completion)
    )
    row("treatments", _named(told.treatments))
    row("modes", _named(told.modes, told.admitted))
    row("now", f"{told.waiting:,} waiting, {told.suspended:,} suspended" + (f", {told.debt:,} in debt" if told.debt else ""))
    row(
        "first treatment",
        ", ".join(f"{name} events within {duration(seconds)}" for name, seconds in sorted(told.first_treatment_s.items()))
        + (f"; {count(told.expired_waits, 'wait')} expired" if told.expired_waits else ""),
    )
    row(
        "outcomes",
        f"{told.outcomes_witnessed:,} witnessed, {told.outcomes_matched:,} matched to a result, "
        f"{count(told.windows_closed, 'window')} closed over none",
    )
    for reason, number in list(told.outcomes_unmatched.items())[:4]:
        row("", f"{number:,} changed nothing: {plain(reason, 100)}")
    row("verdicts", _named(told.verdicts))
    _accuracy(told)
    row("reasoner", f"{count(told.reasoner_calls, 'call')}" + (f", {told.cost_usd:.4f} USD" if told.cost_usd else ""))
    row(
        "learning",
        f"{count(told.experiences, 'experience')}, {count(told.models_published, 'model version')} published"
        + (f", {told.models_rejected} rejected" if told.models_rejected else "")
        + (f", {count(told.reopened, 'event')} reopened" if told.reopened else ""),
    )
    for index, alarm in enumerate(told.drifted[-3:]):
        row("" if index else "drift", alarm)


def print_backlog(told: Backlog) -> None:
    """What waits to be treated, and what overload cost; nothing where nothing ever waited."""
    if told.not_begun or told.most:
        row(
            "backlog",
            f"{told.not_begun:,} not begun"
            + (f", the oldest for {duration(told.oldest_s)}" if told.not_begun else "")
            + f"; at worst {told.most:,} at once, {duration(told.worst_s)} to the first treatment"
            + (f" ({duration(told.worst_critical_s)} of a critical event)" if told.worst_critical_s else ""),
        )
    if told.shed:
        row("", f"{count(told.shed, 'event')} not deliberated for overload, and in debt")
    for reason, number in told.refused.items():
        row("", f"{number:,} refused: {plain(reason, 100)}")


def _episode(episode: StrangeEpisode) -> None:
    say()
    about = f"{episode.kind} of {episode.entity}" if episode.entity else episode.kind
    say(f"  {instant(episode.at_ns)}  {plain(about)}  [{episode.event[:10]}]", bold=True)
    paragraph(episode.says or about, 4, 11, "opened     ")
    mode = {"auto": "automatically", "delib": "by deliberation", "fallback": "in fallback"}.get(episode.mode, episode.mode)
    concluded = episode.concluded or "nothing yet"
    novelty = f", novelty {episode.novelty:.2f}" if episode.novelty > 0.5 else ""
    paragraph(f"{concluded} ({episode.treatment}, {mode}{novelty})", 4, 11, "concluded  ")
    paragraph(ending_words(episode), 4, 11, "ended      ")


def _accuracy(told: Summary) -> None:
    accuracy = told.accuracy
    if accuracy.treatment.of:
        row("treatment right", _share(accuracy.treatment))
    if accuracy.result.of:
        base = f"; always “{plain(accuracy.base_label)}” would be right in {percent(accuracy.base_rate.fraction)}"
        row("result right", _share(accuracy.result) + base)
    if told.automatic_right.of:
        beside = f"; deliberated: {_share(told.deliberated_right)}" if told.deliberated_right.of else ""
        row("automatic right", _share(told.automatic_right) + beside)
    if accuracy.joint.of:
        row("both right", _share(accuracy.joint))


def print_curve(told: Summary) -> None:
    """The automatic share and the share of right results over time, where there were events enough."""
    if told.admitted < _LEAST_FOR_CURVE:
        return
    heading("Over time (each block a tenth of the events)")
    automatic: list[float | None] = [stretch.automatic for stretch in told.curve]
    right = [stretch.result.fraction for stretch in told.curve]
    known = [share for share in right if share is not None]
    were = f"; {percent(told.automatic_right.fraction)} of them were right" if told.automatic_right.of else ""
    row(
        "automatic share",
        f"{blocks(automatic)}  {percent(automatic[0], 0)} in the first tenth, {percent(automatic[-1], 0)} in the last{were}",
    )
    if known:
        row("result right", f"{blocks(right)}  {percent(known[0], 0)} in the first tenth, {percent(known[-1], 0)} in the last")


def _share(share: Share) -> str:
    return f"{percent(share.fraction)} of {share.of:,} (95 %: {share.low * 100:.1f}–{share.high * 100:.1f} %)"


def _named(counts: dict[str, int], of: int = 0) -> str:
    return (
        ", ".join(f"{number:,} {plain(name)}" + (f" ({percent(number / of)})" if of else "") for name, number in counts.items())
        or "none"
    )
