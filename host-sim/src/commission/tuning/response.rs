//! The frequency response at the lines of a multisine, from whole periods of it.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::super::PERIOD_S;
use super::twin::Record;

/// Lines of the multisine: its odd multiples 1 to 15.
pub const LINES: usize = 8;

/// A multisine whose period is a whole number of control periods.
#[derive(Debug, Clone, Copy)]
pub struct Multisine {
    /// Control periods of a period.
    pub period: usize,
    /// Its periods; the first one is not evaluated.
    pub periods: usize,
}

/// Base frequencies, mHz, whose periods are whole numbers of control periods.
const BASES_MHZ: [i32; 7] = [200, 250, 400, 500, 625, 1000, 1250];

/// Time of an excitation, s: at least two periods beside the first one.
const TIME_S: f64 = 8.0;

impl Multisine {
    /// The lowest one whose lines reach this frequency, Hz, and its base frequency, mHz.
    pub fn reaching(hz: f64) -> (Self, i32) {
        let last = 2 * LINES as i32 - 1;
        let reaches = |mhz: &&i32| f64::from(**mhz * last) * 1e-3 >= hz;
        let mhz = BASES_MHZ.iter().find(reaches).or(BASES_MHZ.last());
        let mhz = mhz.copied().unwrap_or(1000);
        let period_s = 1e3 / f64::from(mhz);
        let sine = Self {
            period: (period_s / PERIOD_S).round() as usize,
            periods: ((TIME_S / period_s) as usize).max(3),
        };
        (sine, mhz)
    }

    /// The frequency of a line, Hz.
    pub fn line_hz(&self, line: usize) -> f64 {
        (2 * line + 1) as f64 / (self.period as f64 * PERIOD_S)
    }

    /// The coefficients of the lines in each evaluated period of a signal; `None` where the records
    /// from `start` on are too few.
    fn coefficients(
        &self,
        records: &[Record],
        start: usize,
        signal: impl Fn(&Record) -> f64,
    ) -> Option<Vec<[Complex64; LINES]>> {
        let end = start + self.period * self.periods;
        let evaluated = records.get(start + self.period..end)?;
        let of_period = |period: &[Record]| {
            std::array::from_fn(|line| {
                let turn = TAU * (2 * line + 1) as f64 / self.period as f64;
                let terms = period.iter().enumerate();
                terms.fold(Complex64::ZERO, |sum, (k, record)| {
                    sum + Complex64::from_polar(signal(record), -turn * k as f64)
                })
            })
        };
        Some(evaluated.chunks_exact(self.period).map(of_period).collect())
    }
}

/// A response at the lines.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// From voltage to angle, deg/V.
    pub motor: [Complex64; LINES],
    /// Its relative standard errors, by the differences between the periods.
    pub motor_errors: [f64; LINES],
    /// From command to angle.
    pub closed: [Complex64; LINES],
}

impl Response {
    /// Of records whose multisine starts at a place.
    pub fn of(records: &[Record], sine: &Multisine, start: usize) -> Option<Self> {
        let angles = sine.coefficients(records, start, |record| record.angle_deg)?;
        let voltages = sine.coefficients(records, start, |record| record.voltage_v)?;
        let command = |record: &Record| f64::from(record.command_mdeg) * 1e-3;
        let commands = sine.coefficients(records, start, command)?;
        let sum = |values: &[[Complex64; LINES]], line: usize| {
            values.iter().map(|lines| lines[line]).sum::<Complex64>()
        };
        let ratio = |of: &[[Complex64; LINES]], by: &[[Complex64; LINES]]| {
            std::array::from_fn(|line| sum(of, line) / sum(by, line))
        };
        let motor: [Complex64; LINES] = ratio(&angles, &voltages);
        let motor_errors = std::array::from_fn(|line| {
            let pairs = angles.iter().zip(&voltages);
            let ratios = pairs.map(|(angle, voltage)| angle[line] / voltage[line] / motor[line]);
            let squares: f64 = ratios.map(|ratio| (ratio - 1.0).norm_sqr()).sum();
            let count = angles.len() as f64;
            (squares / (count * (count - 1.0))).sqrt()
        });
        Some(Self {
            motor,
            motor_errors,
            closed: ratio(&angles, &commands),
        })
    }
}
