"""What is promised of automatic processing, and how it is watched."""

from __future__ import annotations

from typing import Literal

import msgspec


class GuaranteeSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The promise: per treatment P(wrong and automatic) stays under ``alpha``, with probability 1 − ``delta``.

    ``audit_rate``: with which probability an automatic event is drawn, so that its outcome counts. Before a treatment is
    certified each of its events is drawn. ``audit_by``: whether a drawn event runs as it would have and its outcome is awaited,
    or is deliberated. ``change``: the declared size of a change, so many times α; ``patience``: so many events pass on average at
    least before a false alarm while the risk is no more than α. ``unknown``: what a drawn event counts as whose outcome was
    not decided: ``wrong``, which assumes nothing, or ``left out``, which assumes that outcomes are lost by mere chance.
    ``seek_from``: a model version that has learned from fewer experiences is not put to the test: it will soon give way to
    another, and each test uses up a part of δ.
    """

    alpha: float = 0.05
    delta: float = 0.05
    audit_rate: float = 0.2
    audit_by: Literal["outcome", "deliberation"] = "outcome"
    change: float = 4.0
    patience: float = 100.0
    unknown: Literal["wrong", "left out"] = "wrong"
    seek_from: int = 200

    def __post_init__(self) -> None:
        for name in ("alpha", "delta"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise ValueError(f"{name} is {getattr(self, name)}; it must lie between 0 and 1")
        if not 0.0 < self.audit_rate <= 1.0:
            raise ValueError(f"audit_rate is {self.audit_rate}; it must lie above 0, up to 1: without audits nothing is known")
        if self.change <= 1.0:
            raise ValueError(f"change is {self.change}; a change makes the risk more than 1 times α")
        if self.patience <= 1.0:
            raise ValueError(f"patience is {self.patience}; it counts the events to a false alarm, more than 1")

    @property
    def to(self) -> float:
        """The risk after a change of the declared size, below 1."""
        return min(self.change * self.alpha, (1.0 + self.alpha) / 2.0)

    def delta_of(self, number: int) -> float:
        """What of δ the treatment's certificate of that number, from 1, may use: δ/(n(n + 1)), δ over all of them."""
        return self.delta / (number * (number + 1))
