//! Assigns quantities to the columns of a file.

use super::{ImportError, Table, names, unit};

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
        names::find(self, names)
    }

    /// The factor from the unit in a column's name to that of a recording; `None` if the name has
    /// no unit.
    pub fn unit_in(self, name: &str) -> Option<f64> {
        unit::split(self, name).1
    }

    /// Whether it is an angle.
    pub(super) fn is_angle(self) -> bool {
        matches!(self, Self::Command | Self::Angle)
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
    /// Whether its unit is a length.
    pub is_length: bool,
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
        if column
            .split(':')
            .next()
            .is_none_or(|name| name.trim().is_empty())
        {
            return Err(format!(
                "the column of the {} is empty, expected its name or number",
                quantity.name()
            ));
        }
        // The colon of `data(:,3)` and `data(3,:)` is of a name.
        let of_unit = column
            .rsplit_once(':')
            .filter(|(_, unit)| !unit.starts_with([',', ')', ']']));
        let (column, factor, is_length) = match of_unit {
            None => (column, None, false),
            Some((column, unit)) => {
                let expected = || {
                    let expected = unit::expected(quantity);
                    format!(
                        "`{unit}` is not a unit of {}, expected {expected}",
                        quantity.name()
                    )
                };
                let factor = unit::factor(quantity, unit).ok_or_else(expected)?;
                (
                    column,
                    Some(factor),
                    quantity.is_angle() && unit::is_length(unit),
                )
            }
        };
        Ok(Self {
            quantity,
            column: column.trim().to_owned(),
            factor,
            is_length,
        })
    }
}

/// The assigned columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    /// Each with its quantity; the others are found by their usual names.
    pub selected: Vec<ColumnSelection>,
    /// The joint of a robot whose columns have its name.
    pub joint: Option<String>,
}

/// The column of a quantity in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocatedColumn {
    /// The quantity.
    pub quantity: Quantity,
    /// The index of its column.
    pub index: usize,
    /// The factor from its unit to that of the recording; `None` for an unknown unit.
    pub factor: Option<f64>,
    /// Whether the unit is a length.
    pub is_length: bool,
    /// Whether the unit is that of an encoder, by the values.
    pub is_counts: bool,
    /// The unit, if it is that which is usual for the name.
    pub usual_unit: Option<&'static str>,
}

/// Counts of a turn of the encoders of smart servos.
const COUNTS: f64 = 4096.0;

impl Columns {
    /// Finds all quantities in a table, which may lack some. One that is not required is left out
    /// where several columns may be it; the second part of the result states it.
    ///
    /// # Errors
    /// [`ImportError::Content`] at the header, for a missing column or a quantity without a column
    /// that it may not lack.
    pub fn of(
        &self,
        table: &Table,
        may_lack: impl Fn(Quantity) -> bool,
    ) -> Result<(Vec<LocatedColumn>, Vec<String>), ImportError> {
        let (mut columns, mut lacking, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        if let Some([a, b]) = &table.rivals
            && self.joint.is_none()
            && !self
                .selected
                .iter()
                .any(|selection| selection.quantity.is_angle())
        {
            let problem = format!(
                "`{a}` and `{b}` both have command and angle, expected one recording: --joint {a} \
                 chooses"
            );
            return Err(table.problem(table.header_line, problem));
        }
        for quantity in Quantity::ALL {
            let found = match self.selected.iter().rev().find(|c| c.quantity == quantity) {
                Some(selection) => Some(selected(table, selection)?),
                None => match self.usual(table, quantity) {
                    Ok(found) => found,
                    Err(_) if may_lack(quantity) && quantity == Quantity::Time => continue,
                    Err(problem) if may_lack(quantity) => {
                        left_out.push(format!("{problem}; it is left out"));
                        continue;
                    }
                    Err(problem) => return Err(table.problem(table.header_line, problem)),
                },
            };
            match found {
                Some(column) => columns.push(column),
                None if may_lack(quantity) => {}
                None => lacking.push(quantity),
            }
        }
        if !lacking.is_empty() {
            return Err(missing(table, &lacking));
        }
        // Command and angle have the same unit, but where that of the angle is defined.
        let known = columns
            .iter()
            .find(|c| c.quantity.is_angle() && c.factor.is_some());
        let shared = known.and_then(|column| column.factor);
        let shared = shared.filter(|_| !table.radians);
        let mut angles = columns.iter().filter(|c| c.quantity.is_angle());
        let is_counts = shared.is_none()
            && !table.radians
            && angles.all(|column| are_counts(&table.columns[column.index]));
        let shared = shared.or(is_counts.then_some(360.0 / COUNTS));
        for column in columns.iter_mut().filter(|c| c.quantity.is_angle()) {
            column.factor = column.factor.or(shared);
            column.is_counts = is_counts;
        }
        Ok((columns, left_out))
    }

    /// The column with a usual name of a quantity; the problem of two such columns.
    fn usual(&self, table: &Table, quantity: Quantity) -> Result<Option<LocatedColumn>, String> {
        // A joint may have its own time, or share one.
        let of_joint = match &self.joint {
            Some(joint) => quantity.find(&names::of_joint(&table.names, joint)),
            None => quantity.find(&table.names[..table.own_columns.min(table.names.len())]),
        };
        let is_of_all = self.joint.is_none() || quantity == Quantity::Time;
        let found = match of_joint {
            Ok(None) if is_of_all => quantity.find(&table.names),
            found => found,
        };
        match found {
            Ok(found) => Ok(found.map(|index| located(table, quantity, index))),
            Err([a, b]) => {
                let (a, b, name) = (&table.names[a], &table.names[b], quantity.name());
                let joint = match &self.joint {
                    Some(_) => "",
                    None => ", or --joint JOINT where the columns have the names of joints",
                };
                Err(format!(
                    "`{a}` and `{b}` may both be the {name}, expected --column \
                     {name}=COLUMN{joint}"
                ))
            }
        }
    }
}

/// Whether these are whole numbers within a turn of an encoder, and beyond one in degrees.
fn are_counts(column: &[f64]) -> bool {
    let is_count = |value: &f64| value.fract() == 0.0 && (0.0..COUNTS).contains(value);
    let mut numbers = column.iter().filter(|value| !value.is_nan());
    numbers.clone().any(|value| *value > 360.0) && numbers.all(is_count)
}

/// The assigned column.
fn selected(table: &Table, selection: &ColumnSelection) -> Result<LocatedColumn, ImportError> {
    let by_number = || {
        let number: usize = selection.column.parse().ok()?;
        number
            .checked_sub(1)
            .filter(|&index| index < table.names.len())
    };
    // `data[:,3]` is `data(:,3)`, and `run/angle` is `run.angle`.
    let plain = |name: &str| {
        let name = name.replace('[', "(").replace(']', ")");
        name.replace('/', ".").replace(' ', "")
    };
    let is_it = |name: &String| plain(name) == plain(&selection.column);
    let exact = table
        .names
        .iter()
        .position(|name| *name == selection.column);
    // A column of a struct or group, by its own name.
    let in_group = || {
        let ends = |name: &&String| {
            let before = name.strip_suffix(&selection.column);
            before.is_some_and(|before| before.ends_with('.'))
        };
        let mut found = table.names.iter().filter(ends);
        let name = found.next().filter(|_| found.next().is_none())?;
        table.names.iter().position(|other| other == name)
    };
    let index = exact
        .or_else(|| table.names.iter().position(is_it))
        .or_else(in_group)
        .or_else(by_number);
    let index = index.ok_or_else(|| {
        let problem = format!("no column `{}`: {}", selection.column, table.described());
        table.problem(table.header_line, problem)
    })?;
    let located = located(table, selection.quantity, index);
    Ok(match selection.factor {
        None => located,
        given => LocatedColumn {
            factor: given,
            usual_unit: None,
            is_length: selection.is_length,
            ..located
        },
    })
}

/// A column with the unit in the line of units or in its name, or that is usual for its name.
fn located(table: &Table, quantity: Quantity, index: usize) -> LocatedColumn {
    let name = &table.names[index];
    let below = table.units.get(index).map(|unit| unit::bare(unit));
    let below = below.and_then(|text| Some((unit::factor(quantity, text)?, text)));
    let named = || Some((quantity.unit_in(name)?, &**name));
    let stated = below.or_else(named);
    let usual_unit = match stated {
        Some(_) => None,
        None => names::usual_unit(name),
    };
    let usual = usual_unit.and_then(|unit| Some((unit::factor(quantity, unit)?, "")));
    let (factor, text) = match stated.or(usual) {
        Some((factor, text)) => (Some(factor), text),
        None => (None, ""),
    };
    LocatedColumn {
        quantity,
        index,
        factor,
        is_length: quantity.is_angle() && factor.is_some() && unit::is_length(text),
        is_counts: false,
        usual_unit: usual_unit.filter(|_| usual.is_some()),
    }
}

fn missing(table: &Table, lacking: &[Quantity]) -> ImportError {
    let names: Vec<&str> = lacking.iter().map(|quantity| quantity.name()).collect();
    let options = names
        .iter()
        .map(|name| format!("--column {name}=COLUMN:UNIT"));
    let options = options.collect::<Vec<_>>().join(" ");
    let without_time = match lacking.contains(&Quantity::Time) {
        true => "; --rate HZ in place of a time for samples at equal intervals",
        false => "",
    };
    let problem = format!(
        "no column is known to be the {}: {}, expected {options}{without_time}",
        names.join(", nor the "),
        table.described()
    );
    table.problem(table.header_line, problem)
}
