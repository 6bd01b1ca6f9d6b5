"""The vehicle's health flags by name: which value is bad, which flight modes need it, and whom it concerns.

New firmware (1.14 on) writes `failsafe_flags`, true being bad; before, `vehicle_status_flags` wrote `…_valid`, true being good,
and `vehicle_status` the lost links. The names of the new one are used for all.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec


class FlagKind(msgspec.Struct, frozen=True):
    """What is known of one flag: whom it concerns, how bad it is (0 to 3), the mask of modes that need it, and in words."""

    entity: str
    criticality: int
    says: str
    needed_by: str = ""
    """The field of `failsafe_flags` whose bit n is set where nav_state n needs this; empty: it matters in every mode."""


KINDS: Mapping[str, FlagKind] = {
    "angular_velocity_invalid": FlagKind("estimator", 3, "angular velocity is not valid", "mode_req_angular_velocity"),
    "attitude_invalid": FlagKind("estimator", 3, "attitude is not valid", "mode_req_attitude"),
    "local_altitude_invalid": FlagKind("estimator", 2, "altitude is not valid", "mode_req_local_alt"),
    "local_position_invalid": FlagKind("estimator", 2, "local position is not valid", "mode_req_local_position"),
    "local_position_invalid_relaxed": FlagKind(
        "estimator", 2, "local position is not valid even loosely", "mode_req_local_position_relaxed"
    ),
    "local_velocity_invalid": FlagKind("estimator", 2, "local velocity is not valid", "mode_req_local_position"),
    "global_position_invalid": FlagKind("estimator", 2, "global position is not valid", "mode_req_global_position"),
    "local_position_accuracy_low": FlagKind("estimator", 2, "position accuracy is low"),
    "position_accuracy_low": FlagKind("estimator", 2, "position accuracy is low"),
    "dead_reckoning": FlagKind("estimator", 2, "position is dead reckoning"),
    "navigation_failure": FlagKind("estimator", 2, "navigation has failed"),
    "auto_mission_missing": FlagKind("mission", 1, "no mission is there", "mode_req_mission"),
    "mission_failure": FlagKind("mission", 2, "the mission has failed"),
    "offboard_control_signal_lost": FlagKind("offboard link", 2, "the offboard signal is lost", "mode_req_offboard_signal"),
    "home_position_invalid": FlagKind("mission", 1, "the home position is not set", "mode_req_home_position"),
    "manual_control_signal_lost": FlagKind("manual control link", 2, "manual control is lost", "mode_req_manual_control"),
    "gcs_connection_lost": FlagKind("ground station link", 1, "the ground station is lost"),
    "battery_warning": FlagKind("battery", 2, "battery warning"),
    "battery_low_remaining_time": FlagKind("battery", 3, "the battery just suffices to return"),
    "battery_unhealthy": FlagKind("battery", 2, "a battery is not healthy"),
    "geofence_breached": FlagKind("geofence", 3, "the geofence is breached"),
    "vtol_fixed_wing_system_failure": FlagKind("vtol transition", 3, "fixed-wing flight has failed"),
    "vtol_transition_failure": FlagKind("vtol transition", 3, "the transition has failed"),
    "wind_limit_exceeded": FlagKind("wind", 2, "wind is beyond its limit", "mode_req_wind_and_flight_time_compliance"),
    "flight_time_limit_exceeded": FlagKind("vehicle", 2, "flight time is up", "mode_req_wind_and_flight_time_compliance"),
    "fd_critical_failure": FlagKind("vehicle", 3, "the failure detector sees a critical failure (attitude or altitude)"),
    "fd_esc_arming_failure": FlagKind("motors", 3, "a speed controller did not arm"),
    "fd_imbalanced_prop": FlagKind("motors", 2, "a propeller is out of balance"),
    "fd_motor_failure": FlagKind("motors", 3, "a motor has failed"),
    "fd_roll": FlagKind("vehicle", 3, "roll is beyond its failure limit"),
    "fd_pitch": FlagKind("vehicle", 3, "pitch is beyond its failure limit"),
    "fd_alt": FlagKind("vehicle", 3, "altitude loss is beyond its failure limit"),
    "fd_ext": FlagKind("vehicle", 3, "an external failure trigger fired"),
    "fd_arm_escs": FlagKind("motors", 3, "a speed controller did not arm"),
    "fd_battery": FlagKind("battery", 3, "the failure detector sees a battery failure"),
    "fd_motor": FlagKind("motors", 3, "a motor has failed"),
    "engine_failure": FlagKind("motors", 3, "an engine has failed"),
    "escs_error": FlagKind("motors", 2, "speed controllers report an error"),
    "escs_failure": FlagKind("motors", 3, "speed controllers have failed"),
    "sensors_uninitialized": FlagKind("sensors", 2, "sensors are not set up"),
    "power_input_invalid": FlagKind("power", 2, "power input is not valid"),
    "flight_terminated": FlagKind("vehicle", 3, "flight is terminated"),
    "high_latency_data_link_lost": FlagKind("satellite link", 1, "the satellite link is lost"),
    "gps_position_invalid": FlagKind("gps", 1, "the GPS position is not valid", "mode_req_global_position"),
    "force_failsafe": FlagKind("vehicle", 3, "a failsafe is forced"),
    "lockdown": FlagKind("motors", 3, "the outputs are locked"),
    "manual_lockdown": FlagKind("motors", 3, "the kill switch is on"),
    "parachute_unhealthy": FlagKind("parachute", 2, "the parachute is not healthy"),
}

RENAMED: Mapping[str, str] = {
    "rc_signal_lost": "manual_control_signal_lost",
    "data_link_lost": "gcs_connection_lost",
    "system_sensors_initialized": "!sensors_uninitialized",
    "battery_healthy": "!battery_unhealthy",
    "power_input_valid": "!power_input_invalid",
    "fd_critical_failure": "fd_critical_failure",
}
"""Names of older firmware, ``!`` where true was good; a prefix ``condition_`` is taken off first."""

TOPICS = frozenset({"failsafe_flags", "vehicle_status_flags", "vehicle_status", "failure_detector_status", "actuator_armed"})
"""The topics that carry such flags."""

NEVER = frozenset({"circuit_breaker_flight_termination_disabled", "parachute_system_healthy", "avoidance_system_valid"})


def flag_name(field: str, topic: str) -> tuple[str, bool] | None:
    """The flag that a field carries, and the value of the field that is bad; None where the field is no health flag.

    >>> flag_name("condition_local_position_valid", "vehicle_status_flags"), flag_name("rc_signal_lost", "vehicle_status")
    (('local_position_invalid', False), ('manual_control_signal_lost', True))
    >>> flag_name("fd_motor", "failure_detector_status"), flag_name("nav_state", "vehicle_status")
    (('fd_motor', True), None)
    """
    if field in NEVER or topic not in TOPICS:
        return None
    bare = field.removeprefix("condition_")
    if renamed := RENAMED.get(bare):
        return (renamed.removeprefix("!"), not renamed.startswith("!"))
    if bare in KINDS:
        return bare, True
    if bare.endswith("_valid") and (negated := f"{bare.removesuffix('_valid')}_invalid") in KINDS:
        return negated, False
    unknown = ("_lost", "_failure", "_invalid", "_unhealthy", "_exceeded", "_breached", "_error")
    return (bare, True) if topic == "failsafe_flags" and bare.endswith(unknown) else None


def kind_of(name: str) -> FlagKind:
    """What is known of a flag; a flag that is new to this table is taken for notable."""
    return KINDS.get(name) or FlagKind("vehicle", 2, name.replace("_", " "))
