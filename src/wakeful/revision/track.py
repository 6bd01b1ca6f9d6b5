"""A treatment's track record: how often the world supported its results, and how it stands since it was last contradicted."""

from __future__ import annotations

from wakeful.facts.experience import Experience, Verdict

_NONE = (0.0, 0.0)


class Track:
    """Per treatment the expected share of supported results, recent ones counting more, and the standing beside it.

    The share is the posterior mean of a Beta distribution that starts at ``expected``, weighing ``cases`` outcomes, and forgets
    over ``memory`` outcomes of the treatment, in whatever mode they came about.
    """

    def __init__(self, expected: float, cases: float, memory: float) -> None:
        self._prior = (expected * cases, (1.0 - expected) * cases)
        self._keep = 1.0 - 1.0 / memory
        self._counts: dict[str, tuple[float, float]] = {}
        self._standing: dict[str, float] = {}

    def learn(self, experience: Experience) -> None:
        """Count a supported or contradicted result."""
        supported, contradicted = self._counts.get(experience.treatment, _NONE)
        supported, contradicted = supported * self._keep, contradicted * self._keep
        if experience.verdict is Verdict.SUPPORTED:
            supported += experience.weight
        elif experience.verdict is Verdict.CONTRADICTED:
            contradicted += experience.weight
        else:
            return
        self._counts[experience.treatment] = (supported, contradicted)

    def share(self, treatment: str) -> float:
        """The expected share of its results that the world supports, in (0, 1)."""
        supported, contradicted = self._counts.get(treatment, _NONE)
        supported, contradicted = self._prior[0] + supported, self._prior[1] + contradicted
        return supported / (supported + contradicted)

    def standing(self, treatment: str) -> float:
        """What its contradictions have left of trust in it, in [0, 1]; 1 where none has to be made good."""
        return self._standing.get(treatment, 1.0)

    def stand(self, treatment: str, level: float) -> None:
        """Trust is at ``level`` now, as recorded: the standing is that level's part of the share."""
        self._standing[treatment] = min(1.0, max(0.0, level / self.share(treatment)))
