//! `actuator get`, `set`, `save` and `restore`.

use std::path::{Path, PathBuf};

use canopen_generator::{Access, Row};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::{AtNode, print_json, service::ServiceAccess};
use crate::error::Error;
use crate::output::{print, print_table};
use host_sim::can::{
    client::Client,
    motor_objects::{self, Object},
    names::{self, Value},
};
use host_sim::scenario::Scenario;
use host_sim::table::{Cell, Table};

/// Reads objects of an actuator, by name or index
///
/// Names are those of docs/object-dictionary.md, in any case and with hyphens or spaces:
/// `position-actual-value`, `software-position-limit/max-position-limit`, or the unique
/// `max-position-limit`. An index is hexadecimal: `6064`, `607D:2`.
#[derive(Debug, Args)]
pub struct Get {
    /// Objects [default: all readable ones]
    objects: Vec<String>,
    #[command(flatten)]
    at: AtNode,
}

impl Get {
    /// Reads and prints the objects.
    ///
    /// # Errors
    /// For an unknown name; those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        if let Some(mut servo) = self.at.servo()? {
            return servo.get(&self.objects, self.at.json());
        }
        if let Some(mut node) = self.at.drone()? {
            return node.get(&self.objects, self.at.json());
        }
        let all = self.objects.is_empty();
        let rows: Vec<&Row> = if all {
            names::rows()
                .iter()
                .filter(|row| is_readable(row))
                .collect()
        } else {
            let found = self.objects.iter().map(|object| names::find(object));
            found.collect::<Result<_, _>>()?
        };
        let mut client = self.at.open()?;
        let mut values = Vec::new();
        for row in rows {
            match client.get(row) {
                Ok(value) => values.push((row, value)),
                // For example an empty history.
                Err(error) if all && error.is_refusal() => {}
                Err(error) => return Err(error.into()),
            }
        }
        if self.at.json() {
            let object = values
                .iter()
                .map(|(row, value)| (names::name(row), value.into()));
            return print_json(&serde_json::Value::Object(object.collect()));
        }
        show(&values)
    }
}

fn is_readable(row: &Row) -> bool {
    row.access != Access::Wo && row.kind != canopen_generator::DataType::Domain
}

fn show(values: &[(&Row, Value)]) -> Result<(), Error> {
    if let [(row, value)] = values {
        let unit = &row.unit;
        return print(format!("{value} {unit}").trim_end()).and_then(|()| print("\n"));
    }
    let mut table = Table::new(
        "",
        &[("object", ""), ("index", ""), ("value", ""), ("unit", "")],
    );
    for (row, value) in values {
        let index = format!("{:04X}:{}", row.index, row.sub_index());
        let cells = [names::name(row), index, value.to_string(), row.unit.clone()];
        table.push(cells.map(Cell::Text));
    }
    print_table(&table)
}

/// Writes objects of an actuator, by name or index
#[derive(Debug, Args)]
pub struct Set {
    /// Objects and their values, such as `607D:2=45000` or `profile-velocity=100000`
    #[arg(required_unless_present = "parameters", value_name = "OBJECT=VALUE")]
    values: Vec<String>,
    /// Parameters of a motor or servo for the reference model, 2011h:1 to 6, written by
    /// `identify --parameters`; `model-selection=1` starts that model
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    #[command(flatten)]
    access: ServiceAccess,
    #[command(flatten)]
    at: AtNode,
}

impl Set {
    /// Writes the objects in order.
    ///
    /// # Errors
    /// For an unknown name or an invalid value; those of the bus and the actuator. Objects before
    /// the failed one are written.
    pub fn run(&self) -> Result<(), Error> {
        if let Some(mut servo) = self.at.servo()? {
            return servo.set(&self.values, self.at.json());
        }
        if let Some(mut node) = self.at.drone()? {
            return node.set(&self.values, self.at.json());
        }
        let writes = self.values.iter().map(|text| {
            let (object, value) = pair(text)?;
            let row = names::find(object.trim())?;
            Ok((row, names::encode(row, value.trim())?))
        });
        // All are validated before the first is written.
        let mut writes = writes.collect::<Result<Vec<_>, Error>>()?;
        if let Some(path) = &self.parameters {
            writes.splice(0..0, fitted(path)?);
        }
        self.access.during(&mut self.at.open()?, |client| {
            let mut writes = writes.iter();
            writes.try_for_each(|(row, bytes)| Ok(client.set(row, bytes)?))
        })?;
        if self.at.json() {
            let written: Vec<_> = writes.iter().map(|(row, _)| names::name(row)).collect();
            print_json(&json!({ "written": written }))?;
        }
        Ok(())
    }
}

/// Object and value of an argument.
pub(super) fn pair(text: &str) -> Result<(&str, &str), Error> {
    text.split_once('=').ok_or_else(|| Error::Option {
        option: "an object to set",
        value: text.to_owned(),
        expected: "OBJECT=VALUE",
    })
}

/// The values of the objects 2011h that a fit determines, with warnings for the others and for what
/// they cannot describe.
fn fitted(path: &Path) -> Result<Vec<(&'static Row, Vec<u8>)>, Error> {
    let scenario = Scenario::read(path)?;
    let settings = scenario.settings()?;
    let (objects, open): (Vec<_>, Vec<_>) = motor_objects::determined(&scenario)?
        .into_iter()
        .partition(|(_, is_determined)| *is_determined);
    for ((row, _), _) in open {
        let name = names::name(row);
        note!("warning: the fit does not determine {name}, which is not written");
    }
    if let Some(warning) = motor_objects::omitted_friction(&settings) {
        note!("warning: {warning}");
    }
    let bytes = |((row, value), _): (Object, bool)| (row, (value as f32).to_le_bytes().to_vec());
    Ok(objects.into_iter().map(bytes).collect())
}

/// Groups of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Group {
    /// All
    All,
    /// Communication parameters, 1000h to 1FFFh
    Communication,
    /// Application parameters
    Application,
}

/// Stores the present parameters in the flash of the actuator
#[derive(Debug, Args)]
pub struct Save {
    /// Group of parameters
    #[arg(long, value_enum, default_value_t = Group::All)]
    group: Group,
    #[command(flatten)]
    at: AtNode,
}

/// Restores the default parameters at the next reset of the actuator
#[derive(Debug, Args)]
pub struct Restore {
    /// Group of parameters
    #[arg(long, value_enum, default_value_t = Group::All)]
    group: Group,
    /// Resets the actuator at once
    #[arg(long)]
    reset: bool,
    #[command(flatten)]
    access: ServiceAccess,
    #[command(flatten)]
    at: AtNode,
}

impl Save {
    /// Stores the parameters.
    ///
    /// # Errors
    /// Those of the bus and the actuator.
    pub fn run(self) -> Result<(), Error> {
        sign(
            &self.at,
            &mut self.at.open()?,
            ("1010", b"save"),
            self.group,
        )
    }
}

impl Restore {
    /// Restores the parameters.
    ///
    /// # Errors
    /// Those of the bus and the actuator.
    pub fn run(self) -> Result<(), Error> {
        let mut client = self.at.open()?;
        self.access.during(&mut client, |client| {
            sign(&self.at, client, ("1011", b"load"), self.group)
        })?;
        if self.reset {
            client.manage(0x81).map_err(Error::from)?;
        }
        Ok(())
    }
}

fn sign(
    at: &AtNode,
    client: &mut Client,
    (index, signature): (&str, &[u8]),
    group: Group,
) -> Result<(), Error> {
    let row = names::find(&format!("{index}:{}", group as u8 + 1))?;
    client.set(row, signature)?;
    if at.json() {
        print_json(&json!({ "done": names::name(row) }))?;
    }
    Ok(())
}
