//! Makes a recording of the columns of a file, with notes about its irregularities.

use super::{
    Import, Imported, Note, Quantity, Table,
    clipping::{self, Clipped},
    column::LocatedColumn,
    times, turns, unit,
};
use model_core::parameter::Shown;

use crate::{
    data::ImportError,
    recording::Recording,
    screening::{self, GAP_STEPS},
    statistics::slots::median_step_of_s,
};

/// What is counted, one and several.
const ROWS: (&str, &str) = ("row has", "rows have");
const SAMPLES: (&str, &str) = ("sample has", "samples have");
/// First time above which times are relative to the first sample: dates would lose digits.
const LATEST_START_S: f64 = 1e6;
/// Greatest duty, with the error of a measured one.
const MOST_DUTY_PCT: f64 = 102.0;

/// The recording in these columns of a table.
pub fn recording(
    import: &Import,
    table: &Table,
    columns: &[LocatedColumn],
    ambiguous: Vec<String>,
) -> Result<Imported, ImportError> {
    let mut cleaning = Cleaning {
        table,
        columns,
        notes: Vec::new(),
    };
    for (line, text) in table.notes.clone() {
        cleaning.note(line, text);
    }
    for text in ambiguous {
        cleaning.note(table.header_line, text);
    }
    cleaning.note_units();
    let time = match import.rate_hz {
        Some(rate_hz) => (0..table.len()).map(|row| row as f64 / rate_hz).collect(),
        None => cleaning.times()?,
    };
    let (rows, time_s) = cleaning.rows(&time, import.window_s)?;
    let take = |cleaning: &Cleaning<'_>, quantity| {
        let column = cleaning.column(quantity)?;
        Ok::<_, ImportError>(column.map(|column| rows.iter().map(|&row| column[row]).collect()))
    };
    let name = table.path.file_name().unwrap_or_default().to_string_lossy();
    let mut constants = table.constants.clone();
    constants.extend(import.constants.clone());
    let mut recording = Recording {
        name: name.into_owned(),
        time_s,
        command_deg: take(&cleaning, Quantity::Command)?.unwrap_or_default(),
        angle_deg: take(&cleaning, Quantity::Angle)?.unwrap_or_default(),
        rate_deg_s: take(&cleaning, Quantity::Rate)?,
        duty_pct: take(&cleaning, Quantity::Duty)?,
        current_ma: take(&cleaning, Quantity::Current)?,
        supply_v: take(&cleaning, Quantity::Supply)?,
        motor_on: take(&cleaning, Quantity::Enabled)?,
        hold: import.hold,
        constants,
    };
    recording.duty_pct = recording.duty_pct.filter(|duty| cleaning.is_duty(duty));
    if !columns.iter().any(|c| c.quantity == Quantity::Command) {
        let first = recording.angle_deg.iter().find(|angle| angle.is_finite());
        recording.command_deg = vec![first.copied().unwrap_or(0.0); rows.len()];
        let text = "no column is known to be the command, which the models do not need".to_owned();
        cleaning.note(table.header_line, text);
    }
    cleaning.check_signals(&mut recording, &rows, import);
    cleaning.notes.sort_by_key(|note| note.line);
    Ok(Imported {
        recording,
        notes: cleaning.notes,
    })
}

struct Cleaning<'a> {
    table: &'a Table,
    columns: &'a [LocatedColumn],
    notes: Vec<Note>,
}

impl Cleaning<'_> {
    fn note(&mut self, line: u64, text: String) {
        self.notes.push(Note {
            path: self.table.path.clone(),
            line,
            text,
        });
    }

    /// Notes the units that are assumed, and those that are lengths.
    fn note_units(&mut self) {
        for located in self
            .columns
            .iter()
            .filter(|column| column.quantity.is_angle())
        {
            let (name, column) = (located.quantity.name(), &self.table.names[located.index]);
            if located.is_length {
                let text =
                    format!("column `{column}` is a length: mm stand for deg in all results");
                self.note(self.table.header_line, text);
            } else if located.is_counts {
                let text = format!(
                    "column `{column}` has no unit and whole numbers: counts of 4096 a turn are \
                     assumed; --column {name}={column}:UNIT sets another"
                );
                self.note(self.table.header_line, text);
            } else if located.usual_unit.is_some()
                || (located.factor.is_none() && !self.table.radians)
            {
                let unit = located.usual_unit.unwrap_or("deg");
                let text = format!(
                    "column `{column}` has no unit, {unit} is assumed; --column \
                     {name}={column}:UNIT sets another"
                );
                self.note(self.table.header_line, text);
            }
        }
    }

    fn located(&self, quantity: Quantity) -> Option<LocatedColumn> {
        self.columns
            .iter()
            .copied()
            .find(|located| located.quantity == quantity)
    }

    /// A column in the unit of the recording.
    fn column(&self, quantity: Quantity) -> Result<Option<Vec<f64>>, ImportError> {
        let Some(located) = self.located(quantity) else {
            return Ok(None);
        };
        let usual = match quantity {
            Quantity::Current => "a",
            Quantity::Command | Quantity::Angle if self.table.radians => "rad",
            Quantity::Rate if self.table.radians => "rad/s",
            _ => "",
        };
        let factor = located
            .factor
            .or_else(|| unit::factor(quantity, usual))
            .unwrap_or(1.0);
        let column = self.numbers(located)?.iter();
        Ok(Some(column.map(|value| value * factor).collect()))
    }

    /// A column in its own unit.
    fn numbers(&self, located: LocatedColumn) -> Result<&[f64], ImportError> {
        let column = &self.table.columns[located.index];
        if let Some(row) = column.iter().position(|value| value.is_infinite()) {
            let (name, number) = (&self.table.names[located.index], located.index + 1);
            let problem = match self.table.texts.get(&located.index) {
                Some(text) => {
                    format!("column {number} (`{name}`) is `{text}`, expected a finite number")
                }
                None => format!("column {number} (`{name}`) is not a finite number"),
            };
            return Err(self.table.problem(self.table.line(row), problem));
        }
        Ok(column)
    }

    /// The times of all rows, s.
    fn times(&mut self) -> Result<Vec<f64>, ImportError> {
        let Some(located) = self.located(Quantity::Time) else {
            return Ok(Vec::new());
        };
        let column = self.numbers(located)?;
        let judged = match located.factor {
            Some(_) => None,
            None => times::unit(column),
        };
        let factor = located
            .factor
            .or(judged.map(|(_, factor)| factor))
            .unwrap_or(1.0);
        // Before the conversion: differences of large times are exact, their multiples are not.
        let first = column.iter().find(|value| !value.is_nan());
        let first = first.copied().unwrap_or(0.0);
        let is_late = first * factor > LATEST_START_S;
        let origin = if is_late { first } else { 0.0 };
        let mut times: Vec<f64> = column.iter().map(|t| (t - origin) * factor).collect();
        let line = self.table.header_line;
        if let Some((unit, _)) = judged {
            let name = &self.table.names[located.index];
            let text = format!(
                "the time in column `{name}` has no unit: by the steps of its samples it is in \
                 {unit}; --column time={name}:UNIT sets another"
            );
            self.note(line, text);
        }
        let angle = self.located(Quantity::Angle);
        let angle = angle.map_or(&[][..], |angle| &self.table.columns[angle.index]);
        if let Some(count) = times::spread(&mut times, angle) {
            let text = format!(
                "{count} rows have the time of the row before and another angle: the clock is \
                 coarser than the samples, which are spread evenly over its steps"
            );
            self.note(line, text);
        }
        Ok(times)
    }

    /// Whether these can be duties, %; notes it otherwise.
    fn is_duty(&mut self, duty_pct: &[f64]) -> bool {
        let most = duty_pct
            .iter()
            .fold(0.0_f64, |most, duty| most.max(duty.abs()));
        if let Some(located) = self
            .located(Quantity::Duty)
            .filter(|_| most > MOST_DUTY_PCT)
        {
            let name = &self.table.names[located.index];
            let text = format!(
                "column `{name}` reaches {most} %, expected at most 100: it is left out; --column \
                 duty={name}:FACTOR, the % of one unit, sets its unit"
            );
            self.note(self.table.header_line, text);
        }
        most <= MOST_DUTY_PCT
    }

    /// The rows with a valid time, and their times.
    fn rows(
        &mut self,
        time: &[f64],
        window: Option<(f64, f64)>,
    ) -> Result<(Vec<usize>, Vec<f64>), ImportError> {
        let (mut rows, mut times): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
        let (mut missing, mut duplicates) = (Tally::default(), Tally::default());
        let mut latest = f64::NEG_INFINITY;
        for (row, &t) in time.iter().enumerate() {
            if t.is_nan() {
                missing.count(row);
                continue;
            }
            if t < latest {
                let problem = format!(
                    "the time is {} s after {} s, expected times that do not decrease",
                    Shown(t),
                    Shown(latest)
                );
                return Err(self.table.problem(self.table.line(row), problem));
            }
            let is_duplicate = t == latest;
            latest = t;
            // A message about something else, where each message is a row.
            if self.is_empty(row) {
                continue;
            }
            if window.is_some_and(|(from, to)| t < from || t > to) {
                continue;
            }
            if is_duplicate && times.last() == Some(&t) {
                // The later row is the newer one.
                duplicates.count(row);
                rows.pop();
                times.pop();
            }
            rows.push(row);
            times.push(t);
        }
        self.tally(&missing, ROWS, "no time: left out");
        self.tally(
            &duplicates,
            ROWS,
            "the time of the row before, which is left out",
        );
        self.note_gaps(&rows, &times);
        Ok((rows, times))
    }

    /// Whether a row has no number but its time.
    fn is_empty(&self, row: usize) -> bool {
        let numbers = self.columns.iter().filter(|c| c.quantity != Quantity::Time);
        let mut numbers = numbers.map(|column| self.table.columns[column.index][row]);
        numbers.all(f64::is_nan)
    }

    fn tally(&mut self, tally: &Tally, (one, several): (&str, &str), text: &str) {
        if tally.rows > 0 {
            let what = if tally.rows == 1 { one } else { several };
            let text = format!("{} {what} {text}; this is the first", tally.rows);
            self.note(self.table.line(tally.first), text);
        }
    }

    /// Brings the command to the turns of an unwrapped angle: as it is, or unwrapped as well, and
    /// by whole turns, whichever is closer to the angle. Its jumps may be steps of nearly a turn.
    fn follow_turns(&mut self, recording: &mut Recording, rows: &[usize], angle_line: u64) {
        let mut unwrapped = recording.command_deg.clone();
        let wrapped = turns::unwrap(&mut unwrapped);
        let angle = &recording.angle_deg;
        let as_it_is = turns::nearest(&recording.command_deg, angle);
        let unwrapped = turns::nearest(&unwrapped, angle);
        if let Some((index, turns)) = wrapped.filter(|_| unwrapped.1 < as_it_is.1) {
            let text = format!("the command jumps by a turn, {turns} times: it is unwrapped");
            self.note(self.table.line(rows[index]), text);
            recording.command_deg = unwrapped.0;
        } else if as_it_is.2 != 0.0 {
            let text = "the command is a turn from the angle: it is moved by a turn".to_owned();
            self.note(angle_line, text);
            recording.command_deg = as_it_is.0;
        }
    }

    fn note_gaps(&mut self, rows: &[usize], times: &[f64]) {
        let angle = self.located(Quantity::Angle);
        let angle = angle.map_or(&[][..], |angle| &self.table.columns[angle.index]);
        let angle: Vec<f64> = rows
            .iter()
            .filter_map(|row| angle.get(*row).copied())
            .collect();
        let Some(usual_s) = median_step_of_s(times, &angle) else {
            return;
        };
        let steps = times.windows(2).map(|t| t[1] - t[0]).enumerate();
        let gaps: Vec<(usize, f64)> = steps.filter(|(_, s)| *s > GAP_STEPS * usual_s).collect();
        let Some(&(located, longest_s)) = gaps.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return;
        };
        let gaps = match gaps.len() {
            1 => "1 gap".to_owned(),
            count => format!("{count} gaps"),
        };
        let text = format!(
            "{gaps} without samples; the longest, before this line, lasts {longest_s:.4} s \
             where {usual_s:.4} s are usual; the command is assumed constant there"
        );
        self.note(self.table.line(rows[located + 1]), text);
    }

    /// Notes missing and clipped samples and wrapped angles, and corrects them.
    fn check_signals(&mut self, recording: &mut Recording, rows: &[usize], import: &Import) {
        let keep_clipped = import.keep_clipped;
        for (what, column) in [
            (
                "command, which keeps its last value",
                &recording.command_deg,
            ),
            ("angle, which is not compared there", &recording.angle_deg),
        ] {
            let mut missing = Tally::default();
            let absent = (0..rows.len()).filter(|&i| column[i].is_nan());
            absent.for_each(|i| missing.count(rows[i]));
            self.tally(&missing, SAMPLES, &format!("no {what}"));
        }
        let is_length = self.columns.iter().any(|column| column.is_length);
        let wrapped = match is_length {
            true => None,
            false => turns::unwrap(&mut recording.angle_deg),
        };
        if let Some((index, turns)) = wrapped {
            let text = format!("the angle jumps by a turn, {turns} times: it is unwrapped");
            let line = self.table.line(rows[index]);
            self.note(line, text);
            self.follow_turns(recording, rows, line);
        }
        let mut off = Tally::default();
        let motor_on = recording.motor_on.iter().flatten().enumerate();
        motor_on
            .filter(|(_, on)| **on == 0.0)
            .for_each(|(i, _)| off.count(rows[i]));
        self.tally(
            &off,
            SAMPLES,
            "the motor off: only models of a motor with a load are compared there",
        );
        for bad in screening::bad_samples(recording) {
            let text = bad.described(recording, import.keep_bad);
            self.note(self.table.line(rows[bad.samples.start]), text);
            if !import.keep_bad {
                screening::leave_out(recording, &[bad]);
            }
        }
        // The command determines the angle only while the motor is on.
        let driven = driven(recording);
        for clipped in clipping::find(&recording.command_deg, &driven) {
            let Clipped { samples, angle_deg } = clipped.clone();
            let count = samples.len();
            let consequence = if keep_clipped {
                "they are compared nevertheless"
            } else {
                "they are not compared; --keep-clipped compares them"
            };
            let text = format!(
                "{count} samples stay at {angle_deg:.3} deg, an end of the range of angles, while the \
                 actuator should move: a hard stop, or a clipped sensor; {consequence}"
            );
            self.note(self.table.line(rows[samples.start]), text);
            if !keep_clipped {
                recording.angle_deg[samples].fill(f64::NAN);
            }
        }
    }
}

/// The angles while the motor is on, NaN otherwise.
fn driven(recording: &Recording) -> Vec<f64> {
    let mut angles = recording.angle_deg.clone();
    for (angle, on) in angles.iter_mut().zip(recording.motor_on.iter().flatten()) {
        if *on == 0.0 {
            *angle = f64::NAN;
        }
    }
    angles
}

/// Number of rows with an irregularity, and the first of them.
#[derive(Default)]
struct Tally {
    rows: usize,
    first: usize,
}

impl Tally {
    fn count(&mut self, row: usize) {
        if self.rows == 0 {
            self.first = row;
        }
        self.rows += 1;
    }
}
