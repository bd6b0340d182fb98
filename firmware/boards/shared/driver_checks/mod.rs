//! The checks of the drivers on a board: those that run on a PC with mocks.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use drivers::{
    can::{AcceptedIds, CanPort, Mode, NbCan},
    checks::{self, Failure},
};
use embedded_hal::delay::DelayNs;

use crate::{
    actuator::timing::CYCLES_PER_US,
    chip::pac::TIM1,
    peripherals::{Can, wiring::Peripherals},
};

/// Result of each check: 0 before its end, 1 if it passed, otherwise 256 plus the number of the
/// step that failed. Encoder, bridge, CAN controller, store.
#[unsafe(no_mangle)]
static DRIVER_CHECKS: [AtomicU32; 4] = [const { AtomicU32::new(0) }; 4];

/// Bit rate of the check, kbit/s.
const KBIT_S: u16 = 1000;

/// A delay by instructions.
struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay(ns.div_ceil(1000) * CYCLES_PER_US);
    }

    fn delay_us(&mut self, us: u32) {
        for _ in 0..us {
            cortex_m::asm::delay(CYCLES_PER_US);
        }
    }
}

/// Runs all checks; then the bridge is off. The stored parameters are erased.
pub fn run(mut peripherals: Peripherals) -> ! {
    peripherals.bridge.timer().start();
    // The encoder follows its magnet once a millisecond at the latest.
    Delay.delay_ms(3);
    let count = checks::encoder(&mut peripherals.encoder, &mut Delay);
    report(0, count.map(|_| ()));
    let bridge = checks::bridge(&mut peripherals.bridge, |_| {
        // SAFETY: one write of one word: a break, as of the input (RM0090, section 17.4.6).
        unsafe { &*TIM1::ptr() }.egr().write(|w| w.bg().set_bit());
    });
    report(1, bridge);
    let identifiers = checks::identifiers();
    let accepted = identifiers.map(|id| [(id, false), (id, true)]);
    let accepted = AcceptedIds::new(accepted.into_iter().flatten());
    let (mut can, ..) = Can::new(peripherals.can, &accepted);
    can.leave();
    while !can.has_left() {}
    can.join(KBIT_S, Mode::LoopBack);
    report(2, checks::can(&mut NbCan(can), &mut Delay));
    report(3, checks::store(peripherals.flash, &mut Delay).map(|_| ()));
    loop {
        cortex_m::asm::wfi();
    }
}

fn report(check: usize, result: Result<(), Failure>) {
    let code = match result {
        Ok(()) => {
            defmt::info!("check {} passed", check);
            1
        }
        Err(Failure { step, expected }) => {
            defmt::error!("check {}, step {}: expected {}", check, step, expected);
            256 + u32::from(step)
        }
    };
    if let Some(place) = DRIVER_CHECKS.get(check) {
        place.store(code, Relaxed);
    }
}
