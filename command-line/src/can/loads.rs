//! Pendulums at the shafts of the actuators and servos that are served.

use clap::Args;
use model_core::parameter::Parameters as _;
use model_core::plant::drivetrain::load::LoadParameters;

use crate::error::Error;

/// The loads of all shafts.
#[derive(Debug, Args)]
pub struct Loads {
    /// Pendulum at each shaft: kg and m from the axis; with ID@ at this one only, as 2@0.5:0.1;
    /// repeatable
    ///
    /// A point mass, with its inertia. It hangs down at angle 0, position 2048 of a servo, where
    /// it begins at rest; at another angle its torque is -m g l sin(angle). One with an ID
    /// replaces that of all.
    #[arg(long = "load", value_name = "[ID@]KG:M", value_parser = load)]
    loads: Vec<Load>,
}

/// A load, and where it is.
#[derive(Debug, Clone, Copy)]
struct Load {
    /// `None` for all shafts.
    id: Option<u8>,
    pendulum: LoadParameters,
}

impl Loads {
    /// Checks that all loads have a shaft among so many.
    ///
    /// # Errors
    /// For an ID without a shaft.
    pub fn check(&self, count: u8) -> Result<(), Error> {
        let mut ids = self.loads.iter().filter_map(|load| load.id);
        match ids.find(|id| !(1..=count).contains(id)) {
            Some(id) => Err(Error::Conflict(format!(
                "--load {id}@: expected an ID from 1 to {count}, the number of --nodes"
            ))),
            None => Ok(()),
        }
    }

    /// The load at the shaft with this ID. Of several for the same shafts the last one counts.
    pub fn of(&self, id: u8) -> LoadParameters {
        let last = |of: Option<u8>| self.loads.iter().rev().find(|load| load.id == of);
        let load = last(Some(id)).or_else(|| last(None));
        load.map_or_else(LoadParameters::default, |load| load.pendulum)
    }
}

fn load(text: &str) -> Result<Load, String> {
    let (id, pendulum) = match text.split_once('@') {
        Some((id, pendulum)) => {
            let number = id.parse().map_err(|_| format!("`{id}` is not an ID"))?;
            (Some(number), pendulum)
        }
        None => (None, text),
    };
    let (mass, length) = pendulum.split_once(':').ok_or("expected [ID@]KG:M")?;
    Ok(Load {
        id,
        pendulum: LoadParameters {
            pendulum_mass_kg: value("pendulum_mass_kg", mass)?,
            pendulum_length_m: value("pendulum_length_m", length)?,
            ..LoadParameters::default()
        },
    })
}

/// A value in the range of this parameter of the load.
fn value(name: &str, text: &str) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a number"))?;
    let parameter = LoadParameters::TABLE.iter().find(|row| row.name == name);
    let checked = parameter.map(|row| row.check(value)).transpose();
    checked.map_err(|error| error.to_string())?;
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loads(options: &[&str]) -> Loads {
        Loads {
            loads: options.iter().map(|text| load(text).expect(text)).collect(),
        }
    }

    #[test]
    fn a_load_with_an_id_replaces_that_of_all_and_the_last_one_counts() {
        let loads = loads(&["2@0.5:0.2", "0.1:0.05", "2@0.6:0.3", "0.2:0.1"]);
        let pendulum = |id| {
            let load = loads.of(id);
            (load.pendulum_mass_kg, load.pendulum_length_m)
        };
        assert_eq!(
            [1, 2, 3].map(pendulum),
            [(0.2, 0.1), (0.6, 0.3), (0.2, 0.1)]
        );
        assert_eq!(Loads { loads: Vec::new() }.of(1), LoadParameters::default());
    }

    #[test]
    fn a_load_without_a_shaft_is_refused() {
        assert!(loads(&["3@0.5:0.2", "0.1:0.1"]).check(3).is_ok());
        for id in ["0", "4"] {
            let refused = loads(&[&format!("{id}@0.5:0.2")]).check(3);
            let message = refused.expect_err("it has no shaft").to_string();
            let expected = format!("--load {id}@: expected an ID from 1 to 3");
            assert!(message.starts_with(&expected), "{message}");
        }
    }
}
