//! Models of servos as products: their tables, and the figures of their motors.
//!
//! All torques are those of the output shaft.

use std::f64::consts::PI;

use model_core::plant::drivetrain::DrivetrainParameters;
use model_core::plant::drivetrain::electrical::ElectricalParameters;
use model_core::plant::drivetrain::friction::FrictionParameters;
use model_core::plant::drivetrain::gear_train::GearTrainParameters;
use model_core::plant::drivetrain::load::LoadParameters;
use servo_bus::Table;
use servo_bus::tables::{STS3215, STS3250, XL330_M288, XM430_W350};

/// Which protocol and rules a table has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Feetech STS.
    Sts,
    /// Dynamixel X.
    X,
}

/// A servo as a product.
#[derive(Debug, Clone, Copy)]
pub struct Model {
    /// Its control table, whose name is that of the model.
    pub table: &'static Table,
    /// Protocol and rules.
    pub family: Family,
    /// Supply for which its figures hold, V.
    pub supply_v: f64,
    gear_ratio: f64,
    /// Torque per current and back-EMF per rate, Nm/A.
    constant_nm_a: f64,
    /// Of winding, brushes and bridge.
    pub resistance_ohm: f64,
    /// Of the rotor, behind the gears.
    inertia_kg_m2: f64,
    backlash_deg: f64,
    /// Duty of the position loop in that of the table's rule.
    pub loop_scale: f64,
    friction: Friction,
}

/// Friction of the gears in the terms of `FrictionParameters`, with rates in rad/s.
#[derive(Debug, Clone, Copy)]
struct Friction {
    model: f64,
    coulomb_nm: f64,
    viscous_nm_s: f64,
    stribeck_rad_s: f64,
    exponent: f64,
    of_motor: f64,
    of_load: f64,
    of_motor_at_rest: f64,
    of_load_at_rest: f64,
}

/// Without load-dependent terms.
const NO_FRICTION: Friction = Friction {
    model: 1.0,
    coulomb_nm: 0.0,
    viscous_nm_s: 0.0,
    stribeck_rad_s: 0.2,
    exponent: 1.35,
    of_motor: 0.0,
    of_load: 0.0,
    of_motor_at_rest: 0.0,
    of_load_at_rest: 0.0,
};

/// 7.4 V, ratio 1:345. Motor and friction: `params/feetech_sts3215_7_4V/m6.json` of
/// github.com/Rhoban/bam, without its quadratic terms, which are below 1 % at the stall torque.
/// Backlash: measured, issue 134 of github.com/TheRobotStudio/SO-ARM100; the catalogue has 0.5 deg.
const STS3215_MODEL: Model = Model {
    table: &STS3215,
    family: Family::Sts,
    supply_v: 7.4,
    gear_ratio: 345.0,
    constant_nm_a: 1.2753,
    resistance_ohm: 2.7534,
    inertia_kg_m2: 0.02156,
    backlash_deg: 1.0,
    // 0.166 x 1.1617 per rad and unit of P, of 0.025 %/step x 651.9 steps/rad.
    loop_scale: 1.183,
    friction: Friction {
        model: 5.0,
        coulomb_nm: 0.0533,
        viscous_nm_s: 0.02816,
        stribeck_rad_s: 0.3711,
        exponent: 9.93,
        of_motor: 0.0449,
        of_load: 0.2436,
        of_motor_at_rest: 0.0,
        of_load_at_rest: 0.1423,
    },
};

/// 12 V, ratio 1:345. Constant and resistance are chosen for the catalogue's 0.133 s/60 deg and 50
/// kg cm at 12 V, which has no current; inertia, friction and scale of the loop are fitted to two
/// recordings of a pendulum of github.com/Rhoban/bam (`data_raw_feetech`), which they explain to
/// 97.7 % and 99.1 % without backlash. Backlash: as the STS3215's.
const STS3250_MODEL: Model = Model {
    table: &STS3250,
    family: Family::Sts,
    supply_v: 12.0,
    gear_ratio: 345.0,
    constant_nm_a: 1.45,
    resistance_ohm: 3.2,
    inertia_kg_m2: 0.0029,
    backlash_deg: 1.0,
    loop_scale: 1.374,
    friction: Friction {
        coulomb_nm: 0.258,
        viscous_nm_s: 0.0052,
        ..NO_FRICTION
    },
};

/// 5 V. Constant and resistance from the catalogue: 103 rev/min and 1.47 A at 5 V; inertia,
/// friction and scale of the loop are fitted to two recordings of a pendulum of
/// github.com/Rhoban/bam, which they explain to 90.5 % and 93.3 %. With that friction the torque at
/// stall is 0.38 Nm, where the catalogue has 0.52 Nm. Backlash: not published, that of the XM430.
const XL330_MODEL: Model = Model {
    table: &XL330_M288,
    family: Family::X,
    supply_v: 5.0,
    gear_ratio: 288.35,
    constant_nm_a: 0.45,
    resistance_ohm: 3.4,
    inertia_kg_m2: 0.003,
    backlash_deg: 0.25,
    loop_scale: 0.458,
    friction: Friction {
        model: 3.0,
        coulomb_nm: 0.002,
        of_motor: 0.266,
        of_load: 0.266,
        ..NO_FRICTION
    },
};

/// 12 V. From the catalogue at 12 V: 4.1 Nm at 2.3 A and 46 rev/min. The resistance is 12 V/2.3 A.
/// The friction per torque `k` makes the torque at stall, `k2 = 2.4 Nm/A x 2.3 A = 5.52 Nm`, that
/// of the catalogue: `(5.52 - 0.05 - 5.52 k)/(1 + k) = 4.1`; the viscous friction makes the rate
/// without a load so. Coulomb friction, inertia (25 ms with the back-EMF) and the constant within 4
/// % are assumptions.
const XM430_MODEL: Model = Model {
    table: &XM430_W350,
    family: Family::X,
    supply_v: 12.0,
    gear_ratio: 353.5,
    constant_nm_a: 2.4,
    resistance_ohm: 5.217,
    inertia_kg_m2: 0.0276,
    backlash_deg: 0.25,
    loop_scale: 1.0,
    friction: Friction {
        model: 3.0,
        coulomb_nm: 0.05,
        viscous_nm_s: 0.0256,
        of_motor: 0.142,
        of_load: 0.142,
        ..NO_FRICTION
    },
};

const MODELS: [Model; 4] = [STS3215_MODEL, STS3250_MODEL, XL330_MODEL, XM430_MODEL];

/// The names of all models.
pub const NAMES: [&str; 4] = ["sts3215", "sts3250", "xl330-m288", "xm430-w350"];

/// The model with this name.
pub fn model(name: &str) -> Option<Model> {
    MODELS.into_iter().find(|model| model.table.name == name)
}

impl Model {
    /// Current of one in the table, A.
    pub fn current_unit_a(&self) -> f64 {
        f64::from(self.table.current_ua) * 1e-6
    }

    /// Parameters of its drivetrain with this load at the horn.
    pub fn drivetrain(&self, load: LoadParameters) -> DrivetrainParameters {
        let (ratio, friction) = (self.gear_ratio, &self.friction);
        DrivetrainParameters {
            electrical: ElectricalParameters {
                supply_v: self.supply_v,
                winding_resistance_ohm: self.resistance_ohm,
                // The current follows within a period: 0.1 ms.
                winding_inductance_h: 1e-4 * self.resistance_ohm,
                torque_constant_nm_a: self.constant_nm_a / ratio,
                ..Default::default()
            },
            gear_train: GearTrainParameters {
                gear_ratio: ratio,
                motor_inertia_kg_m2: self.inertia_kg_m2 / (ratio * ratio),
                // A horn and a bracket.
                output_inertia_kg_m2: 5e-6,
                load_inertia_kg_m2: 5e-6,
                backlash_deg: self.backlash_deg,
                shaft_stiffness_nm_deg: f64::INFINITY,
                // Without stops.
                hard_stop_deg: 32_000.0,
                ..Default::default()
            },
            friction: FrictionParameters {
                friction_model: friction.model,
                coulomb_friction_nm: friction.coulomb_nm,
                viscous_friction_nm_s_deg: friction.viscous_nm_s * (PI / 180.0),
                stribeck_friction_nm: 0.0,
                stribeck_rate_deg_s: friction.stribeck_rad_s * (180.0 / PI),
                stribeck_exponent: friction.exponent,
                load_friction_motor: friction.of_motor,
                load_friction_external: friction.of_load,
                load_stribeck_motor: friction.of_motor_at_rest,
                load_stribeck_external: friction.of_load_at_rest,
                ..Default::default()
            },
            load,
        }
    }
}
