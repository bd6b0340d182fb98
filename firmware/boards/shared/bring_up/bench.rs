//! The peripherals, moved on one update period at a time.

use cortex_m::{asm, interrupt, peripheral::NVIC};
use drivers::bridge::{Bridge as _, Command};
use firmware::{
    bring_up::permille,
    measure::{current_ma, supply_mv, temperature_mdeg_c},
};
use model_core::control::encoder_word::EncoderReading;

use crate::{
    actuator::{
        pwm_timer::Instant,
        timebase::PeriodCounter,
        timing::{CYCLES_PER_US, UPDATE_HZ},
    },
    board::watchdog::Watchdog,
    chip::pac::{CAN1, IWDG, Interrupt},
    peripherals::{ActuatorBridge, Can, Encoder, analog::Analog, wiring::Peripherals},
};

/// Update periods in a millisecond.
pub const PERIODS_PER_MS: u32 = UPDATE_HZ / 1_000;

/// Current and supply take 7.8 us to convert.
const CONVERSION_US: u32 = 10;

/// The encoder takes 37 us to read.
const READING_US: u32 = 60;

/// When the legs are sampled.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Scan {
    /// In the on time, while the bridge is driven.
    Driven,
    /// With open switches.
    Open,
}

/// What one update period measures.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Motor current, mA.
    pub current_ma: i32,
    /// Supply, mV.
    pub supply_mv: i32,
    /// Temperature, if the NTC is neither open nor shorted, mdegC.
    pub temperature_mdeg_c: Option<i32>,
    /// Each leg, thousandths of the supply.
    pub legs: [i32; 2],
}

/// The board on the bench.
pub struct Bench {
    pub bridge: ActuatorBridge,
    analog: Analog,
    encoder: Encoder,
    /// It runs with the bridge's timer, as on the actuator board.
    _counter: PeriodCounter,
    watchdog: Option<Watchdog>,
    unstarted: Option<IWDG>,
    /// The controller, until the bus takes it.
    pub can: Option<CAN1>,
    /// The controller between the steps of the bus.
    pub port: Option<Can>,
    /// Greatest amount of the current while the bridge was driven, mA.
    pub greatest_ma: i32,
    /// Brown-out reset level of the option bytes.
    pub brown_out_level: i32,
    wakers: [Interrupt; 2],
}

impl Bench {
    /// Starts the timers with the bridge off.
    pub fn new(peripherals: Peripherals, wakers: [Interrupt; 2]) -> Self {
        // A pending interrupt wakes the processor; none is taken.
        interrupt::disable();
        for waker in wakers {
            // SAFETY: interrupts are disabled.
            unsafe { NVIC::unmask(waker) };
        }
        let (watchdog, _) = peripherals.watchdogs;
        let (mut bridge, mut counter) = (peripherals.bridge, peripherals.period_counter);
        counter.start();
        bridge.timer().start();
        Self {
            bridge,
            analog: peripherals.analog,
            encoder: peripherals.encoder,
            _counter: counter,
            watchdog: None,
            unstarted: Some(watchdog),
            can: Some(peripherals.can),
            port: None,
            greatest_ma: 0,
            brown_out_level: peripherals.flash.brown_out_level().into(),
            wakers,
        }
    }

    /// Starts the watchdog; from then on each update period must feed it.
    pub fn start_watchdog(&mut self) {
        if let Some(watchdog) = self.unstarted.take() {
            self.watchdog = Some(Watchdog::start(watchdog));
        }
    }

    /// Opens all switches.
    pub fn switch_off(&mut self) {
        self.bridge.off();
    }

    /// Sleeps until an event of the bridge's timer.
    fn sleep(&self) {
        asm::wfi();
        self.wakers.into_iter().for_each(NVIC::unpend);
    }

    /// Waits for the next update; the bridge does not change.
    pub fn wait_for_edge(&mut self) {
        while !self.bridge.timer().is_late() {
            self.sleep();
        }
        self.bridge.timer().acknowledge_edge();
    }

    /// Starts the next update period: the outputs follow the command.
    pub fn begin_period(&mut self) {
        self.bridge.begin_pwm_period();
        if let Some(watchdog) = &mut self.watchdog {
            watchdog.feed();
        }
    }

    /// Waits for the next update period and starts it.
    pub fn next_period(&mut self) {
        self.wait_for_edge();
        self.begin_period();
    }

    /// Drives the bridge from the next edge on.
    pub fn drive(&mut self, command: Command) {
        self.bridge.command(command);
    }

    /// Samples in the next update period; `None` if a conversion does not end.
    pub fn sample(&mut self, scan: Scan) -> Option<Sample> {
        self.next_period();
        self.bridge.timer().enable_sampling_instants(true);
        loop {
            match self.bridge.timer().take_instant() {
                Some(Instant::Current) => {
                    self.analog.sample_current();
                    if scan == Scan::Driven {
                        asm::delay(CONVERSION_US * CYCLES_PER_US);
                        self.analog.start_scan();
                    }
                }
                Some(Instant::WindowStart) => {}
                Some(Instant::BackEmf) => break,
                None => self.sleep(),
            }
        }
        if scan == Scan::Open {
            self.analog.start_scan();
        }
        self.next_period();
        self.analog.finish(true);
        let (Some(current), Some(scan)) = self.analog.read() else {
            return None;
        };
        Some(Sample {
            current_ma: current_ma(current),
            supply_mv: supply_mv(scan.supply),
            temperature_mdeg_c: temperature_mdeg_c(scan.temperature),
            legs: [scan.leg_a, scan.leg_b].map(|leg| permille(leg, scan.supply)),
        })
    }

    /// Reads the encoder in the next update period; `None` if the word is not valid.
    pub fn angle(&mut self) -> Option<EncoderReading> {
        self.next_period();
        self.encoder.start();
        asm::delay(READING_US * CYCLES_PER_US);
        self.encoder.finish()?.read().ok()
    }
}
