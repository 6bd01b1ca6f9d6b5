"""What memory says of an event that is like one experienced before."""

from __future__ import annotations

from wakeful.facts.values import Fact


class Recollection(Fact, frozen=True):
    """What validated experiences of events sufficiently similar to one at hand say of it.

    ``exemplar`` is the id of the first of them, ``experiences`` the newest of them, newest first. ``treatment`` is the right one
    as far as was told, empty where nothing was, held with ``treatment_share``; ``labels`` are the probabilities of the outcomes.
    ``noise`` is the share of wrong validations to be expected of this very event, ``likeness`` how like it is, in [0, 1].
    ``confirmed``: the right treatment was told, or what was applied was supported, in an experience that ended as is expected.
    """

    exemplar: int
    experiences: tuple[int, ...]
    likeness: float
    treatment: str
    treatment_share: float
    labels: dict[str, float]
    noise: float
    confirmed: bool = True
    contradicted: bool = False
    """Whether the last validation told another outcome than is believed."""

    @property
    def label(self) -> str:
        """The likeliest outcome; of equally likely ones the first."""
        return max(self.labels, key=lambda name: self.labels[name], default="")

    @property
    def share(self) -> float:
        """How far what memory says is believed: the less certain of treatment and outcome."""
        told = self.labels.get(self.label, 1.0)
        return min(told, self.treatment_share) if self.treatment else told
