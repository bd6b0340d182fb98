//! `actuator commission`: checks, measures, writes and saves.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::move_to::mdeg;
use super::{AtNode, print_json};
use crate::error::Error;
use crate::output::{print, print_table};
use crate::{interrupt, origin};
use host_sim::can::client::{Client, ClientError};
use host_sim::can::sdo::SdoError;
use host_sim::commission::{
    self, Answer, CommissionError, Findings, Kept, LEAST_RANGE_MDEG, Limits,
};
use host_sim::file;

/// Checks the wiring of an actuator, measures its motor, and saves the parameters with the range
///
/// The shaft moves for less than two minutes, and before that to its stops where --range is not
/// given. Pulses of growing torque show the senses of motor, encoder and current, and give the
/// resistance; within a --range of 300 deg and more, runs over it give the error of the encoder
/// once and twice a turn; runs at constant rate in both directions within --range give the torque
/// constant by the gear ratio of 2011h:3, and friction; two excitations give inertia and delay.
/// Gains with their margins for all motors within the standard errors follow, which a sweep and a
/// step in the closed loop verify, and the feed-forward 2013h, which moves verify; moves with all
/// this give the baseline of the health. What is wrong or cannot be identified is refused with exit
/// status 3, and nothing is written; otherwise 607Dh, 2011h:1, 2, 4, 5 and 6, 2014h, 60FBh:1,
/// 60F9h:1 to 3, 2013h:1 to 3, 2053h:1, 2, 9 and 10 and the date 1020h are written, and all are
/// saved (1010h). A value that a second measurement contradicts, a viscous friction that is not
/// known from zero, a supply resistance and a play that the moves do not show, and gains whose loop
/// is not as predicted are reported and not written. --centre changes the origin 2041h:3 by a
/// homing without a motion, so that the middle of the range is position 0, within 0.5 deg; 607Dh,
/// and a later --range, are by the new positions. Angles of servo pulses keep their place; the
/// position 2040h:3 keeps its number, so that its place moves with position 0.
#[derive(Debug, Args)]
pub struct Commission {
    /// Range of the angle, deg; without it the stops are found at half of --current
    #[arg(long, num_args = 2, value_names = ["MIN", "MAX"])]
    range: Vec<f64>,
    /// Highest mean current, % of the rated current 6075h; a brake of the shaft may have more
    #[arg(long, value_name = "PERCENT", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=200))]
    current: u16,
    /// Highest rate, deg/s
    #[arg(long, value_name = "DEG_S", default_value_t = 120, value_parser = clap::value_parser!(u16).range(40..=2000))]
    rate: u16,
    /// Makes the middle of the range position 0
    #[arg(long, conflicts_with = "dry_run")]
    centre: bool,
    /// Keeps gains and feed-forward
    #[arg(long)]
    no_tuning: bool,
    /// Writes and saves nothing
    #[arg(long)]
    dry_run: bool,
    /// Writes a self-contained page with all figures
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Waits until a master writes 1 to 2055h, commissions, writes 3 there (saved) or 4 (refused),
    /// and waits again
    #[arg(long, conflicts_with = "dry_run")]
    on_request: bool,
    #[command(flatten)]
    at: AtNode,
}

/// Time between two reads of 2055h.
const BETWEEN_READS: Duration = Duration::from_millis(200);

impl Commission {
    /// Commissions the actuator, once or at each request.
    ///
    /// # Errors
    /// For an invalid number, the refusals of the steps; those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        let limits = self.limits()?;
        let html = self.html.iter().map(|path| ("--html", path.as_path()));
        file::check(&html.collect::<Vec<_>>(), [])?;
        self.check_requests()?;
        let mut client = self.at.open()?;
        if self.on_request {
            return self.serve(&mut client, &limits);
        }
        let findings = self.commission(&mut client, &limits)?;
        self.report(&findings)
    }

    /// The next request would take --range by other positions.
    fn check_requests(&self) -> Result<(), Error> {
        if self.on_request && self.centre && !self.range.is_empty() {
            let text = "--centre with --on-request changes the positions of --range for the next \
                        request: expected no --range";
            return Err(Error::Conflict(text.into()));
        }
        Ok(())
    }

    /// Commissions at each request of a master until an interrupt, or an error of the bus.
    fn serve(&self, client: &mut Client, limits: &Limits) -> Result<(), Error> {
        let stop = interrupt::stop()?;
        commission::end_old_requests(client)?;
        while !stop.load(Ordering::Relaxed) {
            match commission::is_requested(client) {
                Ok(true) => {}
                // An actuator that is off may be switched on.
                Ok(false) => {
                    client.pause(BETWEEN_READS)?;
                    continue;
                }
                Err(ClientError::Object {
                    source: SdoError::Timeout(_),
                    ..
                }) => continue,
                Err(error) => return Err(error.into()),
            }
            Answer::Running.report(client)?;
            let result = self.commission(client, limits);
            let answer = match result {
                Ok(_) => Answer::Saved,
                Err(Error::Commission(CommissionError::Refused { step, .. })) => {
                    Answer::Refused(step)
                }
                Err(_) => Answer::Failed,
            };
            let answered = answer.report(client);
            match result {
                Ok(findings) => self.report(&findings)?,
                Err(error) if is_refusal(&error) => note!("{error}"),
                Err(error) => return Err(error),
            }
            answered?;
        }
        Ok(())
    }

    /// All steps, and the write unless it is a dry run. An error leaves the parameters of before.
    fn commission(&self, client: &mut Client, limits: &Limits) -> Result<Findings, Error> {
        let stop = interrupt::stop()?;
        let kept = Kept::of(client)?;
        let find = |client: &mut Client| {
            commission::find(client, limits, (&kept, !self.no_tuning), |step| {
                note!("{step}")
            })
        };
        let findings = client.supervised(Arc::clone(&stop), find, Client::quick_stop);
        let restored = kept.restore(client);
        let mut findings = match (findings, restored) {
            (Ok(findings), Ok(())) => findings,
            (Ok(_), Err(error)) => return Err(error.into()),
            (Err(error), restored) => return Err(behind(error, restored)),
        };
        if !self.dry_run {
            let written = self.write(client, limits, &mut findings, stop);
            written.map_err(|error| behind(error, kept.restore(client)))?;
        }
        Ok(findings)
    }

    /// The last steps: the origin if it is wanted, and the write.
    fn write(
        &self,
        client: &mut Client,
        limits: &Limits,
        findings: &mut Findings,
        stop: Arc<AtomicBool>,
    ) -> Result<(), CommissionError> {
        if self.centre {
            note!("makes the middle of the range position 0");
            let centre = |client: &mut Client| commission::centre(client, limits, findings);
            client.supervised(stop, centre, Client::quick_stop)?;
        }
        note!("writes and saves what was found");
        commission::write(client, findings)
    }

    fn report(&self, findings: &Findings) -> Result<(), Error> {
        if let Some(path) = &self.html {
            let origin = origin::of_this_run();
            commission::page(findings, &origin, !self.dry_run).write(path)?;
            note!("report: {}", path.display());
        }
        match self.at.json() {
            true => {
                let positions = findings.positions();
                let positions = positions.map(|(object, mdeg)| (object, f64::from(mdeg)));
                let objects: Vec<_> = positions.chain(findings.objects()).collect();
                print_json(&json!({
                    "saved": !self.dry_run,
                    "findings": findings,
                    "objects": objects,
                }))
            }
            false => {
                let tables = findings.tables(!self.dry_run);
                tables.iter().try_for_each(print_table)?;
                let doubts = findings.doubts().into_iter();
                print(&doubts.map(|doubt| doubt + "\n").collect::<String>())
            }
        }
    }

    fn limits(&self) -> Result<Limits, Error> {
        let range_mdeg = match self.range[..] {
            [low, high] => Some(range(mdeg("--range", low)?, mdeg("--range", high)?)?),
            _ => None,
        };
        Ok(Limits {
            range_mdeg,
            permille: self.current * 10,
            rate_mdeg_s: i32::from(self.rate) * 1000,
        })
    }
}

/// Whether the next request may succeed: the actuator or a step has refused, and the bus works.
fn is_refusal(error: &Error) -> bool {
    match error {
        Error::Commission(_) | Error::Refused(_) => true,
        Error::Bus(error) => error.is_refusal() || error.is_at_limit(),
        _ => false,
    }
}

/// An error, with that of the restoring which followed it.
fn behind(error: CommissionError, restored: Result<(), ClientError>) -> Error {
    match restored {
        Ok(()) => error.into(),
        Err(other) => Error::Refused(format!(
            "{error}; the parameters of before could not be restored, a reset without 1010h \
             restores them: {other}"
        )),
    }
}

/// A pulse needs 15 deg on both sides, and a run room for its settling. Two turns are reached in
/// the time of a run.
fn range(low: i32, high: i32) -> Result<(i32, i32), Error> {
    let width = i64::from(high) - i64::from(low);
    if (LEAST_RANGE_MDEG.into()..=720_000).contains(&width) {
        return Ok((low, high));
    }
    let text =
        format!("--range is {low} to {high} mdeg, expected 40 to 720 deg from MIN up to MAX");
    Err(Error::Conflict(text))
}

impl From<CommissionError> for Error {
    fn from(error: CommissionError) -> Self {
        match error {
            CommissionError::Client(error) => Self::Bus(error),
            refused => Self::Commission(refused),
        }
    }
}
