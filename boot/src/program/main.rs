//! Bootloader of the actuator board: STM32F427, CANopen.
//!
//! The library decides what runs; this program carries it out. Until a program runs, all pins of
//! the bridge keep their reset state: inputs, with the drivers held off by the board's resistors
//! (`docs/hardware.md`).

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers, and the jump to the program: each block states why it is sound"
)]

mod can;
mod clocks;
mod flash;
mod wait;

use bootloader::layout::STM32F427;
use bootloader::{ACTUATOR_BOARD, Bootloader, Cause, Decision, HEADER_SIZE, Key};
use cortex_m_rt::{ExceptionFrame, entry, exception};
use stm32f4xx_hal::pac::{IWDG, Peripherals, RCC};

use flash::BlockingFlash;

/// The key of the images.
const KEY: Key = include!(concat!(env!("OUT_DIR"), "/key.rs"));

#[entry]
fn main() -> ! {
    let Some(peripherals) = Peripherals::take() else {
        restart();
    };
    let mut flash = BlockingFlash::new(peripherals.FLASH);
    let mut bootloader = Bootloader {
        flash: &mut flash,
        layout: &STM32F427,
        hardware: ACTUATOR_BOARD,
        verifier: KEY,
    };
    match bootloader.start(cause(&peripherals.RCC)) {
        Decision::Run { is_trial } => {
            if is_trial {
                start_watchdog(&peripherals.IWDG);
            }
            run()
        }
        Decision::Wait => wait::run(
            bootloader,
            peripherals.RCC,
            peripherals.GPIOD,
            peripherals.CAN1,
        ),
    }
}

/// The cause of the reset; its flags remain for the program.
fn cause(rcc: &RCC) -> Cause {
    let flags = rcc.csr().read();
    let is_restart = flags.wdgrstf().bit() || flags.wwdgrstf().bit() || flags.sftrstf().bit();
    if is_restart && !flags.porrstf().bit() {
        Cause::Restart
    } else {
        Cause::PowerOn
    }
}

/// Starts the watchdog with its reset values, 512 ms: a program that does not even start its own
/// is reset.
fn start_watchdog(watchdog: &IWDG) {
    const START: u16 = 0xcccc;
    // SAFETY: the key of RM0090, section 21.4.1.
    watchdog.kr().write(|w| unsafe { w.key().bits(START) });
}

/// Runs the program in the slot.
fn run() -> ! {
    let vectors = STM32F427.slot.start() + HEADER_SIZE;
    // SAFETY: no interrupt is enabled, and the vector table register belongs to this program until
    // the jump.
    unsafe { (*cortex_m::peripheral::SCB::PTR).vtor.write(vectors) };
    // SAFETY: the bootloader has found an image here, which begins with its vector table.
    unsafe { cortex_m::asm::bootload(core::ptr::with_exposed_provenance(vectors as usize)) }
}

/// Restarts the processor.
fn restart() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

// SAFETY: the handler restarts the processor and accesses nothing else.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    restart()
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    restart()
}
