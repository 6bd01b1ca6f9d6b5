"""Jumps: a pose or transform that moves faster than anything can drive, and a GPS position that does."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, hypot, radians

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.frames import transforms_of, wrap
from wakeful.domains.mobile_base.messages import frame, message_type
from wakeful.domains.mobile_base.motion import Bases, reported
from wakeful.domains.plain import number, whole, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

_WORLDS = ("map", "odom", "world", "earth", "utm")
"""Frames in which a base turns about the vertical; elsewhere (a tilting sensor) a yaw may flip by itself."""

_LONGEST_S = 5.0
_QUIET_NS = to_ns(1.0)
_METRES_A_DEGREE = 111_320.0
_MOST = 500


class _Place(msgspec.Struct):
    at_ns: int
    x_m: float
    y_m: float
    yaw_rad: float | None
    usual_mps: float = 0.0
    usual_radps: float = 0.0
    count: int = 0
    jumped_ns: int | None = None


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    places: dict[str, _Place] = {}
    fixes: dict[str, Latch] = {}
    had_fix: dict[str, bool] = {}


class Jumps(Remembering[_Memory]):
    """A ``jump`` of a pose (Odometry, PoseWithCovarianceStamped) or transform: farther in one step than ``fastest_mps`` (2.5) or
    six times its usual speed allows, and 0.2 m more; or turned farther than 3 rad/s or six times the usual rate allows, and
    0.3 rad more. Odometry is measured by the speed it claims itself. ``gps_jump`` likewise above 30 m/s and 10 m, ``gps_lost``
    as a lasting condition once there was a fix. A jump shows the outcome ``fault``: what rests on the pose is wrong from then on.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._fastest_mps = number(spec.settings, "fastest_mps") or 2.5

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Compare each place in the observation with where it was."""
        self.memory.bases.see(observation)
        values, said = observation.values, reported(observation)
        match message_type(observation):
            case "Odometry" if said is not None and said.x_m is not None and said.y_m is not None:
                entity = f"{said.frame or 'odometry'}→{said.child or observation.topic}"
                claimed = 1.5 * hypot(said.forward_mps, said.sideways_mps)
                place = (said.x_m, said.y_m, said.yaw_rad)
                yield from self._step(observation, observation.topic, entity, observation.at_ns, place, claimed)
            case "PoseWithCovarianceStamped":
                x, y = number(values, "x"), number(values, "y")
                if x is not None and y is not None:
                    place = (x, y, number(values, "yaw"))
                    key = observation.topic
                    yield from self._step(observation, key, key, observation.at_ns, place, self._fastest_mps)
            case "TFMessage" | "tfMessage" if "static" not in observation.topic:
                for transform in transforms_of(observation):
                    parent, child = frame(transform, "parent"), frame(transform, "child")
                    x, y, at_s = number(transform, "x"), number(transform, "y"), number(transform, "at_s")
                    if x is None or y is None or not parent or not child:
                        continue
                    at_ns = observation.at_ns if at_s is None else to_ns(at_s)
                    yaw = number(transform, "yaw") if parent in _WORLDS else None
                    name = f"{parent}→{child}"
                    yield from self._step(observation, f"tf {name}", name, at_ns, (x, y, yaw), self._fastest_mps)
            case "NavSatFix":
                yield from self._satellites(observation)

    def _step(
        self,
        observation: Observation,
        key: str,
        entity: str,
        at_ns: int,
        place: tuple[float, float, float | None],
        fastest_mps: float,
    ) -> Iterator[Seen]:
        x_m, y_m, yaw_rad = place
        places = self.memory.places
        before = places.get(key)
        if before is None:
            if len(places) < _MOST:
                places[key] = _Place(at_ns, x_m, y_m, yaw_rad)
            return
        passed_s = to_s(at_ns - before.at_ns)
        moved_m = hypot(x_m - before.x_m, y_m - before.y_m)
        turned_rad = 0.0 if yaw_rad is None or before.yaw_rad is None else abs(wrap(yaw_rad - before.yaw_rad))
        if passed_s < 0.0 and moved_m == 0.0 and turned_rad == 0.0:
            return  # an old message once more
        before.at_ns, before.x_m, before.y_m, before.yaw_rad = at_ns, x_m, y_m, yaw_rad
        if not 0.0 <= passed_s <= _LONGEST_S:
            return
        learnt = before.count >= 20
        allowed_m = 0.2 + passed_s * max(fastest_mps, 6.0 * before.usual_mps if learnt else 0.0)
        allowed_rad = 0.3 + passed_s * max(3.0, 6.0 * before.usual_radps if learnt else 0.0)
        jumped = moved_m > allowed_m or turned_rad > allowed_rad
        if passed_s > 0.0 and not jumped:
            before.count = min(before.count + 1, 200)
            before.usual_mps += (moved_m / passed_s - before.usual_mps) / before.count
            before.usual_radps += (turned_rad / passed_s - before.usual_radps) / before.count
        if not jumped:
            return
        last_ns, before.jumped_ns = before.jumped_ns, observation.at_ns
        if last_ns is not None and 0 <= observation.at_ns - last_ns < _QUIET_NS:
            return
        yield from self._jump("jump", observation, entity, moved_m, turned_rad, passed_s)

    def _jump(
        self, kind: str, observation: Observation, entity: str, moved_m: float, turned_rad: float, passed_s: float
    ) -> Iterator[Seen]:
        motion = self.memory.bases.of(observation.topic)
        yield Shown(label="fault")
        yield Found(
            kind=kind,
            entity=entity,
            fields={
                **motion.fields(),
                "jump_m": within(moved_m, 0.0, 1000.0),
                "jump_rad": within(turned_rad, 0.0, 3.2),
                "severity": within(max(moved_m / 2.0, turned_rad), 0.3, 1.0),
            },
            says=(
                f"{entity} jumped by {moved_m:.2f} m and {turned_rad:.2f} rad in {passed_s:.3f} s, faster than the base can move"
                f" ({motion.says()}, {observation.topic})."
            ),
            criticality=3 if motion.moving else 2,
            deadline_s=2.0,
        )

    def _satellites(self, observation: Observation) -> Iterator[Seen]:
        values, topic = observation.values, observation.topic
        fix = whole(values, "fix")
        lost = fix is not None and fix < 0
        memory = self.memory
        memory.had_fix[topic] = memory.had_fix.get(topic, False) or (fix is not None and not lost)
        if memory.had_fix[topic] and fix is not None:
            phase = memory.fixes.setdefault(topic, Latch()).see(int(lost), observation.at_ns, to_ns(0.5), to_ns(2.0))
            if phase is not None:
                motion = memory.bases.of(topic)
                if phase is Phase.CLEARED:
                    yield Shown(label="recovered", entity=topic)
                yield Found(
                    kind="gps_lost",
                    entity=topic,
                    fields={**motion.fields(), "severity": 0.6},
                    says=f"GPS on {topic} {'has a fix again' if phase is Phase.CLEARED else 'lost its fix'} ({motion.says()}).",
                    criticality=2 if motion.moving else 1,
                    deadline_s=10.0,
                    phase=phase,
                    type="gps_lost",
                    references=(topic,),
                )
        latitude, longitude = number(values, "latitude"), number(values, "longitude")
        if lost or latitude is None or longitude is None or abs(latitude) > 90.0 or abs(longitude) > 180.0:
            return
        x_m, y_m = longitude * _METRES_A_DEGREE * cos(radians(latitude)), latitude * _METRES_A_DEGREE
        before = memory.places.get(topic)
        memory.places[topic] = _Place(observation.at_ns, x_m, y_m, None)
        if before is None or len(memory.places) > _MOST:
            return
        passed_s, moved_m = to_s(observation.at_ns - before.at_ns), hypot(x_m - before.x_m, y_m - before.y_m)
        if 0.0 <= passed_s <= _LONGEST_S and moved_m > 10.0 + 30.0 * passed_s:
            yield from self._jump("gps_jump", observation, topic, moved_m, 0.0, passed_s)
