//! Output during the run.

use std::io::Write;

use canopen::cob_id;
use host_sim::can::client::state_name;
use model_core::control::encoder_word::COUNT_DEG;
use virtual_board::can::Frame;
use virtual_board::trace::Row;

use super::Format;

/// Identifiers of the only node.
const EMERGENCY: u32 = cob_id::EMERGENCY + 1;
const TPDO_2: u32 = cob_id::tpdo(2) + 1;
const TPDO_3: u32 = cob_id::tpdo(3) + 1;

/// PWM periods from one line of the plot to the next.
const PLOT_EVERY: u64 = 50;

/// Columns of the plot's axis, and the angle at its ends.
const COLUMNS: usize = 61;
const END_DEG: f64 = 90.0;

/// Prints rows.
#[derive(Debug)]
pub(super) struct RowPrinter {
    format: Format,
    period: u64,
    /// The last statusword of the board.
    statusword: u16,
    /// Number of the first latched fault, 0 without a fault.
    fault: u8,
}

impl RowPrinter {
    pub fn new(format: Format) -> Self {
        Self {
            format,
            period: 0,
            statusword: 0,
            fault: 0,
        }
    }

    /// Updates statusword and fault from TPDOs and EMCY.
    fn update(&mut self, frame: &Frame) {
        let [a, b, _, d, e, _, g, h] = frame.data;
        match frame.id.value() {
            // An instance from 80h on is 80h and the number of a fault.
            EMERGENCY if (a, b) != (0, 0) && d > 0x80 && self.fault == 0 => self.fault = d - 0x80,
            // TPDO 2 ends with the statusword.
            TPDO_2 => self.statusword = u16::from_le_bytes([g, h]),
            // TPDO 3: statusword, mode, error code.
            TPDO_3 if (d, e) == (0, 0) => self.fault = 0,
            _ => {}
        }
    }

    /// Prints the row if it is due; returns whether standard output is still open.
    pub fn row(&mut self, row: &Row, angle_deg: Option<f64>, sent: &[(u64, Frame)]) -> bool {
        sent.iter().for_each(|(_, frame)| self.update(frame));
        let is_first = self.period == 0;
        let is_due = self.period.is_multiple_of(PLOT_EVERY);
        self.period += 1;
        let mut out = std::io::stdout().lock();
        let written = match self.format {
            Format::None => Ok(()),
            Format::Plot if is_due => writeln!(out, "{}", self.line(row, angle_deg)),
            Format::Plot => Ok(()),
            Format::Csv => {
                let header = "time_s,command_deg,angle_deg,angle_meas_deg,rate_deg_s,current_a,\
                              supply_v,statusword,fault";
                let header_written = if is_first {
                    writeln!(out, "{header}")
                } else {
                    Ok(())
                };
                header_written.and_then(|()| writeln!(out, "{}", self.values(row, angle_deg)))
            }
        };
        written.is_ok()
    }

    /// The command is empty before the first one.
    fn values(&self, row: &Row, command_deg: Option<f64>) -> String {
        let (statusword, fault) = (self.statusword, self.fault);
        format!(
            "{:.3},{},{},{},{},{},{},{statusword},{fault}",
            row.at_ns as f64 * 1e-9,
            text(command_deg),
            row.angle_deg,
            text(encoder_deg(row)),
            row.rate_deg_s,
            row.current_a,
            row.supply_v,
        )
    }

    /// Time, an axis with measured and commanded angle, current, state and fault.
    fn line(&self, row: &Row, angle_deg: Option<f64>) -> String {
        let mut axis = vec!['·'; COLUMNS];
        axis[COLUMNS / 2] = '|';
        if let Some(deg) = angle_deg {
            axis[column(deg)] = '+';
        }
        axis[column(row.angle_deg)] = 'o';
        let axis: String = axis.into_iter().collect();
        let (state, fault) = (state_name(self.statusword), self.fault);
        format!(
            "{:8.2} s {axis} {:8.2} deg {:6.2} A  {state}, fault {fault}",
            row.at_ns as f64 * 1e-9,
            row.angle_deg,
            row.current_a,
        )
    }
}

/// The encoder's angle, within half a turn of zero; `None` if its word is not valid.
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
