"""PX4's events by number: a log carries only numbers, and each is a hash of the event's name, the same in every firmware.

The names are PX4's own identifiers (`events::ID("…")` in its sources). Words are made of the name where no text is known.
"""

from __future__ import annotations

from collections.abc import Mapping

CHECKS = """
accel_missing accel_no_data accel_not_calibrated airspeed_invalid airspeed_no_data airspeed_too_high avionics_power_high
avionics_power_low avionics_power_missing avionics_power_redundancy baro_missing baro_no_data battery_disconnected battery_fault
battery_low battery_mode battery_rem_flight_time_low battery_unhealthy cpuload_too_high distance_sensor_invalid
distance_sensor_missing escs_fault escs_offline escs_telem_missing estimator_gnss_fault estimator_gps_fix_too_low
estimator_gps_generic estimator_gps_hor_pos_drift_too_high estimator_gps_hor_pos_err_too_high
estimator_gps_hor_speed_drift_too_high estimator_gps_jamming_critical estimator_gps_multiple_spoofing_indicated
estimator_gps_not_fusing estimator_gps_num_sats_too_low estimator_gps_pdop_too_high estimator_gps_speed_acc_too_low
estimator_gps_spoofing_indicated estimator_gps_vert_pos_drift_too_high estimator_gps_vert_pos_err_too_high
estimator_gps_vert_speed_drift_too_high estimator_heading_not_stable estimator_hgt_est_err estimator_hgt_not_stable
estimator_high_accel_bias estimator_high_gyro_bias estimator_hor_vel_not_stable estimator_mag_fault estimator_mag_interference
estimator_missing_data estimator_nav_failure estimator_pos_est_err estimator_vel_est_err estimator_vert_vel_not_stable
estimator_yaw_est_err failure_detector_alt failure_detector_arm_esc failure_detector_ext failure_detector_imbalanced_prop
failure_detector_motor failure_detector_pitch failure_detector_roll flight_time_limit gf_no_home gf_violation gyro_missing
gyro_no_data gyro_not_calibrated hardfault_present imu_accel_inconsistent imu_gyro_inconsistent mag_consistency mag_fault
mag_missing mag_no_data mag_not_calibrated mag_sys_has_mag_missing man_control_kill_engaged man_control_landing_gear_up
man_control_rtl_engaged missing_cpuload missing_fmu_sdcard missing_system_power mission_failure modes_angular_velocity
modes_attitude modes_cannot_takeoff modes_global_pos modes_global_pos_relaxed modes_home_position modes_local_alt
modes_local_pos modes_manual_control modes_mission modes_offboard_signal parachute_missing parachute_unhealthy
rc_calib_in_progress rc_dl_no_dllink rc_dz_too_high rc_max_too_high rc_min_too_small rc_trim_too_high rc_trim_too_small
system_arm_auth_failed system_avoidance_not_ready system_flight_term_active system_no_global_pos system_no_home_pos
system_safety_button system_usb_connected system_vtol_in_fw_mode system_vtol_in_transition vtol_fixed_wing_system_failure
wind_too_high
"""
"""Preflight and health checks, without the `check_` that each begins with."""

OTHERS = """
airspeed_selector_estimation_invalid airspeed_selector_sensor_failure airspeed_selector_switch check_high_wind_warning
check_estimator_gnss_fusion_stopped check_estimator_low_position_accuracy commander_arm_denied_not_manual
commander_arm_denied_throttle_center commander_arm_denied_throttle_high commander_dl_regained
commander_failsafe_enter commander_failsafe_enter_crit_bat_warn commander_failsafe_enter_crit_low_bat_warn
commander_failsafe_enter_generic commander_failsafe_enter_generic_hold commander_failsafe_enter_generic_warn
commander_failsafe_enter_hold commander_failsafe_enter_low_bat commander_failsafe_enter_warn commander_gcs_lost
commander_high_latency_lost commander_kill_sw_disengaged commander_kill_sw_engaged commander_low_bat_shutdown
commander_max_flight_time_warning_minutes commander_max_flight_time_warning_seconds commander_mission_comp_lost
commander_mission_start_denied_no_mission commander_modeswitch_not_avail commander_rc_lost commander_rc_override
commander_rc_regained commander_transition_denied failsafe_rc_override
fixedwing_position_control_landing_abort_status_terrain_timeout logger_storage_full mission_cannot_read_mission
mission_failed_to_read_wp mission_not_valid_loiter mission_not_valid_refuse navigator_geofence_max_alt_from_home
navigator_geofence_max_dist_from_home navigator_mis_geofence_violation navigator_mission_failure_heading
navigator_reposition_outside_geofence navigator_traffic navigator_traffic_hold navigator_traffic_land navigator_traffic_rtl
px4io_comm_failed sensor_failover sensor_failover_baro sensor_failover_mag vehicle_imu_accel_clipping vehicle_imu_gyro_clipping
vtol_att_ctrl_quadchute_alt_loss vtol_att_ctrl_quadchute_ext_cmd vtol_att_ctrl_quadchute_max_pitch
vtol_att_ctrl_quadchute_max_roll vtol_att_ctrl_quadchute_min_alt vtol_att_ctrl_quadchute_tout
vtol_att_ctrl_quadchute_trans_alt_err
"""
"""Other events that are warnings or worse."""

REPORT_BEGINS = "commander_arming_check_summary"
REPORT_ENDS = "commander_health_summary"

COMPONENTS = (
    "vehicle",
    "barometer",
    "airspeed sensor",
    "gps",
    "optical flow",
    "vision position",
    "distance sensor",
    "remote control",
    "motors",
    "traffic management",
    "logger",
    "battery",
    "communication links",
    "rate controller",
    "attitude controller",
    "position controller",
    "attitude estimate",
    "local position estimate",
    "mission",
    "avoidance",
    "system",
    "camera",
    "gimbal",
    "payload",
    "global position estimate",
    "storage",
    "parachute",
    "magnetometer",
    "accelerometer",
    "gyroscope",
    "open drone id",
)
"""Health components in the order of their bits: whom a check concerns."""


def event_number(name: str) -> int:
    """The number of an event within its component: the low 24 bits of the name's 32-bit FNV-1a hash.

    >>> event_number("commander_takeoff_detected")
    4277609
    """
    value = 0x811C9DC5
    for byte in name.encode():
        value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return value & 0xFFFFFF


NAMES: Mapping[int, str] = {
    event_number(name): name
    for name in (*(f"check_{name}" for name in CHECKS.split()), *OTHERS.split(), REPORT_BEGINS, REPORT_ENDS)
}
"""Event number → name."""


def event_name(number: int) -> str:
    """The name of an event by its id as logged (the component in the top 8 bits); empty where it is not known."""
    return NAMES.get(number & 0xFFFFFF, "")


def in_words(name: str) -> str:
    """An event's name as words.

    >>> in_words("check_estimator_gps_fix_too_low")
    'estimator gps fix too low'
    """
    return name.removeprefix("check_").replace("_", " ")
