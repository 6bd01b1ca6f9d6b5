"""How reliable outcomes have proved: does the world say the same again of what is likest?"""

from __future__ import annotations

from collections import OrderedDict

from wakeful.facts.experience import Experience

KEPT_LABELS = 20_000


class Reliability:
    """Agreement of each outcome with that of the likest experience before it, discounted with age.

    Where the world is predictable and validation isn't noisy, likes end alike: then one contradiction is news. Where likes
    end differently anyway, one contradiction says little.
    """

    def __init__(self, memory: float, prior_agreed: float, prior_differed: float) -> None:
        self._keep = 1.0 - 1.0 / memory
        self._prior = (prior_agreed, prior_differed)
        self._agreed = 0.0
        self._differed = 0.0
        self._labels: OrderedDict[int, str] = OrderedDict()

    def learn(self, experience: Experience, rests_on: tuple[int, ...]) -> None:
        """Compare an experience's outcome with that of the likest one that its decision rested on."""
        likest: str | None = None
        for id_ in rests_on:
            likest = self._labels.get(id_)
            if likest is not None:
                break
        if likest is not None:
            self._agreed *= self._keep
            self._differed *= self._keep
            if likest == experience.outcome:
                self._agreed += 1.0
            else:
                self._differed += 1.0
        self._labels[experience.id] = experience.outcome
        if len(self._labels) > KEPT_LABELS:
            self._labels.popitem(last=False)

    @property
    def share(self) -> float:
        """The expected share of agreement, in [0, 1]."""
        agreed, differed = self._prior
        agreed += self._agreed
        return agreed / (agreed + differed + self._differed)

    @property
    def weight(self) -> float:
        """What one contradiction counts for: 1 where likes always end alike, 0 where they do no better than by chance."""
        return max(0.0, 2.0 * self.share - 1.0)
