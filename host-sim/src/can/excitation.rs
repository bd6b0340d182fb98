//! The excitations that an actuator generates (2020h): their names, and the settings that each
//! of them uses.

use canopen::Abort;
use firmware::parameters::ExcitationSettings;

use super::client::{Client, ClientError};
use super::names;
use super::sdo::SdoError;
use crate::error::Error;

/// An excitation; its place in [`SHAPES`] is its number in 2020h:3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Shape {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its name in full.
    pub label: &'static str,
    /// Sub-indices of 2020h of the settings that it uses besides the number of repetitions.
    pub uses: &'static [u8],
}

const fn shape(name: &'static str, label: &'static str, uses: &'static [u8]) -> Shape {
    Shape { name, label, uses }
}

/// All excitations, in the order of their numbers.
pub const SHAPES: [Shape; 10] = [
    shape("pulse", "A pulse", &[4, 8]),
    shape("doublet", "A doublet", &[4, 8]),
    shape("3211", "3-2-1-1", &[4, 8]),
    shape("variable-step", "Variable step of the paper", &[4, 8]),
    shape("ramp", "Up, down and back", &[4, 8, 9]),
    shape("chirp", "Linear chirp", &[4, 5, 6, 7]),
    shape("log-chirp", "Logarithmic chirp", &[4, 5, 6, 7]),
    shape("sine", "Sine", &[4, 5]),
    shape("prbs", "Pseudo-random binary sequence", &[4, 8, 10]),
    shape(
        "multisine",
        "Multisine: cosines at odd multiples of a frequency",
        &[4, 5, 11],
    ),
];

/// Sub-index of the number of repetitions.
pub const REPETITIONS: u8 = 12;

/// Starts the excitation of the present settings.
///
/// # Errors
/// [`ClientError::NotNow`] for one that the actuator refuses for its reach; those of the transfer.
pub fn start(client: &mut Client) -> Result<(), ClientError> {
    client.write("2020:1", "1").map_err(|error| match error {
        ClientError::Object {
            source: SdoError::Abort { code, .. },
            ..
        } if code == Abort::Incompatible.code() => ClientError::NotNow {
            node: client.node(),
            why: "the excitation would leave the position limits 607Dh, or its settings exclude \
                  each other; a smaller amplitude or another starting angle may be possible",
        },
        error => error,
    })
}

/// Settings from the values of sub-indices of 2020h; those that are not given have their defaults.
///
/// ```
/// use host_sim::can::excitation::settings;
/// let doublet = settings(&[(3, 1), (4, 2000)]).unwrap();
/// assert_eq!((doublet.shape, doublet.amplitude_mdeg), (1, 2000));
/// assert!(settings(&[(3, 10)]).unwrap_err().to_string().contains("0 to 9"));
/// ```
///
/// # Errors
/// For a sub-index that is no setting, and a value that is out of its range.
pub fn settings(values: &[(u8, i32)]) -> Result<ExcitationSettings, Error> {
    let mut settings = ExcitationSettings::DEFAULT;
    for (sub, value) in values {
        let object = format!("2020:{sub}");
        let row = names::find(&object)?;
        let limits = row.limits.as_ref();
        let limits: Option<(i32, i32)> =
            limits.and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
        if let Some((low, high)) = limits
            && !(low..=high).contains(value)
        {
            return Err(Error::Conflict(format!(
                "{} is {value}, expected {low} to {high} {}",
                names::name(row),
                row.unit
            )));
        }
        let place = match sub {
            3 => &mut settings.shape,
            4 => &mut settings.amplitude_mdeg,
            5 => &mut settings.start_mhz,
            6 => &mut settings.end_mhz,
            7 => &mut settings.duration_ms,
            8 => &mut settings.unit_ms,
            9 => &mut settings.rate_deg_s,
            10 => &mut settings.order,
            11 => &mut settings.lines,
            &REPETITIONS => &mut settings.repetitions,
            _ => {
                let problem = format!("{} is no setting of an excitation", names::name(row));
                return Err(Error::Conflict(problem));
            }
        };
        *place = *value;
    }
    Ok(settings)
}
