//! Applies faults to the run.

use rand_pcg::{Pcg32, rand_core::Rng};
use rigless::emulator::{Host, Stop};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::driver::Lockstep;
use super::view::Script;
use crate::board::ActuatorBoard;
use crate::can::WireFault;
use crate::faults::{Change, Fault, MemoryLocation};

/// Active faults outside the plant.
#[derive(Debug, Clone, Default)]
pub(super) struct BoardFaults {
    pub trips: bool,
    pub has_lost_power: bool,
    pub stalls: bool,
    /// The watchdog is fed at every stop, so that it never resets.
    pub feeds_watchdog: bool,
    /// Width of the servo pulses before the fault, us.
    servo_us: Option<f64>,
}

/// Fills the RAM, of these addresses and sizes, with random contents, as after a loss of supply.
pub(super) fn randomise_ram(ram: &[(u64, u64)], host: &mut dyn Host, at_ns: u64) {
    let mut random = Pcg32::new(at_ns, 0);
    for &(base, size) in ram {
        for address in (base..base + size).step_by(4) {
            let word = random.next_u32().into();
            let written = host.write(address, Width::W32, word);
            debug_assert!(written.is_ok(), "{address:#x} is RAM");
        }
    }
}

pub(super) fn apply_due<S: Script>(
    run: &mut Lockstep<S>,
    session: &mut Session<ActuatorBoard>,
    stop: Stop,
    host: &mut dyn Host,
) {
    apply_due_at(run, session, stop.at, stop.instruction_count, host);
}

pub(super) fn apply_due_at<S: Script>(
    run: &mut Lockstep<S>,
    session: &mut Session<ActuatorBoard>,
    at: VirtualNanos,
    instructions: u64,
    host: &mut dyn Host,
) {
    for Change { fault, begins } in run.faults.due(at.0, instructions) {
        if !fault.apply_to(&mut run.plant.defects, begins) {
            apply_to_board(run, session, (at, instructions), host, (&fault, begins));
        }
    }
}

fn apply_to_board<S: Script>(
    run: &mut Lockstep<S>,
    session: &mut Session<ActuatorBoard>,
    (at, instructions): (VirtualNanos, u64),
    host: &mut dyn Host,
    (fault, begins): (&Fault, bool),
) {
    let chip = &mut session.board_mut().chip;
    match fault {
        Fault::EncoderClockLate => {
            if let Some(encoder) = chip.encoder() {
                encoder.is_clock_late = begins;
            }
        }
        Fault::BridgeTrip => run.board_faults.trips = begins,
        Fault::PowerLoss => run.board_faults.has_lost_power = begins,
        Fault::StallCore => run.board_faults.stalls = begins,
        Fault::WatchdogDead => run.board_faults.feeds_watchdog = begins,
        Fault::FlashCut {
            operation,
            permille,
        } if begins => {
            if let Some(flash) = chip.flash() {
                flash.cut_during(*operation, *permille);
            }
        }
        Fault::Can { wire } => {
            if let Some(shared) = chip.wire() {
                shared.fault = if begins { *wire } else { WireFault::None };
            }
        }
        Fault::CanNoise { frames } if begins => {
            if let Some(wire) = chip.wire() {
                wire.noise = *frames;
            }
        }
        Fault::ServoPulse { us } => {
            let before = run.servo.pulse_us;
            let pulse_us = if begins {
                *us
            } else {
                run.board_faults.servo_us
            };
            run.board_faults.servo_us = before;
            run.servo.set(at.0, pulse_us);
        }
        Fault::AcceptanceFilter(bit) if begins => chip.flip_filter(*bit),
        Fault::ResetPin if begins => session.reset_by_pin(at, instructions, host),
        Fault::FlipRam { place, bit } if begins => {
            flip(run, place, *bit, host, |host, address, byte| {
                host.write(address, Width::W8, byte)
            });
        }
        Fault::FlipFlash { place, bit } if begins => {
            flip(run, place, *bit, host, |host, address, byte| {
                host.program(address, Width::W8, byte)
            });
        }
        _ => {}
    }
}

/// Flips a bit of the memory; `write` writes a byte.
fn flip<S: Script, E>(
    run: &Lockstep<S>,
    place: &MemoryLocation,
    bit: u32,
    host: &mut dyn Host,
    write: impl Fn(&mut dyn Host, u64, u64) -> Result<(), E>,
) {
    // Those of the plan have been checked.
    let address = match place {
        MemoryLocation::Address(address) => Some(*address),
        MemoryLocation::Symbol(name) => run.firmware().address(name).ok(),
    };
    if let Some(address) = address {
        let address = address + u64::from(bit / 8);
        if let Ok(byte) = host.read(address, Width::W8) {
            let flipped = write(host, address, byte ^ 1 << (bit % 8));
            debug_assert!(flipped.is_ok(), "{address:#x} was read");
        }
    }
}
