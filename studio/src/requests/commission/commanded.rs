//! A link that reports in words what is commanded through it, so that a page shows how far a
//! commissioning is.

use std::io;
use std::time::Duration;

use canopen::{CanFrame, cob_id};
use host_sim::can::link::Link;

/// The link.
pub struct Reporting<L> {
    link: L,
    report: Box<dyn FnMut(&str) + Send>,
    /// The last report: a command that is repeated is no news.
    last: String,
}

impl<L> Reporting<L> {
    /// `report` gets each report.
    pub fn new(link: L, report: impl FnMut(&str) + Send + 'static) -> Self {
        Self {
            link,
            report: Box::new(report),
            last: String::new(),
        }
    }
}

/// What an SDO request commands, if it moves the shaft or records it.
fn commanded(frame: &CanFrame) -> Option<String> {
    /// An expedited download of as many bytes as the object has.
    const EXPEDITED: u8 = 0x22;
    let [command, low, high, sub, value @ ..] = frame.bytes();
    let (function, _) = cob_id::split(frame.raw_id().0);
    if function != cob_id::SDO_REQUEST || command & 0xE2 != EXPEDITED {
        return None;
    }
    let whole = i32::from_le_bytes(value);
    let half = i16::from_le_bytes([value[0], value[1]]);
    match (u16::from_le_bytes([low, high]), sub) {
        (0x6071, 0) if half != 0 => {
            let percent = f64::from(half) / 10.0;
            Some(format!("torque of {percent} % of the rated torque"))
        }
        (0x607A, 0) => Some(format!("motion to {:.1} deg", f64::from(whole) * 1e-3)),
        (0x6081, 0) => Some(format!("rate of {:.0} deg/s", f64::from(whole) * 1e-3)),
        (0x2020, 1) if value[0] != 0 => Some("excitation".to_owned()),
        (0x2030, 1) if value[0] == 0 => Some("recording uploaded".to_owned()),
        _ => None,
    }
}

impl<L: Link> Link for Reporting<L> {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.link.send(frame)?;
        if let Some(text) = commanded(frame).filter(|text| *text != self.last) {
            (self.report)(&text);
            self.last = text;
        }
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        self.link.receive(timeout)
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.link.pause(time)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use embedded_can::{Frame as _, StandardId};

    /// A bus that takes everything.
    struct Silent;

    impl Link for Silent {
        fn send(&mut self, _: &CanFrame) -> io::Result<()> {
            Ok(())
        }

        fn receive(&mut self, _: Duration) -> io::Result<Option<CanFrame>> {
            Ok(None)
        }
    }

    #[test]
    fn each_new_command_is_reported_once() {
        let reports = Arc::<Mutex<Vec<String>>>::default();
        let kept = Arc::clone(&reports);
        let mut link = Reporting::new(Silent, move |text| {
            kept.lock().unwrap().push(text.to_owned());
        });
        for data in [
            // The torque is 0 and its slope is no command.
            [0x2B, 0x71, 0x60, 0, 0, 0, 0, 0],
            [0x23, 0x87, 0x60, 0, 1, 0, 0, 0],
            [0x2B, 0x71, 0x60, 0, 0x9C, 0xFF, 0, 0],
            [0x2B, 0x71, 0x60, 0, 0x9C, 0xFF, 0, 0],
            [0x23, 0x7A, 0x60, 0, 0xA8, 0xA6, 0xFF, 0xFF],
            // Read, and written in segments.
            [0x40, 0x7A, 0x60, 0, 0, 0, 0, 0],
            [0x21, 0x20, 0x20, 1, 1, 0, 0, 0],
            [0x2F, 0x20, 0x20, 1, 1, 0, 0, 0],
        ] {
            let id = StandardId::new(0x601).unwrap();
            link.send(&CanFrame::new(id, &data).unwrap()).unwrap();
        }
        // The same bytes in a TPDO.
        let id = StandardId::new(0x181).unwrap();
        let frame = CanFrame::new(id, &[0x2B, 0x71, 0x60, 0, 1, 0, 0, 0]).unwrap();
        link.send(&frame).unwrap();
        assert_eq!(
            *reports.lock().unwrap(),
            [
                "torque of -10 % of the rated torque",
                "motion to -22.9 deg",
                "excitation"
            ]
        );
    }
}
