//! What is printed while the board runs.

use std::io::Write;

use model_core::control::encoder_word::COUNT_DEG;
use virtual_board::can::Frame;
use virtual_board::trace::Row;

use super::Format;

/// PWM periods from one line of the plot to the next.
const PLOT_EVERY: u64 = 50;

/// Columns of the plot's axis, and what its ends stand for.
const COLUMNS: usize = 61;
const END_DEG: f64 = 90.0;

/// Prints rows.
#[derive(Debug)]
pub(super) struct Show {
    format: Format,
    period: u64,
    /// State and fault as the board told them last.
    status: (u8, u8),
}

impl Show {
    pub fn new(format: Format) -> Self {
        Self {
            format,
            period: 0,
            status: (0, 0),
        }
    }

    /// Whether the board has told that it is past its start: state 0 is the start itself.
    pub fn is_started(&self) -> bool {
        self.status.0 != 0
    }

    /// Prints a row if it is its turn; whether somebody still reads.
    pub fn row(&mut self, row: &Row, angle_deg: Option<f64>, heard: &[(u64, Frame)]) -> bool {
        for (_, frame) in heard.iter().filter(|(_, frame)| frame.id.value() == 0x181) {
            self.status = (frame.data[6], frame.data[7]);
        }
        let is_first = self.period == 0;
        let is_turn = self.period.is_multiple_of(PLOT_EVERY);
        self.period += 1;
        let mut out = std::io::stdout().lock();
        let written = match self.format {
            Format::None => Ok(()),
            Format::Plot if is_turn => writeln!(out, "{}", self.line(row, angle_deg)),
            Format::Plot => Ok(()),
            Format::Csv => {
                let header = "time_s,command_deg,angle_deg,angle_meas_deg,rate_deg_s,current_a,\
                              supply_v,state,fault";
                let begun = if is_first {
                    writeln!(out, "{header}")
                } else {
                    Ok(())
                };
                begun.and_then(|()| writeln!(out, "{}", self.values(row, angle_deg)))
            }
        };
        written.is_ok()
    }

    /// Empty where nothing is commanded yet.
    fn values(&self, row: &Row, command_deg: Option<f64>) -> String {
        let (state, fault) = self.status;
        format!(
            "{:.3},{},{},{},{},{},{},{state},{fault}",
            row.at_ns as f64 * 1e-9,
            text(command_deg),
            row.angle_deg,
            text(encoder_deg(row)),
            row.rate_deg_s,
            row.current_a,
            row.supply_v,
        )
    }

    /// Time, angle on its axis with the commanded one, current, state and fault.
    fn line(&self, row: &Row, angle_deg: Option<f64>) -> String {
        let mut axis = vec!['·'; COLUMNS];
        axis[COLUMNS / 2] = '|';
        if let Some(deg) = angle_deg {
            axis[column(deg)] = '+';
        }
        axis[column(row.angle_deg)] = 'o';
        let axis: String = axis.into_iter().collect();
        let (state, fault) = self.status;
        format!(
            "{:8.2} s {axis} {:8.2} deg {:6.2} A  state {state} fault {fault}",
            row.at_ns as f64 * 1e-9,
            row.angle_deg,
            row.current_a,
        )
    }
}

/// What the encoder shows, within half a turn of zero; nothing where its word is not valid.
fn encoder_deg(row: &Row) -> Option<f64> {
    let count = i32::from(row.sensed.encoder.word().read().ok()?.count.get());
    Some(f64::from(count - ((count & 0x800) << 1)) * COUNT_DEG)
}

fn text(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

fn column(deg: f64) -> usize {
    let share = (deg.clamp(-END_DEG, END_DEG) + END_DEG) / (2.0 * END_DEG);
    (share * (COLUMNS - 1) as f64).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_ends_at_its_columns() {
        assert_eq!(
            [-1e9, -90.0, 0.0, 90.0, 1e9].map(column),
            [0, 0, 30, 60, 60]
        );
    }
}
