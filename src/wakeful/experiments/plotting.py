"""Where matplotlib is imported for the experiments' figures: no window, the same bytes for the same numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wakeful.journal.export import MissingExtra

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def new_figure(width_in: float = 6.0, height_in: float = 4.0) -> tuple[Figure, Axes]:
    """An empty figure with one pair of axes.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    try:
        import matplotlib  # noqa: PLC0415
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError as error:
        raise MissingExtra("figures need matplotlib: pip install 'wakeful[plots]'") from error
    matplotlib.rcParams["svg.hashsalt"] = "wakeful"
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    return figure, figure.add_subplot()


def save(figure: Figure, stem: Path) -> list[Path]:
    """Write ``stem.svg`` and ``stem.png``; returns both paths."""
    svg, png = stem.with_suffix(".svg"), stem.with_suffix(".png")
    figure.savefig(svg, metadata={"Date": None})
    figure.savefig(png, dpi=120, metadata={"Software": None})
    return [svg, png]
