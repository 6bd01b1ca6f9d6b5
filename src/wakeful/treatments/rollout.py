"""What if nothing is done: a rigid body's next seconds, rolled out in a physics engine. Does it tip over, and when?

An extra (`pip install 'wakeful[physics]'`, MuJoCo). To be called outside the kernel: ``mind.call(partial(tip_over, …), …)``.
"""

from __future__ import annotations

from math import acos, cos, degrees, radians, sin

from wakeful.contracts.treatment import Refusal
from wakeful.facts.values import Fact

STEP_S = 0.002
FALLEN_DEG = 60.0
"""Beyond this tilt a body counts as fallen."""


class RolloutError(Refusal):
    """MuJoCo is not installed, or the body is none. The message says which."""


class Body(Fact, frozen=True):
    """A box that stands on the floor: its sizes, mass, tilt about its lower edge, and how fast it turns."""

    width_m: float
    height_m: float
    mass_kg: float = 1.0
    tilt_deg: float = 0.0
    tilt_rate_dps: float = 0.0
    friction: float = 1.0


class Rollout(Fact, frozen=True):
    """What came of it. ``falls_in_s`` is None where it did not fall within ``seconds``."""

    seconds: float
    falls_in_s: float | None
    most_tilt_deg: float
    final_tilt_deg: float


def tip_over(body: Body, seconds: float = 1.5) -> Rollout:
    """Roll a body out from its tilt. Deterministic; about 10 ms for 1.5 s.

    Args:
        body: sizes above zero, a tilt of less than 90°.
        seconds: how far ahead, at most 10.

    Raises:
        RolloutError: MuJoCo is not installed, or the body cannot be.
    """
    if not (0.0 < body.width_m < 100.0 and 0.0 < body.height_m < 100.0 and 0.0 < body.mass_kg < 1e5):
        raise RolloutError(f"a body of {body.width_m} × {body.height_m} m and {body.mass_kg} kg cannot be rolled out")
    if not (
        abs(body.tilt_deg) < 90.0 and abs(body.tilt_rate_dps) < 3600.0 and 0.0 < seconds <= 10.0 and 0.0 <= body.friction < 10.0
    ):
        raise RolloutError(f"tilt {body.tilt_deg}°, {body.tilt_rate_dps}°/s over {seconds} s cannot be rolled out")
    try:
        import mujoco  # noqa: PLC0415
    except ImportError as error:
        raise RolloutError("rollouts need MuJoCo: pip install 'wakeful[physics]'") from error
    model = mujoco.MjModel.from_xml_string(_world(body))
    data = mujoco.MjData(model)
    data.qvel[4] = radians(body.tilt_rate_dps)
    falls: float | None = None
    most = tilt = abs(body.tilt_deg)
    for step in range(round(seconds / STEP_S)):
        mujoco.mj_step(model, data)
        tilt = degrees(acos(min(1.0, max(-1.0, float(data.xmat[1][8])))))
        most = max(most, tilt)
        if tilt >= FALLEN_DEG:
            falls = (step + 1) * STEP_S
            break
    return Rollout(
        seconds=seconds,
        falls_in_s=None if falls is None else round(falls, 3),
        most_tilt_deg=round(most, 2),
        final_tilt_deg=round(tilt, 2),
    )


def _world(body: Body) -> str:
    half_width, half_height, tilt = body.width_m / 2, body.height_m / 2, radians(body.tilt_deg)
    # its lowest corner touches the floor
    z = half_width * abs(sin(tilt)) + half_height * cos(tilt) + 1e-4
    friction = f'friction="{body.friction:.6g} .01 .001"'
    return (
        f'<mujoco><option timestep="{STEP_S}"/><worldbody><geom type="plane" size="50 50 .1" {friction}/>'
        f'<body pos="0 0 {z:.9g}" euler="0 {body.tilt_deg:.9g} 0"><freejoint/>'
        f'<geom type="box" size="{half_width:.9g} {half_width:.9g} {half_height:.9g}" mass="{body.mass_kg:.9g}" {friction}/>'
        "</body></worldbody></mujoco>"
    )
