"""The names of all parameters; written by ``smart_actuator._parameter_names``."""

from typing import TypedDict


class ModelParameters(TypedDict, total=False):
    """Every parameter of every model, by name and by symbol.

    A parameter that the model does not have raises a ``KeyError``.
    """

    delay_s: float
    host_period_s: float
    position_gain: float
    P: float
    proportional_gain: float
    Kp: float
    integral_gain: float
    Ki: float
    anti_windup_gain: float
    Kaw: float
    feed_forward_gain: float
    Kff: float
    rate_filter: float
    alpha: float
    position_min_deg: float
    position_max_deg: float
    rate_command_limit_up_deg_s: float
    rcmd_up: float
    rate_command_limit_down_deg_s: float
    rcmd_dn: float
    duty_limit_pct: float
    umax: float
    duty_slew_pct_s: float
    encoder_zero_deg: float
    encoder_direction: float
    timer_counts: float
    magnet_zero_deg: float
    magnet_direction: float
    encoder_noise_deg: float
    misalignment_first_deg: float
    misalignment_first_phase_deg: float
    misalignment_second_deg: float
    misalignment_second_phase_deg: float
    motor_gain_up: float
    Kup: float
    motor_gain_down: float
    Kdn: float
    motor_time_constant_s: float
    tau: float
    rate_limit_up_deg_s: float
    rup: float
    rate_limit_down_deg_s: float
    rdn: float
    position_limit_deg: float
    pos: float
    supply_v: float
    winding_resistance_ohm: float
    winding_inductance_h: float
    torque_constant_nm_a: float
    diode_drop_v: float
    coast_when_off: float
    gear_ratio: float
    motor_inertia_kg_m2: float
    output_inertia_kg_m2: float
    load_inertia_kg_m2: float
    backlash_deg: float
    gear_stiffness_nm_deg: float
    gear_damping_nm_s_deg: float
    shaft_stiffness_nm_deg: float
    shaft_damping_nm_s_deg: float
    bearing_friction_nm: float
    hard_stop_deg: float
    friction_model: float
    coulomb_friction_nm: float
    viscous_friction_nm_s_deg: float
    stribeck_friction_nm: float
    stribeck_rate_deg_s: float
    stribeck_exponent: float
    load_friction_motor: float
    load_friction_external: float
    load_stribeck_motor: float
    load_stribeck_external: float
    load_quadratic_motor_1_nm: float
    load_quadratic_external_1_nm: float
    load_torque_nm: float
    hinge_moment_nm_deg: float
    load_damping_nm_s_deg: float
    pendulum_mass_kg: float
    pendulum_length_m: float
    current_gain_v_a: float
    current_offset_v: float
    current_gain_error: float
    current_offset_error_v: float
    current_noise_v: float
    back_emf_gain: float
    back_emf_offset_v: float
    back_emf_gain_error: float
    back_emf_offset_error_v: float
    back_emf_noise_v: float
    rate_anti_windup_gain: float
    Kawr: float
    pole_rad_s: float
    p: float
    gain: float
    offset_deg: float
    position_gain_per_s2: float
    A: float
    rate_gain_per_s: float
    B: float
    rate_limit_form: float
    bb2_sat: float
