//! Octave and scipy read the files (`host-sim/tests/files/ci.sh`); what no test can write is here.

use super::*;

#[test]
fn the_greatest_number_of_rows_is_that_of_two_gibibytes() {
    // Only the layout is checked: no data are written into the sparse file.
    let sized = |rows: u64| {
        let names = ["time_s", "a", "b", "c", "d", "e", "f", "g"];
        let description = Description::default();
        let value = variable(&names, rows, &description);
        layout::write(Holes::default(), "trace", &value).map(|(file, _)| file.end)
    };
    let most = most_rows(8);
    assert!(sized(most).expect("it goes") <= i32::MAX as u64);
    assert!(sized(2 * most).expect("the length fits its field") > i32::MAX as u64);
    assert!(sized(3 * most).is_err(), "too long for the length field");
}

/// A file of which only the end is known.
#[derive(Default)]
struct Holes {
    at: u64,
    end: u64,
}

impl Write for Holes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.seek(SeekFrom::Current(bytes.len() as i64))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Holes {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.at.wrapping_add_signed(by),
            SeekFrom::End(by) => self.end.wrapping_add_signed(by),
        };
        self.end = self.end.max(self.at);
        Ok(self.at)
    }
}
