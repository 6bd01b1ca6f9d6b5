"""A drift alarm per treatment, with a false-alarm rate that is a setting; and whether the world changed or only grew noisier."""

from __future__ import annotations

from collections import Counter, deque
from math import sqrt

import msgspec

from wakeful.facts.experience import Experience, Verdict

#: Bets on how much worse it has become, as shares of the largest bet that cannot lose everything.
BETS = (0.05, 0.15, 0.35, 0.65)

#: A forecast fails "now" where at least this share of its results since the change was contradicted, at 95 % confidence.
FAILS = 0.5


class DriftSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``every``: while a treatment errs no more than before, at least so many of its results lie between two alarms on average.

    ``baseline`` results say what "before" is: the upper end of their error's confidence interval, ``sigmas`` wide. ``remembered``
    results are looked at to say what changed.
    """

    every: float = 2_000.0
    baseline: int = 40
    sigmas: float = 1.64
    least: float = 0.02
    remembered: int = 200


class Alarm(msgspec.Struct, frozen=True, kw_only=True):
    """A treatment errs more than before. ``changed``: one forecast fails consistently; else it is noise that grew."""

    treatment: str
    before: float
    wrong: int
    of: int
    changed: bool
    says: str


class _Stream(msgspec.Struct):
    """One treatment's results since its last alarm."""

    seen: int = 0
    wrong: int = 0
    allowed: float = 0.0
    evidence: list[float] = []
    longest: list[float] = []
    since: list[int] = []
    recent: deque[tuple[int, str, str, bool]] = msgspec.field(default_factory=deque)


class Drift:
    """Shiryaev–Roberts e-detectors on the running error of each treatment.

    Source: Shin, Ramdas and Rinaldo, *E-detectors: a nonparametric framework for sequential change detection* (2023). With bets
    b and errors x in {0, 1}, M = (1 + b (x − p)) (M + 1) exceeds n on average never while the chance of an error, given all
    before, is at most p: alarms at M ≥ ``every`` are on average at least that many results apart.
    """

    def __init__(self, settings: DriftSettings | None = None) -> None:
        self.settings = settings or DriftSettings()
        self._streams: dict[str, _Stream] = {}

    def learn(self, experience: Experience) -> None:
        """Take up one decided result. O(1)."""
        if experience.verdict is Verdict.UNDECIDED:
            return
        wrong = experience.verdict is Verdict.CONTRADICTED
        stream = self._streams.setdefault(experience.treatment, _Stream())
        stream.seen += 1
        stream.recent.append((stream.seen, experience.predicted, experience.outcome, wrong))
        if len(stream.recent) > self.settings.remembered:
            stream.recent.popleft()
        if stream.seen <= self.settings.baseline:
            stream.wrong += wrong
            if stream.seen == self.settings.baseline:
                self._begin(stream)
            return
        evidence, longest = stream.evidence, stream.longest
        for place, bet in enumerate(BETS):
            growth = 1.0 + bet / stream.allowed * (1.0 - stream.allowed) if wrong else 1.0 - bet
            evidence[place] = growth * (evidence[place] + 1.0)
            if longest[place] <= 1.0:
                longest[place], stream.since[place] = 1.0, stream.seen
            longest[place] *= growth

    def alarm(self, treatment: str) -> Alarm | None:
        """Whether the treatment errs more than before, as of what was learned; asking changes nothing."""
        stream = self._streams.get(treatment)
        if stream is None or not stream.evidence or sum(stream.evidence) < self.settings.every * len(BETS):
            return None
        surest = max(range(len(BETS)), key=lambda place: stream.longest[place])
        results = [each for each in stream.recent if each[0] >= stream.since[surest]] or list(stream.recent)
        wrong = sum(1 for each in results if each[3])
        failing = _failing(results)
        whole = f"{wrong} of its last {len(results)} results were contradicted, at most {stream.allowed:.0%} were expected"
        return Alarm(
            treatment=treatment,
            before=round(stream.allowed, 6),
            wrong=wrong,
            of=len(results),
            changed=failing is not None,
            says=f"{whole}: {failing or 'no forecast fails consistently, so outcomes have become noisier'}",
        )

    def reset(self, treatment: str) -> None:
        """The alarm was raised: what comes from here on is the new normal."""
        self._streams.pop(treatment, None)

    def _begin(self, stream: _Stream) -> None:
        own = self.settings
        share = (stream.wrong + 1.0) / (stream.seen + 2.0)
        stream.allowed = min(0.95, max(own.least, share + own.sigmas * sqrt(share * (1.0 - share) / stream.seen)))
        stream.evidence, stream.longest, stream.since = ([0.0] * len(BETS), [1.0] * len(BETS), [stream.seen] * len(BETS))


def _failing(results: list[tuple[int, str, str, bool]]) -> str | None:
    """The forecast that fails consistently since the change, in words; None where none does."""
    made = Counter(predicted for _, predicted, _, _ in results)
    shown = Counter((predicted, label) for _, predicted, label, wrong in results if wrong)
    for (predicted, label), failed in shown.most_common():
        if _lower(failed, made[predicted]) > FAILS:
            return (
                f"where it forecasts {predicted!r} the world now shows {label!r} ({failed} of {made[predicted]}): it has changed"
            )
    return None


def _lower(part: int, whole: int) -> float:
    """The lower end of the 95 % Wilson score interval of a share."""
    z = 1.959964
    share = part / whole
    middle, spread = share + z * z / (2 * whole), z * sqrt(share * (1 - share) / whole + z * z / (4 * whole * whole))
    return (middle - spread) / (1 + z * z / whole)
