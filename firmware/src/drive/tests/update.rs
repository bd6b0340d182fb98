//! Images over the bus, and the decisions about them.

use bootloader::{ACTUATOR_BOARD, HEADER_SIZE, Header, Outcome, Policy, Version};
use canopen::Abort;

use super::*;
use crate::drive::{Image, Slots, StageError, UpdateOrder};

const DEVICE_STATE: u32 = 0x0800_0022;

fn slots(is_confirmed: bool) -> Slots {
    Slots {
        identity: 77,
        version: Version(5),
        policy: Policy {
            hardware: ACTUATOR_BOARD,
            floor: Version(5),
        },
        capacity: 4 * 4000,
        outcome: Outcome::None,
        is_confirmed,
        staged: None,
    }
}

fn bench(is_confirmed: bool) -> Bench {
    let mut bench = Bench::new();
    bench.actuator.device.drive.set_slots(slots(is_confirmed));
    bench
}

fn header(version: u32) -> Header {
    Header {
        length: 96,
        hardware: ACTUATOR_BOARD,
        version: Version(version),
        replaces: Version::default(),
        program_crc: 0,
        key: 0,
        hash: [0; 64],
        signature: [0; 64],
    }
}

/// An image whose program is zeros.
fn image(header: &Header) -> Vec<u8> {
    let mut image = header.bytes().to_vec();
    image.resize((HEADER_SIZE + header.length) as usize, 0);
    image
}

impl Bench {
    /// Loads an image by segments; returns the abort code of the refusal.
    fn load(&mut self, image: &[u8]) -> Result<(), u32> {
        let refused = |answer: [u8; 8]| {
            let [command, _, _, _, a, b, c, d] = answer;
            (command == 0x80)
                .then_some(u32::from_le_bytes([a, b, c, d]))
                .map_or(Ok(()), Err)
        };
        let [a, b, c, d] = (image.len() as u32).to_le_bytes();
        refused(self.sdo([0x21, 0x50, 0x1f, 1, a, b, c, d]))?;
        let count = image.chunks(7).len();
        for (number, bytes) in image.chunks(7).enumerate() {
            let mut request = [0; 8];
            let is_last = u8::from(number + 1 == count);
            request[0] = (number as u8 & 1) << 4 | (7 - bytes.len() as u8) << 1 | is_last;
            request[1..=bytes.len()].copy_from_slice(bytes);
            refused(self.sdo(request))?;
        }
        Ok(())
    }

    /// Takes the image from the drive as the program of the board does.
    fn stage(&mut self, result: Result<(), StageError>) -> Vec<u8> {
        let drive = &mut self.actuator.device.drive;
        let Some(UpdateOrder::Stage { buffer, length }) = drive.take_update() else {
            panic!("no image");
        };
        let bytes = buffer.iter().flat_map(|word| word.to_le_bytes());
        let bytes = bytes.take(length as usize).collect();
        drive.staged(buffer, result);
        bytes
    }

    fn install(&mut self) -> Result<(), u32> {
        self.try_set(0x1f51, 1, 1, 1)
    }

    /// Calls until the drive restarts the board, at most so many times.
    fn restarts_within(&mut self, calls: u32) -> bool {
        (0..calls).any(|_| {
            self.step();
            self.actuator.device.drive.step_update()
        })
    }
}

#[test]
fn an_image_is_staged_while_the_drive_is_enabled_and_installed_without_power() {
    let mut bench = bench(true);
    bench.enable();
    let image = image(&header(6));
    bench.load(&image).expect("it fits");
    assert_eq!(bench.get(0x1f57, 1), 1, "it is not staged yet");
    assert_eq!(bench.install(), Err(DEVICE_STATE));
    assert_eq!(bench.stage(Ok(())), image);
    assert_eq!(bench.get(0x1f57, 1), 0);
    assert_eq!(bench.install(), Err(DEVICE_STATE), "the drive has power");
    bench.control(0);
    bench.steps(10);
    bench.install().expect("without power, at rest");
    let order = bench.actuator.device.drive.take_update();
    let identity = header(6).identity();
    assert!(matches!(order, Some(UpdateOrder::Install(image)) if image == identity));
    bench.actuator.device.drive.requested(true);
    // Enabled again: the restart waits for the end of it.
    bench.enable();
    bench.cyclic = Some((15, 0));
    assert!(!bench.restarts_within(200));
    bench.cyclic = None;
    bench.control(0);
    assert!(bench.restarts_within(60));
}

#[test]
fn what_does_not_fit_is_refused_and_reported_in_the_flash_status() {
    let mut bench = bench(true);
    let other = Header {
        hardware: ACTUATOR_BOARD + 1,
        ..header(6)
    };
    for header in [other, header(4)] {
        assert!(bench.load(&image(&header)).is_err());
        assert_eq!(bench.get(0x1f57, 1), 1 << 1, "no valid program");
    }
    let short = &image(&header(6))[..600];
    assert!(bench.load(short).is_err());
    assert!(bench.load(&[0; 4 * 4000 + 1]).is_err());
    assert_eq!(bench.install(), Err(DEVICE_STATE));
    // The buffer is back each time.
    assert!(bench.load(&image(&header(6))).is_ok());
    bench.stage(Err(StageError::Flash));
    assert_eq!(bench.get(0x1f57, 1), 5 << 1, "write error");
    assert_eq!(bench.install(), Err(DEVICE_STATE));
}

#[test]
fn a_download_and_a_recording_do_not_share_the_buffer() {
    let mut bench = bench(true);
    bench.set(0x2030, 1, 1, 1);
    assert_eq!(bench.load(&image(&header(6))), Err(DEVICE_STATE));
    bench.set(0x2030, 1, 0, 1);
    assert_eq!(bench.load(&image(&header(6))), Ok(()));
    bench.set(0x2030, 1, 1, 1);
    assert_eq!(bench.actuator.device.drive.capture.capacity(), 0);
    bench.stage(Ok(()));
    bench.set(0x2030, 1, 1, 1);
    assert!(bench.actuator.device.drive.capture.capacity() > 0);
}

#[test]
fn a_download_that_the_client_breaks_off_leaves_the_buffer() {
    let mut bench = bench(true);
    assert_eq!(bench.sdo([0x21, 0x50, 0x1f, 1, 0, 1, 0, 0])[0], 0x60);
    bench.send(0x601, &[0x80, 0x50, 0x1f, 1, 0, 0, 0, 0]);
    bench.received.clear();
    assert_eq!(bench.load(&image(&header(6))), Ok(()));
}

impl Bench {
    /// Begins a download and sends so many whole segments, then breaks it off.
    fn break_off(&mut self, image: &[u8], segments: usize) {
        let [a, b, c, d] = (image.len() as u32).to_le_bytes();
        assert_eq!(self.sdo([0x21, 0x50, 0x1f, 1, a, b, c, d])[0], 0x60);
        for (number, bytes) in image.chunks(7).take(segments).enumerate() {
            let mut request = [(number as u8 & 1) << 4, 0, 0, 0, 0, 0, 0, 0];
            request[1..].copy_from_slice(bytes);
            assert_eq!(self.sdo(request)[0] >> 5, 1);
        }
        // The client is silent for the time-out of the server.
        self.steps(251);
    }

    /// Object 2104h.
    fn kept(&mut self) -> (u32, u32) {
        (self.get(0x2104, 1), self.get(0x2104, 2))
    }
}

#[test]
fn a_download_that_was_broken_off_continues_where_it_ended() {
    let mut bench = bench(true);
    let mut image = image(&header(6));
    for (at, byte) in image.iter_mut().enumerate().skip(HEADER_SIZE as usize) {
        *byte = (at * 37 % 251) as u8;
    }
    let identity = header(6).identity();
    bench.break_off(&image, 80);
    assert_eq!(bench.kept(), (identity, 560));
    assert_eq!(bench.try_set(0x2104, 3, 559, 4), Err(Abort::Value.code()));
    bench.set(0x2104, 3, 560, 4);
    bench.load(&image[560..]).expect("the rest");
    assert_eq!(bench.kept(), (identity, image.len() as u32));
    assert_eq!(bench.get(0x2104, 3), 0, "used up");
    assert_eq!(bench.stage(Ok(())), image);
}

#[test]
fn the_beginning_of_an_image_is_neither_installed_nor_completed_by_that_of_another() {
    let mut bench = bench(true);
    let long = Header {
        length: 960,
        ..header(6)
    };
    bench.break_off(&image(&long), 80);
    assert_eq!(bench.install(), Err(DEVICE_STATE));
    // The rest of a shorter image.
    bench.set(0x2104, 3, 560, 4);
    assert!(bench.load(&[0; 48]).is_err());
    assert_eq!(bench.kept(), (0, 0));
    assert_eq!(bench.install(), Err(DEVICE_STATE));
    // Without an offset the next download is a new image.
    bench.break_off(&image(&long), 80);
    assert_eq!(bench.load(&image(&header(6))), Ok(()));
    assert_eq!(bench.stage(Ok(())), image(&header(6)));
}

#[test]
fn a_recording_and_a_header_that_is_not_complete_leave_nothing_to_continue() {
    let mut bench = bench(true);
    bench.break_off(&image(&header(6)), 80);
    bench.set(0x2030, 1, 1, 1);
    assert_eq!(bench.kept(), (0, 0));
    assert_eq!(bench.try_set(0x2104, 3, 560, 4), Err(Abort::Value.code()));
    bench.set(0x2030, 1, 0, 1);
    bench.break_off(&image(&header(6)), 73);
    assert_eq!(bench.kept(), (0, 0));
}

#[test]
fn an_image_that_was_staged_before_a_loss_of_power_is_installed_without_a_download() {
    let mut bench = Bench::new();
    let staged = Image {
        identity: 4711,
        bytes: 600,
    };
    bench.actuator.device.drive.set_slots(Slots {
        staged: Some(staged),
        ..slots(true)
    });
    assert_eq!(bench.kept(), (4711, 600));
    assert_eq!(bench.install(), Ok(()));
    let order = bench.actuator.device.drive.take_update();
    assert!(matches!(order, Some(UpdateOrder::Install(4711))));
}

#[test]
fn without_a_bootloader_no_image_is_taken() {
    let mut bench = Bench::new();
    assert!(bench.load(&image(&header(6))).is_err());
    assert_eq!(bench.get(0x1f56, 1), 0);
}

#[test]
fn an_image_on_trial_confirms_itself_after_a_second_and_takes_no_other_before() {
    let mut bench = bench(false);
    assert_eq!(bench.get(0x1f57, 1), 1 << 24);
    assert_eq!(bench.load(&image(&header(6))), Err(DEVICE_STATE));
    assert!(!bench.restarts_within(200));
    assert!(bench.actuator.device.drive.take_update().is_none());
    assert!(!bench.restarts_within(100));
    let order = bench.actuator.device.drive.take_update();
    assert!(matches!(order, Some(UpdateOrder::Confirm(Version(5)))));
    bench.actuator.device.drive.confirmed(true);
    assert_eq!(bench.get(0x1f57, 1), (Outcome::Confirmed as u32) << 16);
    assert_eq!(bench.load(&image(&header(6))), Ok(()));
}

#[test]
fn an_image_on_trial_without_an_encoder_restarts_the_board() {
    let mut bench = bench(false);
    for _ in 0..300 {
        bench.step_with(|samples| samples.encoder = None);
        if bench.actuator.device.drive.step_update() {
            return;
        }
    }
    panic!("it still runs");
}
