//! `actuator excite`: an excitation that runs on the actuator.

use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde_json::json;

use super::move_to::mdeg;
use super::{AtNode, print_json};
use crate::error::Error;
use crate::interrupt;
use host_sim::can::{
    client::Client,
    excitation::{self, SHAPES},
};

/// Runs an excitation on an actuator, around its present angle
///
/// The excitation stops if this program is interrupted or ends, but with --no-wait.
/// Parameters that are not given keep their values in the actuator. With --capture the board
/// records in each control period, and `actuator record --capture` uploads the recording.
#[derive(Debug, Args)]
pub struct Excite {
    /// Shape
    #[arg(value_parser = shapes())]
    shape: usize,
    /// Amplitude, deg
    #[arg(long, value_name = "DEG")]
    amplitude: Option<f64>,
    /// Frequency, or the start frequency of a chirp, Hz
    #[arg(long, value_name = "HZ")]
    start: Option<f64>,
    /// End frequency of a chirp, Hz
    #[arg(long, value_name = "HZ")]
    end: Option<f64>,
    /// Length of a chirp, s
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Width, dwell, hold or chip, s
    #[arg(long, value_name = "SECONDS")]
    unit: Option<f64>,
    /// Slope of a ramp, deg/s
    #[arg(long, value_name = "DEG_S")]
    rate: Option<u32>,
    /// Order of a pseudo-random binary sequence
    #[arg(long)]
    order: Option<u32>,
    /// Lines of a multisine
    #[arg(long)]
    lines: Option<u32>,
    /// Number of repetitions
    #[arg(long)]
    repetitions: Option<u32>,
    /// Records on the board during the excitation; with --no-wait until `actuator set 2030:1=0` or
    /// until its memory is full
    #[arg(long)]
    capture: bool,
    /// Does not wait for the end
    #[arg(long)]
    no_wait: bool,
    #[command(flatten)]
    at: AtNode,
}

/// The numbers of the shapes, by their names.
fn shapes() -> impl TypedValueParser<Value = usize> {
    let names = SHAPES.map(|shape| PossibleValue::new(shape.name).help(shape.label));
    let number = |name: String| SHAPES.iter().position(|shape| shape.name == name);
    PossibleValuesParser::new(names).map(move |name| number(name).unwrap_or_default())
}

impl Excite {
    /// Configures the excitation, starts it, and waits for its end.
    ///
    /// # Errors
    /// For an invalid number; those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        let settings = self.settings()?;
        let mut client = self.at.open()?;
        for (sub, value) in settings {
            client.write(&format!("2020:{sub}"), &value.to_string())?;
        }
        let done = self.start(&mut client);
        // An excitation that has not started or has failed ends the recording.
        let stopped = match self.capture && (done.is_err() || !self.no_wait) {
            true => client.write("2030:1", "0"),
            false => Ok(()),
        };
        done.and(stopped.map_err(Error::from))?;
        if self.at.json() {
            print_json(&json!({ "started": true, "ended": !self.no_wait }))?;
        }
        Ok(())
    }

    /// Enables the drive, starts the excitation, and waits for its end unless --no-wait is given.
    fn start(&self, client: &mut Client) -> Result<(), Error> {
        let begin = |client: &mut Client| {
            client.enable(1)?;
            if self.capture {
                client.write("2030:3", "1")?;
                client.write("2030:1", "1")?;
            }
            excitation::start(client)
        };
        if self.no_wait {
            return Ok(begin(client)?);
        }
        let run = |client: &mut Client| {
            begin(client)?;
            wait(client)
        };
        let stop = |client: &mut Client| client.write("2020:1", "0");
        client.supervised(interrupt::stop()?, run, stop)
    }

    /// The given parameters, by sub-index.
    fn settings(&self) -> Result<Vec<(u8, i32)>, Error> {
        let scaled = [
            (4, "--amplitude", self.amplitude),
            (5, "--start", self.start),
            (6, "--end", self.end),
            (7, "--duration", self.duration),
            (8, "--unit", self.unit),
        ];
        let mut settings = vec![(3, self.shape as i32)];
        for (sub, option, value) in scaled {
            if let Some(value) = value {
                settings.push((sub, mdeg(option, value)?));
            }
        }
        let whole = [
            (9, self.rate),
            (10, self.order),
            (11, self.lines),
            (12, self.repetitions),
        ];
        for (sub, value) in whole {
            settings.extend(value.map(|value| (sub, value.min(i32::MAX as u32) as i32)));
        }
        Ok(settings)
    }
}

fn wait(client: &mut Client) -> Result<(), Error> {
    loop {
        client.pause(Duration::from_millis(20))?;
        if client.status()? & 0x6F != 0x27 {
            return Ok(client.fail_in_state("expected the excitation to end")?);
        }
        if client.integer("2020:2")? == 0 {
            return Ok(());
        }
    }
}
