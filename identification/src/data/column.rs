//! Assigns quantities to the columns of a file.

use super::ImportError;
use super::{Table, unit};

/// The quantities that a column can contain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Time of the sample.
    Time,
    /// Commanded angle.
    Command,
    /// Measured angle.
    Angle,
    /// Measured rate.
    Rate,
    /// Duty at the motor.
    Duty,
    /// Current of the motor.
    Current,
    /// Supply voltage.
    Supply,
    /// Whether the motor is on; 0 is off.
    Enabled,
}

impl Quantity {
    /// All quantities; the first three are required.
    pub const ALL: [Self; 8] = [
        Self::Time,
        Self::Command,
        Self::Angle,
        Self::Rate,
        Self::Duty,
        Self::Current,
        Self::Supply,
        Self::Enabled,
    ];

    /// Its name on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Command => "command",
            Self::Angle => "angle",
            Self::Rate => "rate",
            Self::Duty => "duty",
            Self::Current => "current",
            Self::Supply => "supply",
            Self::Enabled => "enabled",
        }
    }

    /// Usual names of its column without the unit, by precedence.
    fn usual_names(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["t", "time", "timestamp", "time_stamp"],
            Self::Command => &[
                "command",
                "cmd",
                "commanded",
                "angle_command",
                "command_angle",
                "reference",
                "ref",
                "setpoint",
                "target",
                "goal_position",
                "goal",
                "target_position",
                "input",
                "u",
            ],
            Self::Angle => &[
                "angle_meas",
                "angle_measured",
                "measured",
                "measured_angle",
                "angle",
                "position",
                "pos",
                "theta",
                "shaft_angle",
                "encoder",
                "output",
                "y",
            ],
            Self::Rate => &[
                "rate_meas",
                "rate",
                "angular_rate",
                "speed",
                "velocity",
                "omega",
            ],
            Self::Duty => &["duty", "motor_duty", "pwm"],
            Self::Current => &["current_meas", "current", "motor_current"],
            Self::Supply => &["supply", "input_volts", "supply_voltage", "voltage", "vin"],
            Self::Enabled => &[
                "enabled",
                "enable",
                "motor_on",
                "torque_enable",
                "torque_enabled",
            ],
        }
    }

    /// The index of its column among columns of these names, by its usual names; `None` without
    /// such a column.
    ///
    /// ```
    /// use identification::data::Quantity;
    ///
    /// let names = ["time_s", "command_mdeg"].map(String::from);
    /// assert_eq!(Quantity::Command.find(&names), Ok(Some(1)));
    /// assert_eq!(Quantity::Command.unit_in(&names[1]), Some(1e-3));
    /// ```
    ///
    /// # Errors
    /// The indices of two columns that may both be it.
    pub fn find(self, names: &[String]) -> Result<Option<usize>, [usize; 2]> {
        for usual in self.usual_names() {
            let is_it = |name: &String| unit::split(self, name).0 == *usual;
            let mut found = (0..names.len()).filter(|&i| is_it(&names[i]));
            match (found.next(), found.next()) {
                (None, _) => {}
                (Some(index), None) => return Ok(Some(index)),
                (Some(a), Some(b)) => return Err([a, b]),
            }
        }
        Ok(None)
    }

    /// The factor from the unit in a column's name to that of a recording; `None` if the name has
    /// no unit.
    pub fn unit_in(self, name: &str) -> Option<f64> {
        unit::split(self, name).1
    }

    fn is_angle(self) -> bool {
        matches!(self, Self::Command | Self::Angle)
    }

    fn is_required(self, may_lack_command: bool) -> bool {
        match self {
            Self::Time | Self::Angle => true,
            Self::Command => !may_lack_command,
            _ => false,
        }
    }
}

/// An assigned column: `angle=pos:rad`.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnSelection {
    /// The quantity in the column.
    pub quantity: Quantity,
    /// Its name in the file, or its number from 1.
    pub column: String,
    /// Factor from its unit to that of the recording; by default from the unit in its name.
    pub factor: Option<f64>,
}

impl std::str::FromStr for ColumnSelection {
    type Err = String;

    /// Parses `QUANTITY=COLUMN[:UNIT]`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (quantity, column) = text
            .split_once('=')
            .ok_or("expected QUANTITY=COLUMN or QUANTITY=COLUMN:UNIT, as in angle=pos:rad")?;
        let names = || Quantity::ALL.map(Quantity::name).join(", ");
        let quantity = Quantity::ALL
            .into_iter()
            .find(|q| q.name() == quantity.trim())
            .ok_or_else(|| {
                format!(
                    "`{quantity}` is not a quantity, expected one of {}",
                    names()
                )
            })?;
        let (column, factor) = match column.rsplit_once(':') {
            None => (column, None),
            Some((column, unit)) => {
                let expected = || {
                    let expected = unit::expected(quantity);
                    format!(
                        "`{unit}` is not a unit of {}, expected {expected}",
                        quantity.name()
                    )
                };
                let factor = unit::factor(quantity, unit).ok_or_else(expected)?;
                (column, Some(factor))
            }
        };
        Ok(Self {
            quantity,
            column: column.trim().to_owned(),
            factor,
        })
    }
}

/// The assigned columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns(pub Vec<ColumnSelection>);

/// The column of a quantity in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocatedColumn {
    /// The quantity.
    pub quantity: Quantity,
    /// The index of its column.
    pub index: usize,
    /// The factor from its unit to that of the recording.
    pub factor: f64,
    /// Whether the unit is assumed.
    pub is_assumed: bool,
}

impl Columns {
    /// Finds all quantities in a table, which may lack a command.
    ///
    /// # Errors
    /// [`ImportError::Content`] at the header, for a missing column or a required quantity without
    /// a column.
    pub fn of(
        &self,
        table: &Table,
        may_lack_command: bool,
    ) -> Result<Vec<LocatedColumn>, ImportError> {
        let mut columns = Vec::new();
        for quantity in Quantity::ALL {
            let found = match self.0.iter().rev().find(|c| c.quantity == quantity) {
                Some(selection) => Some(selected(table, selection)?),
                None => usual(table, quantity)?,
            };
            match found {
                Some((index, factor)) => columns.push((quantity, index, factor)),
                None if quantity.is_required(may_lack_command) => {
                    return Err(missing(table, quantity));
                }
                None => {}
            }
        }
        Ok(with_units(table, &columns))
    }
}

/// Completes unknown units: command and angle have the same unit.
fn with_units(table: &Table, columns: &[(Quantity, usize, Option<f64>)]) -> Vec<LocatedColumn> {
    let known = columns.iter().find(|(q, _, f)| q.is_angle() && f.is_some());
    let angle = known.and_then(|(_, _, factor)| *factor);
    let located = |&(quantity, index, factor): &(Quantity, usize, Option<f64>)| {
        let default = match quantity {
            Quantity::Current => "a",
            Quantity::Command | Quantity::Angle if table.radians => "rad",
            Quantity::Rate if table.radians => "rad/s",
            Quantity::Command | Quantity::Angle => "deg",
            _ => "",
        };
        let shared = angle.filter(|_| quantity.is_angle());
        let factor = factor.or(shared);
        LocatedColumn {
            quantity,
            index,
            factor: factor
                .or_else(|| unit::factor(quantity, default))
                .unwrap_or(1.0),
            // A time without a unit is in seconds; an angle may be in degrees or radians.
            is_assumed: factor.is_none() && quantity.is_angle() && !table.radians,
        }
    };
    columns.iter().map(located).collect()
}

/// The assigned column, and its unit.
fn selected(
    table: &Table,
    selection: &ColumnSelection,
) -> Result<(usize, Option<f64>), ImportError> {
    let by_number = || {
        selection
            .column
            .parse()
            .ok()
            .and_then(|n: usize| n.checked_sub(1))
    };
    let index = table
        .names
        .iter()
        .position(|name| *name == selection.column)
        .or_else(|| by_number().filter(|&index| index < table.names.len()));
    let index = index.ok_or_else(|| {
        let columns = table.names.join("`, `");
        let problem = format!(
            "no column `{}`: the columns are `{columns}`",
            selection.column
        );
        table.problem(table.header_line, problem)
    })?;
    let unit = selection
        .factor
        .or_else(|| unit_of(table, selection.quantity, index));
    Ok((index, unit))
}

/// The unit in a column's name or in the line of units.
fn unit_of(table: &Table, quantity: Quantity, index: usize) -> Option<f64> {
    let below = table.units.get(index);
    let below = below.and_then(|u| unit::factor(quantity, u.trim_matches(['(', ')', '[', ']'])));
    below.or_else(|| quantity.unit_in(&table.names[index]))
}

/// The column with a usual name of a quantity, and its unit.
fn usual(table: &Table, quantity: Quantity) -> Result<Option<(usize, Option<f64>)>, ImportError> {
    match quantity.find(&table.names) {
        Ok(found) => Ok(found.map(|index| (index, unit_of(table, quantity, index)))),
        Err([a, b]) => {
            let (a, b, name) = (&table.names[a], &table.names[b], quantity.name());
            let problem =
                format!("`{a}` and `{b}` may both be the {name}, expected --column {name}=COLUMN");
            Err(table.problem(table.header_line, problem))
        }
    }
}

fn missing(table: &Table, quantity: Quantity) -> ImportError {
    let (columns, name) = (table.names.join("`, `"), quantity.name());
    let problem = format!(
        "no column is known to be the {name}: the columns are `{columns}`, expected --column \
         {name}=COLUMN:UNIT"
    );
    table.problem(table.header_line, problem)
}
