//! The parameters of the board's motor model, 2011h, from a fitted motor or servo.

use canopen_generator::Row;

use super::names;
use crate::{
    error::Error,
    scenario::Scenario,
    settings::{PlantKind, Settings},
};

/// An entry of 2011h, and its value in its unit.
pub type Object = (&'static Row, f64);

/// Each entry of 2011h that a fit determines, with its value in the unit of the entry. The
/// correction time 2011h:7 is no property of the motor and is not included.
///
/// ```
/// use host_sim::{can::motor_objects, settings::{ModelKind, PlantKind, Settings}};
///
/// let bench = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
/// let (resistance, ohm) = motor_objects::of(&bench)?[0];
/// assert_eq!((resistance.index, resistance.sub_index()), (0x2011, 1));
/// assert_eq!(ohm, 7.7);
/// assert!(motor_objects::of(&Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder)).is_err());
/// # Ok::<(), host_sim::error::Error>(())
/// ```
///
/// # Errors
/// [`Error::Conflict`] if the model has no motor.
pub fn of(settings: &Settings) -> Result<[Object; 6], Error> {
    let value = |name: &str| {
        let found = settings.values().find(|v| v.parameter.name == name);
        found.map_or(0.0, |v| v.value)
    };
    if settings.plant != PlantKind::Drivetrain {
        return Err(Error::Conflict(format!(
            "the parameters are those of {} with plant {}; the objects 2011h take those of a motor or servo, \
             which `identify --model motor-m1 --parameters FILE` writes, for one",
            settings.model, settings.plant
        )));
    }
    let ratio = value("gear_ratio");
    let pendulum = value("pendulum_mass_kg") * value("pendulum_length_m").powi(2);
    let inertia =
        value("motor_inertia_kg_m2") * ratio * ratio + value("load_inertia_kg_m2") + pendulum;
    // The board's model has friction M1 at a single location.
    let coulomb = value("coulomb_friction_nm") + value("bearing_friction_nm");
    let viscous = value("viscous_friction_nm_s_deg").to_degrees();
    Ok([
        (
            names::of_value("values.model.resistance_ohm")?,
            value("winding_resistance_ohm"),
        ),
        (
            names::of_value("values.model.torque_constant_nm_a")?,
            value("torque_constant_nm_a"),
        ),
        (names::of_value("values.model.gear_ratio")?, ratio),
        (names::of_value("values.model.inertia_kg_m2")?, inertia),
        (
            names::of_value("values.model.viscous_friction_nm_s")?,
            viscous,
        ),
        (
            names::of_value("values.model.coulomb_friction_nm")?,
            coulomb,
        ),
    ])
}

/// The parameters of which an object of [`of`] is computed, and which a fit may leave open.
const FITTED: [&str; 6] = [
    "winding_resistance_ohm",
    "torque_constant_nm_a",
    "gear_ratio",
    "motor_inertia_kg_m2",
    "viscous_friction_nm_s_deg",
    "coulomb_friction_nm",
];

/// The objects of [`of`] for a parameter file, each with whether its fit determines the value.
/// Values that were given to the fit count as determined: its results hold with them only.
///
/// # Errors
/// Those of [`of`] and of the scenario.
pub fn determined(scenario: &Scenario) -> Result<[(Object, bool); 6], Error> {
    let objects = of(&scenario.settings()?)?;
    let is_open = |name: &str| scenario.undetermined.iter().any(|open| open == name);
    Ok(std::array::from_fn(|i| (objects[i], !is_open(FITTED[i]))))
}

/// The part of the friction that the objects cannot represent, as a sentence; `None` if they
/// represent all of it.
pub fn omitted_friction(settings: &Settings) -> Option<String> {
    let mut values = settings.values();
    let friction = values.find(|v| v.parameter.name == "friction_model")?;
    (friction.value > 1.0).then(|| {
        format!(
            "friction M{}: the objects 2011h take its Coulomb and viscous part alone; \
             fit motor-m1 or servo-m1 for the best values of these two",
            friction.value
        )
    })
}
