//! Tests of the drivers that run on a PC, with mocks, and on each chip.
//!
//! A check starts from any state of the hardware and ends with the bridge off. Its steps are
//! numbered from 1 in the order of the code; a failure has the number of its step.

use canopen::CanFrame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId, nb::Can};
use embedded_hal::delay::DelayNs;
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use firmware::store::{EDGES, Flash, Origin, Progress, Saver, Stored, load};
use model_core::control::{
    encoder_word::{COUNTS_PER_TURN, EncoderCount, EncoderWord},
    pwm_timer::Modulator,
    units::{Percent, percent},
};

use crate::{
    bridge::{Bridge, Command, Compare, HBridge, PwmTimer},
    encoder::{As5045, Bus},
    store::Waiting,
};

/// What a step expects and did not find.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Failure {
    /// Number of the step.
    pub step: u8,
    /// What it expects.
    pub expected: &'static str,
}

/// Fails in a step unless its expectation is met.
const fn expect(is_met: bool, step: u8, expected: &'static str) -> Result<(), Failure> {
    match is_met {
        true => Ok(()),
        false => Err(Failure { step, expected }),
    }
}

/// Time for a transfer of the encoder, us: 24 bits at 500 kHz take 48.
const TRANSFER_US: u32 = 100;

/// Longest difference of two readings of a shaft at rest, counts.
const REST_COUNTS: u16 = 1;

/// Checks the encoder, whose shaft is at rest; returns its count.
///
/// # Errors
/// The first step that fails.
pub fn encoder<B: Bus>(
    encoder: &mut As5045<B>,
    delay: &mut impl DelayNs,
) -> Result<EncoderCount, Failure> {
    // A reading that may have been under way ends.
    delay.delay_us(TRANSFER_US);
    encoder.finish();
    expect(encoder.finish().is_none(), 1, "no word without a transfer")?;
    let first = read(encoder, delay, 2)?;
    expect(encoder.finish().is_none(), 3, "one word from a transfer")?;
    // An aborted transfer must not shift the next one.
    encoder.start();
    let second = read(encoder, delay, 4)?;
    let difference = first.get().abs_diff(second.get());
    let is_at_rest =
        difference <= REST_COUNTS || difference >= COUNTS_PER_TURN as u16 - REST_COUNTS;
    expect(is_at_rest, 5, "the same count in two readings")?;
    Ok(second)
}

/// Reads a valid count.
fn read<B: Bus>(
    encoder: &mut As5045<B>,
    delay: &mut impl DelayNs,
    step: u8,
) -> Result<EncoderCount, Failure> {
    encoder.start();
    delay.delay_us(TRANSFER_US);
    let word = encoder.finish();
    let reading = word.and_then(|word: EncoderWord| word.read().ok());
    reading.map(|reading| reading.count).ok_or(Failure {
        step,
        expected: "a word with valid parity and status",
    })
}

/// Duties of the bridge in its check: too little for the motor to turn.
const DUTIES: [Percent; 2] = [percent(5.0), percent(-5.0)];

/// Checks the bridge, with its timer stopped or running. `trip` sets the break as the comparator does,
/// for a moment.
///
/// # Errors
/// The first step that fails.
pub fn bridge<T: PwmTimer>(
    bridge: &mut HBridge<T>,
    trip: impl FnOnce(&mut T),
) -> Result<(), Failure> {
    let result = bridge_steps(bridge, trip);
    bridge.off();
    result
}

fn bridge_steps<T: PwmTimer>(
    bridge: &mut HBridge<T>,
    trip: impl FnOnce(&mut T),
) -> Result<(), Failure> {
    bridge.off();
    bridge.take_trip();
    expect(!bridge.timer().are_outputs_on(), 1, "off")?;
    for (duty, step) in DUTIES.into_iter().zip(2..) {
        let driven = Command::Driven(Modulator::default().next(duty));
        bridge.command(driven);
        bridge.begin_pwm_period();
        let timer = bridge.timer();
        expect(
            timer.compare() == Compare::of(driven),
            step,
            "the duty in the timer",
        )?;
        expect(timer.are_outputs_on(), step, "driven")?;
    }
    bridge.brake();
    bridge.begin_pwm_period();
    let timer = bridge.timer();
    expect(timer.are_outputs_on(), 4, "braked")?;
    expect(
        timer.compare() == Compare::of(Command::Brake),
        4,
        "no on time",
    )?;
    bridge.command(Command::Coast);
    bridge.begin_pwm_period();
    expect(!bridge.timer().are_outputs_on(), 5, "coasting")?;
    // A control period without a command.
    bridge.brake();
    bridge.begin_control_period();
    bridge.begin_pwm_period();
    expect(
        bridge.timer().are_outputs_on(),
        6,
        "braked in the period of the command",
    )?;
    bridge.begin_control_period();
    bridge.begin_pwm_period();
    expect(!bridge.timer().are_outputs_on(), 7, "off without a command")?;
    // The trip.
    bridge.brake();
    bridge.begin_pwm_period();
    trip(bridge.timer());
    expect(!bridge.timer().are_outputs_on(), 8, "off after a trip")?;
    bridge.begin_pwm_period();
    expect(
        !bridge.timer().are_outputs_on(),
        9,
        "off until the trip is taken",
    )?;
    expect(bridge.take_trip(), 10, "the trip")?;
    expect(!bridge.take_trip(), 11, "one trip")?;
    bridge.begin_pwm_period();
    expect(
        bridge.timer().are_outputs_on(),
        12,
        "braked after the trip is taken",
    )?;
    bridge.off();
    expect(!bridge.timer().are_outputs_on(), 13, "off at once")
}

/// Polls for a frame, and the time between them, us: 20 ms in all.
const FRAME_POLLS: u32 = 400;
const FRAME_POLL_US: u32 = 50;

/// Identifiers of the frames of the check, a standard and an extended one.
pub fn identifiers() -> [Id; 2] {
    [
        Id::Standard(StandardId::new(0x5a5).unwrap_or(StandardId::ZERO)),
        Id::Extended(ExtendedId::new(0x1234_5678).unwrap_or(ExtendedId::ZERO)),
    ]
}

/// Checks a CAN controller that receives all that it transmits with [`identifiers`].
///
/// # Errors
/// The first step that fails.
pub fn can<C: Can<Frame = CanFrame>>(can: &mut C, delay: &mut impl DelayNs) -> Result<(), Failure> {
    while can.receive().is_ok() {}
    let [standard, extended] = identifiers();
    let bytes = [0x01, 0x80, 0xff, 0x00, 0x55, 0xaa, 0x7e, 0x10];
    let mut frames = (0..=bytes.len())
        .filter_map(|length| bytes.get(..length))
        .flat_map(|data| [standard, extended].map(|id| CanFrame::new(id, data)))
        .chain([standard, extended].map(|id| CanFrame::new_remote(id, 4)));
    frames.try_for_each(|frame| match frame {
        Some(frame) => loop_back(can, delay, &frame),
        None => expect(false, 1, "a frame"),
    })?;
    expect(can.receive().is_err(), 4, "no further frame")
}

/// Transmits a frame and receives it.
fn loop_back<C: Can<Frame = CanFrame>>(
    can: &mut C,
    delay: &mut impl DelayNs,
    frame: &CanFrame,
) -> Result<(), Failure> {
    expect(can.transmit(frame).is_ok(), 2, "a free mailbox")?;
    for _ in 0..FRAME_POLLS {
        if let Ok(received) = can.receive() {
            return expect(received == *frame, 3, "the frame that was transmitted");
        }
        delay.delay_us(FRAME_POLL_US);
    }
    expect(false, 3, "a frame within 20 ms")
}

/// Time between two polls of a save, us.
const SAVE_POLL_US: u32 = 20;

/// Words of the set that is stored.
const WORDS: usize = 13;

/// A set that is stored, the hash of whose layout is fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pattern([u32; WORDS]);

impl Pattern {
    /// Words that differ from each other and from those of another seed, from 1 on.
    fn of_seed(seed: u32) -> Self {
        let mut words = [0; WORDS];
        for (word, number) in words.iter_mut().zip(1..) {
            *word = seed.wrapping_mul(0x9e37_79b9).rotate_left(number) ^ number;
        }
        Self(words)
    }
}

impl Stored for Pattern {
    const LAYOUT: u32 = 0x1234_5678;
    const DEFAULT: Self = Self([0; WORDS]);
    type Page = [u32; WORDS + EDGES];
    const ZEROS: Self::Page = [0; WORDS + EDGES];

    fn write(&self, words: &mut [u32]) {
        for (place, word) in words.iter_mut().zip(self.0) {
            *place = word;
        }
    }

    fn read(words: &[u32]) -> Option<Self> {
        words.try_into().ok().map(Self)
    }
}

/// Checks the flash of the parameters: erases it, saves sets to it, and erases it again.
///
/// # Errors
/// The first step that fails.
pub fn store<F: Flash>(flash: F, delay: &mut impl DelayNs) -> Result<F, Failure> {
    let mut flash = erased(flash, delay, 1)?;
    expect(
        load::<Pattern>(&flash).origin == Origin::Defaults,
        2,
        "an empty store",
    )?;
    // More saves than pages: each is erased again.
    for seed in 1..=3 {
        let set = Pattern::of_seed(seed);
        let mut saver = Saver::new(&load::<Pattern>(&flash));
        expect(saver.start(&set), 3, "a save that starts")?;
        let end = loop {
            match saver.poll(&mut flash) {
                Progress::Running => delay.delay_us(SAVE_POLL_US),
                end => break end,
            }
        };
        expect(end == Progress::Done, 4, "a saved set")?;
        let loaded = load::<Pattern>(&flash);
        expect(loaded.origin == Origin::Stored, 5, "a valid set")?;
        expect(loaded.parameters == set, 6, "the set that was saved")?;
    }
    erased(flash, delay, 7)
}

/// Erases the flash by `NorFlash`, and reads all of it.
fn erased<F: Flash>(flash: F, delay: &mut impl DelayNs, step: u8) -> Result<F, Failure> {
    let mut flash = Waiting::new(flash, delay);
    let end = flash.capacity() as u32;
    expect(flash.erase(0, end).is_ok(), step, "an erase that succeeds")?;
    for address in (0..end).step_by(4) {
        let mut word = [0; 4];
        let is_read = flash.read(address, &mut word).is_ok();
        expect(is_read && word == [0xff; 4], step, "erased words")?;
    }
    Ok(flash.release())
}
