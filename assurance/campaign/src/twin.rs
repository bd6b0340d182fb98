//! The undisturbed twin of an experiment: the same board, in a copy without an injection.

use virtual_board::run::View;
use virtual_board::trace::Row;

use crate::fork::Reporter;
use crate::injector::Injector;

/// Time between two digests of the state, ms: two control periods.
pub const DIGEST_MS: u32 = 8;

/// Bytes of a sample in a report.
const SAMPLE_BYTES: usize = 16;

/// The twin at the start of a millisecond.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sample {
    /// Angle of the shaft, deg.
    pub angle_deg: f64,
    /// Digest of program and plant, 0 in those milliseconds that have none.
    pub state: u64,
}

/// The twin, a sample each millisecond after power-on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Twin {
    samples: Vec<Sample>,
}

impl Twin {
    /// Adds the sample of the next millisecond, whose state is not known yet.
    fn add(&mut self, angle_deg: f64) {
        self.samples.push(Sample {
            angle_deg,
            state: 0,
        });
    }

    /// Sets the state of the last sample.
    fn set_state(&mut self, state: u64) {
        if let Some(sample) = self.samples.last_mut() {
            sample.state = state;
        }
    }

    /// The state in this millisecond; `None` if it has none.
    pub fn state(&self, ms: u32) -> Option<u64> {
        let state = self.samples.get(ms as usize)?.state;
        (state != 0).then_some(state)
    }

    /// The angles, deg.
    pub fn angles(&self) -> impl Iterator<Item = f64> {
        self.samples.iter().map(|sample| sample.angle_deg)
    }

    /// The twin as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let sample = |sample: &Sample| {
            let words = [sample.angle_deg.to_bits(), sample.state];
            words.map(u64::to_le_bytes).concat()
        };
        self.samples.iter().flat_map(sample).collect()
    }

    /// The twin of these bytes.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let word = |bytes: &[u8], index: usize| {
            let word = bytes[8 * index..].first_chunk().copied();
            u64::from_le_bytes(word.unwrap_or_default())
        };
        let samples = bytes.chunks_exact(SAMPLE_BYTES).map(|bytes| Sample {
            angle_deg: f64::from_bits(word(bytes, 0)),
            state: word(bytes, 1),
        });
        Self {
            samples: samples.collect(),
        }
    }
}

/// Records the twin.
#[derive(Debug)]
pub struct Recorder {
    twin: Twin,
    /// The plant in the last millisecond, if a digest of the program was requested in it.
    digested: Option<Row>,
    until_ms: u32,
    reporter: Option<Reporter>,
}

impl Recorder {
    /// Records until this time after power-on, and reports the twin.
    pub fn new(until_ms: u32, reporter: Reporter) -> Self {
        Self {
            twin: Twin::default(),
            digested: None,
            until_ms,
            reporter: Some(reporter),
        }
    }

    /// Records this millisecond. At the end, it ends this process.
    pub fn record(&mut self, view: &View<'_>, ms: u32, injector: &Injector) {
        let row = view.row;
        if let (Some(state), Some(row)) = (injector.take_digest(), self.digested.take()) {
            self.twin.set_state(with_plant(state, &row));
        }
        self.twin.add(row.angle_deg);
        if ms.is_multiple_of(DIGEST_MS) {
            injector.request_digest();
            self.digested = Some(*row);
        }
        if let Some(reporter) = self.reporter.take_if(|_| ms >= self.until_ms) {
            reporter.end(&self.twin.to_bytes());
        }
    }
}

/// The digest of program and plant: two boards with the same go on alike.
pub fn with_plant(program: u64, row: &Row) -> u64 {
    let plant = [row.angle_deg, row.rate_deg_s, row.current_a, row.supply_v];
    let mixed = plant.iter().fold(program, |mixed, value| {
        // Multiplication by an odd number and a rotation lose no bit.
        (mixed ^ value.to_bits())
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(29)
    });
    mixed.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twin_is_the_same_after_its_way_as_bytes() {
        let mut twin = Twin::default();
        twin.add(1.5);
        twin.set_state(7);
        twin.add(-2.25);
        let again = Twin::from_bytes(&twin.to_bytes());
        assert_eq!(again, twin);
        assert_eq!(
            [again.state(0), again.state(1), again.state(2)],
            [Some(7), None, None]
        );
        assert_eq!(again.angles().collect::<Vec<_>>(), [1.5, -2.25]);
    }
}
