"""Obstacles on the way: how near they are in the direction of motion, and how soon the base would touch them."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, cos, pi, sin

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.frames import Frames, wrap
from wakeful.domains.mobile_base.messages import frame, message_type
from wakeful.domains.mobile_base.motion import MOVING_MPS, Bases, Motion
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

_WINDOW_NS = to_ns(1.0)
_CLOSING_SHARE = 0.3
"""Of the speed, as much as the distance must shrink by for something to count as approached."""
_SHALLOWEST = 0.2
"""Cosine of the widest angle to the path (78°) at which something still lies ahead."""
_SECTORS = ((0.0, "front"), (pi / 2, "left"), (-pi / 2, "right"), (pi, "back"))
_SIDES = {"front": "front obstacle", "left": "left obstacle", "right": "right obstacle", "back": "rear obstacle"}


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    frames: Frames = msgspec.field(default_factory=Frames)
    latches: dict[str, Latch] = {}
    seen: dict[str, list[tuple[int, float]]] = {}
    """Of each side the (instant, distance in metres) of the last second."""


class Obstacles(Remembering[_Memory]):
    """A lasting condition for each side of the base: front, left, right, rear as the base sees it, not as a scanner is mounted.

    Level 1: contact within ``soon_s`` (3.0) at the present speed, or nearer than ``near_m`` (0.4) while moving towards it;
    level 2: within a third of that time. Only what lies within ``half_width_m`` (0.45) of the path counts, and only speed
    towards it. Scans (nearest return of a sector, with its bearing) and single rangers alike. At rest nothing approaches.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._soon_s = number(spec.settings, "soon_s") or 3.0
        self._near_m = number(spec.settings, "near_m") or 0.4
        self._half_width_m = number(spec.settings, "half_width_m") or 0.45

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Take up odometry and transforms; look at scans and ranges."""
        memory = self.memory
        memory.bases.see(observation)
        memory.frames.see(observation)
        kind = message_type(observation)
        if kind not in ("LaserScan", "Range"):
            return
        motion = memory.bases.of(observation.topic)
        if not memory.bases.fresh(motion):
            return
        mounted = memory.frames.yaw(frame(observation.values), motion.child)
        returns = _returns(observation, mounted, kind)
        path = atan2(motion.sideways_mps, motion.forward_mps)
        for side in _SIDES:
            yield from self._side(observation, motion, side, path, returns)

    def _side(
        self, observation: Observation, motion: Motion, side: str, path_rad: float, returns: list[tuple[float, float]]
    ) -> Iterator[Seen]:
        memory, moving = self.memory, motion.moving and motion.speed_mps >= MOVING_MPS
        entity = _SIDES[side]
        key = f"{observation.topic} {side}"
        nearest = self._ahead(path_rad, returns) if moving and _side_of(path_rad) == side else None
        latch = memory.latches.get(key)
        if nearest is None and latch is None:
            return
        latch = memory.latches.setdefault(key, Latch())
        seen = [one for one in memory.seen.get(key, []) if 0 <= observation.at_ns - one[0] <= _WINDOW_NS][-50:]
        level, closing_mps = 0, 0.0
        if nearest is not None:
            if seen and observation.at_ns > seen[0][0]:
                closing_mps = (seen[0][1] - nearest) / to_s(observation.at_ns - seen[0][0])
            seen.append((observation.at_ns, nearest))
            ttc_s = nearest / motion.speed_mps
            level = 2 if ttc_s <= self._soon_s / 3 else 1 if ttc_s <= self._soon_s or nearest <= self._near_m else 0
            # what keeps its distance while the base drives is a part of it, or drives ahead
            if latch.level == 0 and closing_mps < _CLOSING_SHARE * motion.speed_mps:
                level = 0
        memory.seen[key] = seen
        distance_m = seen[-1][1] if seen else 0.0
        ttc_s = distance_m / max(motion.speed_mps, MOVING_MPS)
        phase = latch.see(level, observation.at_ns, to_ns(0.2), to_ns(1.0))
        if phase is None:
            return
        over = phase is Phase.CLEARED
        if over:
            yield Shown(label="recovered", entity=entity)
        yield Found(
            kind="obstacle",
            entity=entity,
            fields={
                **motion.fields(),
                "distance_m": within(distance_m, 0.0, 100.0),
                "closing_mps": 0.0 if over else within(max(closing_mps, motion.speed_mps), 0.0, 20.0),
                "ttc_s": None if over else within(ttc_s, 0.0, 100.0),
                "side": side,
                "severity": 0.4 * latch.level,
            },
            says=(
                f"Nothing approaches at the {side} any more ({motion.says()})."
                if over
                else f"Something {distance_m:.2f} m away at the {side}, by {observation.topic}: contact in {ttc_s:.1f} s"
                f" ({motion.says()})."
            ),
            criticality=3 if latch.level >= 2 else 2,
            deadline_s=1.0 if latch.level >= 2 else 3.0,
            phase=phase,
            type="obstacle",
            references=(observation.topic, side),
        )

    def _ahead(self, path_rad: float, returns: list[tuple[float, float]]) -> float | None:
        """The distance along the path to the nearest return that lies on it."""
        found = []
        for distance_m, bearing_rad in returns:
            ahead, beside = distance_m * cos(bearing_rad - path_rad), distance_m * sin(bearing_rad - path_rad)
            if ahead > _SHALLOWEST * distance_m and abs(beside) <= self._half_width_m:
                found.append(ahead)
        return min(found, default=None)


def _returns(observation: Observation, mounted_rad: float, kind: str) -> list[tuple[float, float]]:
    """What a sensor sees: (distance in metres, bearing from the base's front in radians) of each sector's nearest return."""
    values = observation.values
    if kind == "Range":
        distance, longest = number(values, "range"), number(values, "max_range")
        far = longest is not None and distance is not None and distance >= longest
        return [] if distance is None or distance <= 0.0 or far else [(distance, mounted_rad)]
    found = []
    for middle_rad, sector in _SECTORS:
        distance = number(values, sector)
        if distance is not None and distance > 0.0:
            bearing = number(values, f"{sector}_bearing")
            found.append((distance, wrap((middle_rad if bearing is None else bearing) + mounted_rad)))
    return found


def _side_of(bearing_rad: float) -> str:
    turned = wrap(bearing_rad)
    if abs(turned) <= pi / 4:
        return "front"
    if abs(turned) >= 3 * pi / 4:
        return "back"
    return "left" if turned > 0 else "right"
