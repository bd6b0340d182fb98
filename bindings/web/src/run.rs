//! Runs an actuator and records its outputs.

use model_core::actuator::{Actuator, Reading};
use model_core::time::seconds;

use crate::scenario::{Error, MOST_ROWS, Scenario};

/// The columns of a trace: the time, the command at that time, and the outputs before the updates
/// of this instant (`Actuator::reading`).
pub const COLUMNS: [&str; 10] = {
    let [a, b, c, d, e, f, g, h] = Reading::COLUMNS;
    ["time_s", "command_deg", a, b, c, d, e, f, g, h]
};

/// The recording of a run: one column after the other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    values: Vec<f64>,
    rows: usize,
}

impl Trace {
    fn zeros(rows: usize) -> Self {
        Self {
            values: vec![0.0; rows * COLUMNS.len()],
            rows,
        }
    }

    fn put(&mut self, row: usize, t_s: f64, command_deg: f64, r: &Reading) {
        let values = [t_s, command_deg].into_iter().chain(r.values());
        for (column, value) in values.enumerate() {
            self.values[column * self.rows + row] = value;
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// All values, column after column.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The column of this name; empty where there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        let index = COLUMNS.iter().position(|column| *column == name);
        let columns = index.and_then(|i| self.values.get(i * self.rows..(i + 1) * self.rows));
        columns.unwrap_or_default()
    }
}

/// Receives the share of a run that is done, and returns whether to continue.
pub type Watch = fn(share: f64) -> bool;

/// Ticks between two calls of a [`Watch`], unless the rows are further apart: 0.1 s.
const WATCH_TICKS: u64 = 2_000;

/// Reports a row to a watch, if it is due.
///
/// # Errors
/// [`Error::Interrupted`].
fn report(watch: Watch, row: u64, rows: u64, every: u64) -> Result<(), Error> {
    // The row is the first one after a multiple of the period.
    let is_due = row > 0 && (row * every) % WATCH_TICKS < every;
    if is_due && !watch(row as f64 / rows as f64) {
        return Err(Error::Interrupted);
    }
    Ok(())
}

/// Runs a scenario on its own input.
///
/// ```
/// use actuator_web::{run::run, scenario::Scenario};
///
/// let scenario = Scenario::parse("model=black-box-1&input.amplitude_deg=90").unwrap();
/// let trace = run(&scenario, |_| true).unwrap();
/// // 240 deg/s since 1.0175 s.
/// assert!((trace.column("angle_deg")[1_100] - 240.0 * 0.0825).abs() < 1e-9);
/// ```
///
/// # Errors
/// [`Error::Parameter`] for parameters that exclude each other, [`Error::Interrupted`].
pub fn run(scenario: &Scenario, watch: Watch) -> Result<Trace, Error> {
    let input = scenario.run.input.excitation()?;
    let mut actuator = Actuator::try_new(&scenario.run.settings)?;
    let mut trace = Trace::zeros(scenario.rows() as usize);
    for row in 0..trace.rows {
        let start = row as u64 * scenario.run.every;
        report(watch, row as u64, trace.rows as u64, scenario.run.every)?;
        let command = input.command(start).to_f64();
        trace.put(row, seconds(start), command, &actuator.reading());
        for tick in start..start + scenario.run.every {
            let command = input.command(tick).to_f64();
            actuator.advance(command, 1).map_err(|_| Error::Command)?;
        }
    }
    Ok(trace)
}

/// Runs a scenario on given commands instead, each held for `every` ticks.
///
/// # Errors
/// [`Error::TooLong`], [`Error::Command`] for one that is not finite, and those of [`run`].
pub fn follow(scenario: &Scenario, commands_deg: &[f64], watch: Watch) -> Result<Trace, Error> {
    if commands_deg.len() as u64 > MOST_ROWS {
        return Err(Error::TooLong(format!(
            "{} commands, expected at most {MOST_ROWS}",
            commands_deg.len()
        )));
    }
    let mut actuator = Actuator::try_new(&scenario.run.settings)?;
    let mut trace = Trace::zeros(commands_deg.len());
    for (row, command) in commands_deg.iter().enumerate() {
        let start = row as u64 * scenario.run.every;
        report(watch, row as u64, trace.rows as u64, scenario.run.every)?;
        trace.put(row, seconds(start), *command, &actuator.reading());
        let moved = actuator.advance(*command, scenario.run.every);
        moved.map_err(|_| Error::Command)?;
    }
    Ok(trace)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(text: &str) -> Scenario {
        Scenario::parse(text).unwrap()
    }

    #[test]
    fn an_input_and_the_same_commands_tick_by_tick_give_the_same_bits() {
        for choice in ["model=black-box-2", "model=grey-box", "plant=bench"] {
            let text = format!("{choice}&input=3211&input.start_s=0.01&duration_s=0.5&every=1");
            let scenario = scenario(&text);
            let trace = run(&scenario, |_| true).unwrap();
            assert_eq!(
                follow(&scenario, trace.column("command_deg"), |_| true),
                Ok(trace)
            );
        }
    }

    #[test]
    fn a_run_is_interrupted_and_reports_the_share_that_is_done() {
        // Every 0.1 s of 2 s, and every row where these are further apart.
        for (every, shares) in [(20, 19), (2_000, 19), (4_000, 9), (1_500, 19)] {
            let scenario = scenario(&format!("duration_s=2&every={every}"));
            thread_local! {
                static SHARES: std::cell::RefCell<Vec<f64>> = std::cell::RefCell::default();
            }
            let all: Watch = |share| {
                SHARES.with_borrow_mut(|shares_done| shares_done.push(share));
                true
            };
            run(&scenario, all).unwrap();
            let shares_done = SHARES.take();
            assert_eq!(shares_done.len(), shares, "{every}");
            assert!(
                shares_done.is_sorted()
                    && shares_done.iter().all(|share| (0.0..1.0).contains(share))
            );
            let until_half: Watch = |share| share < 0.5;
            assert_eq!(run(&scenario, until_half), Err(Error::Interrupted));
            assert_eq!(
                follow(&scenario, &[0.0; 5000], until_half),
                Err(Error::Interrupted)
            );
        }
    }

    #[test]
    fn a_command_that_is_no_number_is_refused() {
        let scenario = scenario("");
        let refused = follow(&scenario, &[0.0, f64::NAN], |_| true);
        assert_eq!(refused, Err(Error::Command));
    }

    #[test]
    fn too_many_commands_are_refused_before_anything_is_kept() {
        let commands = vec![0.0; MOST_ROWS as usize + 1];
        assert_eq!(
            follow(&scenario(""), &commands, |_| true)
                .unwrap_err()
                .code(),
            4
        );
    }

    #[test]
    fn the_bench_shows_a_current_and_the_columns_have_their_names() {
        let trace = run(&scenario("plant=bench"), |_| true).unwrap();
        assert_eq!(trace.rows(), 5000);
        assert!(trace.column("current_a").iter().any(|a| *a > 0.1));
        assert_eq!(trace.column("time_s")[4999], 4.999);
        assert!(trace.column("no such").is_empty());
    }
}
