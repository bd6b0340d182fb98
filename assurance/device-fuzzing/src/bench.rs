//! The device, the motor at its bridge, and the frames between it and a master.

use bootloader::{ACTUATOR_BOARD, Outcome, Policy, Version};
use canopen::dictionary::Address;
use canopen::{Application as _, CanFrame};
use firmware::actuator::Actuator;
use firmware::application::{Bridge, Outputs, Samples, Start};
use firmware::dictionary::DICTIONARY;
use firmware::drive::{Slots, StageError, StoredParameters, UpdateOrder};
use model_core::plant::first_order::{FirstOrder, FirstOrderParameters};
use model_core::plant::{Plant, Pwm};
use model_core::sensors::adc::AdcCode;
use model_core::sensors::dividers::leg_code;
use model_core::sensors::encoder::Encoder;
use model_core::sensors::noise::Noise;
use model_core::time::{CONTROL_PERIOD_US, UPDATE_PERIODS_PER_CONTROL_PERIOD};

use crate::action::{Action, Disturbance};
use crate::oracle::{Oracle, Period, Summary};

/// Supply, V, resistance of the winding, ohm, and back-EMF of the motor, V per deg/s, which is the
/// supply less its friction at the rate of full duty.
const SUPPLY_V: f64 = 5.998;
const WINDING_OHM: f64 = 7.7;
const BACK_EMF_V_S_DEG: f64 = 5.73 / 283.6;

/// Control periods that a write of the flash takes.
const WRITE_PERIODS: u32 = 7;

/// Version of the program that runs.
pub const VERSION: Version = Version(5);

/// Answers after one frame at most.
const MOST_FRAMES: usize = 1_000;

/// A confirmed program that takes images of its version and newer ones.
fn slots(capacity: u32) -> Slots {
    Slots {
        identity: 1,
        version: VERSION,
        policy: Policy {
            hardware: ACTUATOR_BOARD,
            floor: VERSION,
        },
        capacity,
        outcome: Outcome::None,
        is_confirmed: true,
        staged: None,
    }
}

/// A device with node-ID 1 and its motor.
#[derive(Debug)]
pub struct Bench<'a> {
    actuator: Actuator<'a>,
    plant: FirstOrder,
    encoder: Encoder,
    duty_pct: f64,
    now_us: u64,
    /// Control periods until a write of the flash ends, and what it returns.
    writing: Option<u32>,
    write_succeeds: bool,
    oracle: Oracle,
}

impl<'a> Bench<'a> {
    /// A device after power-on, with the default parameters, which captures into this buffer.
    ///
    /// # Panics
    /// If the default motor is invalid.
    pub fn new(buffer: &'a mut [i32]) -> Self {
        let motor = FirstOrderParameters {
            position_limit_deg: 32_000.0,
            ..FirstOrderParameters::DEFAULT
        };
        let capacity = size_of_val(buffer) as u32;
        let mut actuator = Actuator::new(StoredParameters::DEFAULT, Start::default(), buffer, 0);
        actuator.device.drive.set_slots(slots(capacity));
        Self {
            actuator,
            plant: FirstOrder::try_new(motor, Pwm::Average).expect("the default motor"),
            encoder: Encoder::new(Default::default(), Noise::new(0, 0)),
            duty_pct: 0.0,
            now_us: 0,
            writing: None,
            write_succeeds: true,
            oracle: Oracle::default(),
        }
    }

    /// Control periods so far.
    pub fn periods(&self) -> u32 {
        self.oracle.periods()
    }

    /// Carries out an action.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Frame(frame) => {
                self.oracle.receive(&frame);
                self.actuator.receive(&frame, self.now_us);
                self.transmit();
            }
            Action::Periods(count, disturbance) => {
                (0..count).for_each(|_| self.step(&disturbance));
            }
            Action::Flash { succeeds } => self.write_succeeds = succeeds,
        }
    }

    /// The end of the run.
    ///
    /// # Panics
    /// If the parameters are invalid.
    pub fn end(self) -> Summary {
        let parameters = self.actuator.device.drive.parameters();
        assert_eq!(parameters.check(), Ok(()), "the parameters are valid");
        self.oracle.summary()
    }

    fn step(&mut self, disturbance: &Disturbance) {
        let settings = *self.actuator.device.drive.parameters();
        let duty_limit_pct = self.duty_limit_pct();
        let samples = self.samples(disturbance);
        self.now_us += u64::from(CONTROL_PERIOD_US) * (1 + u64::from(samples.missed_periods));
        let outputs = self.actuator.step(&samples, self.now_us);
        if disturbance.is_late {
            self.actuator.was_late();
        }
        self.oracle.check(&Period {
            settings,
            duty_limit_pct,
            samples,
            outputs,
        });
        for _ in 0..=samples.missed_periods {
            self.turn(&outputs);
        }
        self.write_flash();
        self.update(&outputs);
        let _ = self.actuator.device.drive.take_bit_rate();
        self.transmit();
    }

    /// Object 60F9h:06, as a master reads it.
    fn duty_limit_pct(&mut self) -> f64 {
        let entry = DICTIONARY.find(Address::new(0x60f9, 6));
        let bits = entry.and_then(|entry| self.actuator.device.drive.read(entry));
        f64::from(f32::from_bits(bits.expect("the object exists") as u32))
    }

    fn samples(&mut self, disturbance: &Disturbance) -> Samples {
        let state = self.plant.at(20);
        let mut samples = Samples::at_rest(self.encoder.word(state.angle_deg));
        let back_emf_v = state.rate_deg_s * BACK_EMF_V_S_DEG;
        let current_a = (self.duty_pct / 100.0 * SUPPLY_V - back_emf_v) / WINDING_OHM;
        samples.current = Some(AdcCode::from_pin_v(1.65 + 0.5 * current_a));
        if let Some(scan) = &mut samples.scan {
            scan.leg_a = leg_code((SUPPLY_V + back_emf_v) / 2.0);
            scan.leg_b = leg_code((SUPPLY_V - back_emf_v) / 2.0);
            if let Some([current, leg_a, leg_b, supply, temperature]) = disturbance.codes {
                samples.current = Some(current);
                (scan.leg_a, scan.leg_b) = (leg_a, leg_b);
                (scan.supply, scan.temperature) = (supply, temperature);
            }
        }
        samples.encoder = disturbance.encoder.unwrap_or(samples.encoder);
        samples.servo_pulse_us = disturbance.servo_pulse_us;
        samples.bridge_tripped = disturbance.bridge_tripped;
        samples.missed_periods = disturbance.missed_periods;
        samples.bus = disturbance.bus;
        samples
    }

    /// The motor during a control period: the decision of the board acts from the second PWM period
    /// on.
    fn turn(&mut self, outputs: &Outputs) {
        for period in 0..UPDATE_PERIODS_PER_CONTROL_PERIOD {
            self.plant.start_period(self.duty_pct);
            if period == 0 {
                self.duty_pct = match outputs.bridge {
                    Bridge::Driven(_) => outputs.telemetry.duty.to_f64(),
                    Bridge::Coast | Bridge::Brake => 0.0,
                };
            }
        }
    }

    fn write_flash(&mut self) {
        if self.actuator.device.drive.take_save().is_some() {
            self.writing = Some(WRITE_PERIODS);
        }
        self.writing = match self.writing {
            Some(0) => {
                self.actuator.device.drive.saved(self.write_succeeds);
                None
            }
            left => left.map(|left| left - 1),
        };
    }

    /// Carries out the orders of an update. The board restarts only without power.
    fn update(&mut self, outputs: &Outputs) {
        let (drive, succeeds) = (&mut self.actuator.device.drive, self.write_succeeds);
        match drive.take_update() {
            Some(UpdateOrder::Stage { buffer, .. }) => {
                drive.staged(buffer, succeeds.then_some(()).ok_or(StageError::Flash));
            }
            Some(UpdateOrder::Confirm(_)) => drive.confirmed(succeeds),
            Some(UpdateOrder::Install(_)) => drive.requested(succeeds),
            None => {}
        }
        let is_driven = matches!(outputs.bridge, Bridge::Driven(_));
        assert!(!drive.step_update() || !is_driven, "restarts while driven");
    }

    fn transmit(&mut self) {
        let frames = std::iter::from_fn(|| self.actuator.transmit::<CanFrame>());
        let count = frames.take(MOST_FRAMES).count();
        assert!(count < MOST_FRAMES, "the number of frames is limited");
    }
}
