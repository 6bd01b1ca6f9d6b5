"""Rows of the benchmark: medians with their range, as JSON and for people."""

from __future__ import annotations

from statistics import median

from benchmarks.peers.systems import SYSTEMS

Found = dict[str, object]

SHOWN = (
    "events_per_second",
    "cpu_us_per_event",
    "cpu_us_range",
    "p50_ms",
    "p99_ms",
    "step_p99_ms",
    "resume_p99_ms",
    "bytes_per_event",
    "peak_mb",
    "threads",
    "lost",
    "repeated",
    "user_lines",
    "events",
    "right",
)


def row_of(system: str, variant: str, runs: list[Found], crash: Found | None, more: Found) -> Found:
    """One system's row: medians over its runs, the range of the two figures that matter most, and what SIGKILL cost."""
    entry = SYSTEMS[system]
    row: Found = {
        "system": system,
        "variant": variant,
        "durable": entry.durable,
        **more,
        "events": runs[0]["events"],
        "runs": len(runs),
        "events_per_second": _middle(runs, "events_per_second"),
        "cpu_us_per_event": _middle(runs, "cpu_us_per_event"),
        "cpu_us_range": _range(runs, "cpu_us_per_event"),
        "events_per_second_range": _range(runs, "events_per_second"),
        "p50_ms": _middle(runs, "admit", 0),
        "p99_ms": _middle(runs, "admit", 1),
        "step_p50_ms": _middle(runs, "step", 0),
        "step_p99_ms": _middle(runs, "step", 1),
        "resume_p50_ms": _middle(runs, "resume", 0),
        "resume_p99_ms": _middle(runs, "resume", 1),
        "bytes_per_event": _middle(runs, "bytes_per_event"),
        "peak_mb": _middle(runs, "peak_mb"),
        "base_mb": _middle(runs, "base_mb"),
        "threads": _middle(runs, "threads"),
        "lost": crash["lost"] if crash else None,
        "repeated": crash["repeated"] if crash else None,
        "in_doubt": crash["in_doubt"] if crash else None,
        "kills": crash["kills"] if crash else None,
        "user_lines": entry.lines_of(variant),
        "right": all(run["right"] for run in runs),
    }
    if "floor_us" in runs[0]:
        row["assembled_us"], row["assembled_us_range"] = row["cpu_us_per_event"], row["cpu_us_range"]
        row["cpu_us_per_event"], row["cpu_us_range"] = _middle(runs, "floor_us"), _range(runs, "floor_us")
        row["stages_us"] = _stages(runs)
    return row


def table(rows: list[Found]) -> str:
    """The rows as Markdown."""
    head = ["system", "durable", *(name.replace("_", " ") for name in SHOWN)]
    lines = [head, ["---"] * len(head)]
    for row in rows:
        name = f"{row['system']} {row['variant']}".strip()
        lines.append([name, "yes" if row["durable"] else "no", *(_shown(row[each]) for each in SHOWN)])
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def assembled(rows: list[Found]) -> str:
    """The floor's stages put together to a program: what its sum leaves out is what holds them together."""
    found = [row for row in rows if "assembled_us" in row]
    return "\n".join(f"the floor's stages as one program: {_shown(row['assembled_us'])} µs of CPU an event" for row in found)


def apart(rows: list[Found]) -> str:
    """What outcomes take of wakeful's journal."""
    found = [row for row in rows if row.get("bytes_without_outcomes")]
    return "\n".join(
        f"{row['system']} {row['variant']}: {row['bytes_without_outcomes']:,.0f} bytes of journal an event without its outcome"
        for row in found
    )


def stages(row: Found) -> str:
    """What the floor is made of."""
    lines = ["| stage | " + " | ".join(("faster", "µs an event", "slower")) + " |", "|---|---|---|---|"]
    for stage, kinds in row["stages_us"].items():  # type: ignore[attr-defined]
        order = sorted(kinds, key=kinds.__getitem__)
        slower = ", ".join(f"{name} {kinds[name]:.2f}" for name in order[1:])
        lines.append(f"| {stage} | {order[0]} | {kinds[order[0]]:.2f} | {slower} |")
    return "\n".join(lines)


def _values(runs: list[Found], name: str, place: int | None) -> list[float]:
    return [run[name] if place is None else run[name][place] for run in runs if run[name] is not None]  # type: ignore[index,misc]


def _middle(runs: list[Found], name: str, place: int | None = None) -> float | None:
    values = _values(runs, name, place)
    return round(median(values), 4) if values else None


def _range(runs: list[Found], name: str) -> list[float]:
    values = _values(runs, name, None)
    return [round(min(values), 2), round(max(values), 2)]


def _stages(runs: list[Found]) -> dict[str, dict[str, float]]:
    every = [run["stages_us"] for run in runs]
    return {
        stage: {name: round(median([each[stage][name] for each in every]), 3) for name in kinds}  # type: ignore[index]
        for stage, kinds in every[0].items()  # type: ignore[attr-defined]
    }


def _shown(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "NO"
    if isinstance(value, list):
        return " .. ".join(_shown(float(each)) for each in value)
    if isinstance(value, float):
        return f"{value:,.0f}" if value >= 100 or value == int(value) else f"{value:.2f}"
    return f"{value:,}" if isinstance(value, int) else str(value)
