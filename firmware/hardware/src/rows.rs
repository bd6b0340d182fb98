//! The rows of the CSV files.

use serde::Deserialize;

/// A part of `parts.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Part {
    /// `actuator` or `comm`.
    pub board: String,
    /// Block of the schematic.
    pub group: String,
    /// Name on the board, as R10.
    pub designator: String,
    /// Key of `pins.csv`, `figures.csv` and `data_sheets.csv`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Resistance, capacitance or rated current.
    pub value: Option<f64>,
    /// Unit of the value: ohm, F or A.
    pub unit: String,
    /// Tolerance of the value, percent.
    pub tolerance_pct: Option<f64>,
    /// Rated voltage or power; of a processor board the pin that feeds it.
    pub rating: String,
    /// Designator of the part that a capacitor decouples.
    pub at: String,
    /// Manufacturer.
    pub maker: String,
    /// Part number for an order.
    pub part_number: String,
    /// Package.
    pub package: String,
    /// What it is for.
    pub purpose: String,
}

/// Electrical type of a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Electrical {
    /// Neither drives nor needs anything: resistors, connectors.
    Passive,
    /// Supply input, with a range.
    Power,
    /// Supply output, with a range.
    Supply,
    /// Ground.
    Ground,
    /// Logic input, with its thresholds as range.
    Input,
    /// Analogue input.
    #[serde(rename = "analog input")]
    AnalogInput,
    /// Push-pull or analogue output.
    Output,
    /// Open-drain output.
    #[serde(rename = "open drain")]
    OpenDrain,
    /// Line of the CAN bus.
    Bus,
    /// Configuration input, tied to a given net.
    Strap,
    /// Gate of a transistor.
    Gate,
    /// Source of a transistor.
    Source,
    /// Drain of a transistor.
    Drain,
    /// May or must stay open.
    Open,
}

/// A pin of a part's type, of `pins.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Pin {
    /// Type of the part.
    #[serde(rename = "type")]
    pub kind: String,
    /// Number of the pin.
    pub pin: String,
    /// Its name in the data sheet.
    pub name: String,
    /// What it does.
    pub electrical: Electrical,
    /// Least supply, or highest level that reads low, V.
    pub min_v: Option<f64>,
    /// Greatest supply, or lowest level that reads high, V.
    pub max_v: Option<f64>,
    /// Absolute maximum rating, V.
    pub absolute_v: Option<f64>,
    /// Net that a configuration input is tied to.
    pub tie: String,
}

/// A figure of a data sheet or of the actuator, of `figures.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Figure {
    /// The part's type, or what else it is a figure of.
    pub of: String,
    /// Its name.
    pub figure: String,
    /// In the unit that the file states.
    pub value: f64,
}

/// Voltages of a net that no part on the board determines, of `rails.csv`: numbers, or names of
/// limits.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Rail {
    pub board: String,
    pub net: String,
    pub low_v: String,
    pub high_v: String,
    pub surge_v: String,
}

/// A row of `nets.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct NetRow {
    pub board: String,
    pub net: String,
    pub pins: String,
}

/// A pin of the processor that a program uses, of `processor.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ProcessorPin {
    /// `actuator` or `comm`.
    pub board: String,
    /// Function in words.
    pub function: String,
    /// Name of constants.
    pub name: String,
    /// Port and number, as PE9.
    pub pin: String,
    /// Signal of the peripheral, or `output`.
    pub peripheral: String,
    /// Number of the alternate function.
    pub alternate: Option<u8>,
    /// `output`, `alternate`, `open drain` or `analog`.
    pub mode: String,
    /// `in`, `out` or `both`.
    pub direction: String,
    /// Internal resistor: `up`, `down` or none.
    pub pull: String,
    /// Edges: `low`, `high` or `very high` speed.
    pub speed: String,
    /// What is connected to it, in words.
    pub outside: String,
}

impl ProcessorPin {
    /// The letter of the port and the number in it.
    ///
    /// # Panics
    /// Never: [`Design`](crate::Design) refuses other names when it reads them.
    #[must_use]
    pub fn port(&self) -> (char, u8) {
        parse_pin(&self.pin).unwrap_or(('?', 0))
    }

    /// Channel of the ADC.
    #[must_use]
    pub fn adc_channel(&self) -> Option<u8> {
        self.peripheral.strip_prefix("ADC1_IN")?.parse().ok()
    }
}

/// Letter and number of a name as PE9.
pub(crate) fn parse_pin(name: &str) -> Option<(char, u8)> {
    let mut letters = name.strip_prefix('P')?.chars();
    let port = letters.next().filter(char::is_ascii_uppercase)?;
    let number: u8 = letters.as_str().parse().ok()?;
    (number < 16).then_some((port, number))
}

/// The functions of a processor pin, of `functions.csv`: `SIGNAL:AF`, or a channel of the ADC.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Functions {
    pub pin: String,
    pub functions: String,
}

/// A pin of the Nucleo's Morpho connectors, of `connectors.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Connector {
    pub morpho: String,
    pub name: String,
    pub zio: String,
}

/// What a net is for, of `chains.csv`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub(crate) struct Chain {
    pub board: String,
    pub chain: String,
    pub purpose: String,
}

/// A limit of the program, of `firmware/object-dictionary.csv`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limit {
    /// Last part of its path, as `over_current_ma`.
    pub name: String,
    /// Unit: mA, mV.
    pub unit: String,
    /// Default value.
    pub default: i64,
    /// Largest value that it accepts.
    pub max: i64,
}
