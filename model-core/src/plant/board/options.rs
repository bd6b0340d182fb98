//! What a plant is made of.

use crate::plant::drivetrain::DrivetrainParameters;
use crate::sensors::adc::CurrentSenseParameters;
use crate::sensors::encoder::EncoderParameters;
use crate::sensors::noise::Noise;

use super::{HeatParameters, SupplyParameters};

/// The parts of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardPlantOptions {
    /// Motor, gear train, friction, load.
    pub drivetrain: DrivetrainParameters,
    /// The encoder's mounting and errors.
    pub encoder: EncoderParameters,
    /// The current's front end.
    pub current: CurrentSenseParameters,
    /// Noise of the other converter channels at their pins, rms, V.
    pub pin_noise_v: f64,
    /// The source.
    pub supply: SupplyParameters,
    /// The heat of the motor.
    pub heat: HeatParameters,
    /// Temperature of the board, deg C.
    pub ambient_deg_c: f64,
    /// Decides every draw.
    pub seed: u64,
}

impl Default for BoardPlantOptions {
    fn default() -> Self {
        Self {
            drivetrain: DrivetrainParameters::default(),
            encoder: EncoderParameters::default(),
            current: CurrentSenseParameters::default(),
            pin_noise_v: 0.0,
            supply: SupplyParameters::default(),
            heat: HeatParameters::default(),
            ambient_deg_c: 25.0,
            seed: 0,
        }
    }
}

impl BoardPlantOptions {
    /// A plant as one finds it: noise everywhere, a crooked magnet, a source that gives way, and
    /// friction that differs from its estimate by up to a third, all of it by the seed; and a
    /// winding of copper.
    ///
    /// ```
    /// use model_core::plant::board::{BoardPlant, BoardPlantOptions};
    ///
    /// let (a, b) = (BoardPlantOptions::realistic(1), BoardPlantOptions::realistic(2));
    /// assert_ne!(a.drivetrain.friction.coulomb_friction_nm, b.drivetrain.friction.coulomb_friction_nm);
    /// assert!(BoardPlant::try_new(&a).is_ok());
    /// ```
    pub fn realistic(seed: u64) -> Self {
        let mut chance = Noise::new(seed, u64::MAX);
        // Three standard deviations are a third.
        let mut spread = || 1.0 + chance.gaussian(1.0 / 9.0).clamp(-1.0 / 3.0, 1.0 / 3.0);
        let mut options = Self {
            seed,
            pin_noise_v: 1e-3,
            ..Self::default()
        };
        let friction = &mut options.drivetrain.friction;
        friction.coulomb_friction_nm *= spread();
        friction.viscous_friction_nm_s_deg *= spread();
        options.drivetrain.gear_train.bearing_friction_nm *= spread();
        options.encoder.encoder_noise_deg = 0.03;
        options.encoder.misalignment_first_deg = 0.5 * spread();
        options.current.current_noise_v = 2e-3;
        options.current.current_gain_error = 0.02 * (spread() - 1.0);
        options.supply.source_resistance_ohm = 0.1 * spread();
        options.supply.ripple_v = 0.02;
        options.heat.copper_per_k = 0.0039;
        options
    }

    /// As [`Self::realistic`], with another small servo: its motor, gears and source differ from
    /// the defaults by up to a third, gear ratio and supply by less, as the plausibility checks of
    /// the motor and the range of the supply permit; the play is up to 0.5 deg, and the magnet is
    /// eccentric in any direction.
    ///
    /// ```
    /// use model_core::plant::board::BoardPlantOptions;
    ///
    /// let options = BoardPlantOptions::another_servo(1);
    /// let default = BoardPlantOptions::default().drivetrain.electrical;
    /// assert_ne!(options.drivetrain.electrical, default);
    /// ```
    pub fn another_servo(seed: u64) -> Self {
        let mut options = Self::realistic(seed);
        let mut chance = Noise::new(seed, 41);
        let mut uneven = || chance.gaussian(0.15).clamp(-0.33, 0.33);
        let motor = &mut options.drivetrain.electrical;
        motor.torque_constant_nm_a *= 1.0 + uneven();
        motor.winding_resistance_ohm *= 1.0 + uneven();
        motor.winding_inductance_h *= 1.0 + uneven();
        // 4.9 V to 7.4 V.
        motor.supply_v = 6.15 * (1.0 + uneven().clamp(-0.2, 0.2));
        options.supply.source_resistance_ohm *= 1.0 + uneven();
        let gears = &mut options.drivetrain.gear_train;
        gears.gear_ratio *= 1.0 + uneven() / 3.0;
        gears.motor_inertia_kg_m2 *= 1.0 + uneven();
        gears.gear_stiffness_nm_deg *= 1.0 + uneven();
        gears.backlash_deg *= 1.0 + 2.0 * (1.0 + uneven() / 0.33);
        options.encoder.misalignment_first_phase_deg = chance.gaussian(1e3) % 360.0;
        options
    }
}
