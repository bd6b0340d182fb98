//! The files of the actuator's board.

use model_core::control::parameters::ControlParameters;
use model_core::parameter::Parameters;

use crate::parse::Declared;
use crate::{
    Device, Group, ParseError, Row, StorageLocation, eds, markdown, parse, storage, table,
};

/// The source.
const SOURCE: &str = include_str!("../../../firmware/object-dictionary.csv");

/// The groups of stored fields: path, type and content.
const GROUPS: [Group; 24] = [
    Group::new(
        StorageLocation::Parameters,
        "command",
        "CommandSettings",
        "Source of the commands, and how long a command is valid.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "servo",
        "ServoSettings",
        "Angle of a servo pulse.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "encoder",
        "EncoderLimits",
        "Protection: the encoder.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "current",
        "CurrentLimits",
        "Protection: the motor current.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "stall",
        "StallLimits",
        "Protection: stall.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "following",
        "FollowingLimits",
        "Protection: the following error.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "supply",
        "SupplyLimits",
        "Protection: the supply voltage.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "temperature",
        "TemperatureLimits",
        "Protection: the temperature.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "timing",
        "TimingLimits",
        "Protection: missed control periods and measurements.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "stop",
        "StopSettings",
        "Quick stop.",
    ),
    Group::new(
        StorageLocation::Parameters,
        "bus",
        "BusSettings",
        "The CAN bus.",
    ),
    Group::new(
        StorageLocation::Values,
        "model",
        "ModelSettings",
        "The motor model that runs beside the motor.",
    ),
    Group::new(
        StorageLocation::Values,
        "excitation",
        "ExcitationSettings",
        "The excitation that the board runs on request.",
    ),
    Group::new(
        StorageLocation::Values,
        "capture",
        "CaptureObjects",
        "Signals and trigger of a capture.",
    ),
    Group::new(
        StorageLocation::Values,
        "failsafe",
        "FailsafeSettings",
        "Reaction to the loss of the master.",
    ),
    Group::new(
        StorageLocation::Values,
        "profile",
        "ProfileSettings",
        "Settings of the drive profile CiA 402.",
    ),
    Group::new(
        StorageLocation::Values,
        "limits",
        "LimitSettings",
        "Limits of torque and current.",
    ),
    Group::new(
        StorageLocation::Values,
        "tracking",
        "TrackingSettings",
        "Feed-forward, and the dead band at rest.",
    ),
    Group::new(
        StorageLocation::Values,
        "encoder",
        "EncoderSettings",
        "The error of the encoder.",
    ),
    Group::new(
        StorageLocation::Values,
        "health",
        "HealthSettings",
        "Baseline of the health, and the levels of its warnings.",
    ),
    Group::new(
        StorageLocation::Values,
        "homing",
        "HomingSettings",
        "Homing, and the origin that it has found.",
    ),
    Group::new(
        StorageLocation::Values,
        "service",
        "ServiceSettings",
        "Access for service.",
    ),
    Group::new(
        StorageLocation::Values,
        "dronecan",
        "DronecanSettings",
        "Settings of the DroneCAN node.",
    ),
    Group::new(
        StorageLocation::Values,
        "servo_bus",
        "ServoBusSettings",
        "Settings of the servo bus.",
    ),
];

/// The entries of the board's object dictionary.
///
/// # Errors
///
/// The first line of the source that is wrong, and why.
pub fn rows() -> Result<Vec<Row>, ParseError> {
    parse(SOURCE, &control_parameter)
}

/// What `model-core` declares of a control parameter.
fn control_parameter(name: &str) -> Option<Declared> {
    let table = ControlParameters::TABLE.iter();
    let parameter = table.clone().find(|parameter| parameter.name == name)?;
    let is_bounded = parameter.min.is_finite() && parameter.max.is_finite();
    Some(Declared {
        default: parameter.default as f32,
        limits: is_bounded.then(|| (parameter.min.to_string(), parameter.max.to_string())),
        unit: parameter.unit.to_string(),
    })
}

/// The Rust source of the dictionary's table, and that of the storage behind it, which the build
/// script of the crate `firmware` writes.
///
/// # Errors
///
/// Those of [`rows`].
pub fn rust_sources() -> Result<[(&'static str, String); 2], ParseError> {
    let rows = rows()?;
    Ok([
        ("table.rs", table(&rows)),
        ("parameters.rs", storage(&GROUPS, &rows)),
    ])
}

/// Paths of the documents from the root of the repository, and their content.
///
/// # Errors
///
/// Those of [`rows`].
pub fn documents() -> Result<[(&'static str, String); 2], ParseError> {
    let rows = rows()?;
    let device = Device {
        file: "smart-actuator.eds".into(),
        description: "Smart RC-servo actuator: CiA 402 drive with capture and excitation".into(),
        vendor: "smart-actuator".into(),
        product: "SMART-ACTUATOR".into(),
        bit_rates: vec![125, 250, 500, 1000],
    };
    Ok([
        ("docs/smart-actuator.eds", eds(&device, &rows)),
        (
            "docs/object-dictionary.md",
            markdown("Object dictionary of the actuator", &rows),
        ),
    ])
}
