//! An actuator that is stepped by its caller, tick by tick.

use super::closed_loop::ClosedLoop;
use super::kind::{ModelKind, PlantKind};
use super::settings::Settings;
use crate::control::{cascade::Coefficients, units::angle};
use crate::models::delay::{DelayLine, LONGEST_DELAY, Ring};
use crate::models::{
    ActuatorModel, black_box_1::BlackBox1, black_box_2::BlackBox2, grey_box::GreyBox,
};
use crate::parameter::ParameterError;
use crate::plant::{PERIOD, Plant, drivetrain::pwm::PwmDrivetrain, first_order::FirstOrder};
use crate::sensors::{adc::FrontEnd, encoder::Encoder, noise::Noise};
use crate::time::ticks;

/// The outputs of an actuator. A quantity that the model does not have is zero; a measured quantity
/// of a model without sensors has its true value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reading {
    /// The command that has arrived, deg.
    pub command_deg: f64,
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Its rate, deg/s.
    pub rate_deg_s: f64,
    /// Duty of the bridge, %.
    pub duty_pct: f64,
    /// Measured angle, deg.
    pub angle_meas_deg: f64,
    /// Measured rate, deg/s.
    pub rate_meas_deg_s: f64,
    /// Motor current, A.
    pub current_a: f64,
    /// Back-EMF, V.
    pub back_emf_v: f64,
}

impl Reading {
    /// The names of the quantities in traces.
    pub const COLUMNS: [&'static str; 8] = [
        "command_delayed",
        "angle_deg",
        "rate_deg_s",
        "duty_pct",
        "angle_meas_deg",
        "rate_meas_deg_s",
        "current_a",
        "back_emf_v",
    ];

    /// All quantities in the order of their declaration.
    pub fn values(&self) -> [f64; 8] {
        [
            self.command_deg,
            self.angle_deg,
            self.rate_deg_s,
            self.duty_pct,
            self.angle_meas_deg,
            self.rate_meas_deg_s,
            self.current_a,
            self.back_emf_v,
        ]
    }
}

/// A command or a load torque was not finite; the actuator was not stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandError;

impl core::fmt::Display for CommandError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the command is not a finite number of degrees")
    }
}

impl core::error::Error for CommandError {}

/// Any model, stored inline: there is no heap.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(clippy::large_enum_variant, reason = "no heap")]
enum Model {
    BlackBox1(BlackBox1),
    BlackBox2(BlackBox2),
    GreyBox(GreyBox),
    FirstOrder(ClosedLoop<FirstOrder>),
    Drivetrain(ClosedLoop<PwmDrivetrain<'static>>),
}

/// An actuator, initially at rest at zero.
///
/// By default it holds the memory of the longest delay, 160 KB, and needs no heap.
/// `Actuator<Vec<f64>>` (feature `alloc`) holds that of its own delay: 2.8 KB for the 17.5 ms of
/// the paper.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "R: Ring"))]
pub struct Actuator<R = [f64; LONGEST_DELAY]> {
    model: Model,
    delay: DelayLine<R>,
    /// Period of the host, ticks; 0 if the host samples every tick.
    host_ticks: u64,
    /// The last command that the host sampled.
    sampled_deg: f64,
    /// The delayed command.
    arrived_deg: f64,
    tick: u64,
}

impl Actuator {
    /// The actuator of these settings.
    ///
    /// # Errors
    /// That of the first parameter that is out of its range or inconsistent with another one.
    ///
    /// ```
    /// use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
    ///
    /// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    /// let mut actuator = Actuator::try_new(&settings).unwrap();
    /// // The first command is assumed to have been applied before: no delay. 240 deg/s for 100 ms.
    /// actuator.advance(90.0, 2000).unwrap();
    /// assert!((actuator.reading().angle_deg - 24.0).abs() < 1e-9);
    /// ```
    pub fn try_new(settings: &Settings) -> Result<Self, ParameterError> {
        Self::try_with_ring(settings)
    }
}

impl<R: Ring> Actuator<R> {
    /// The actuator of these settings, with a delay line in memory of this kind.
    ///
    /// # Errors
    /// As [`Actuator::try_new`].
    pub fn try_with_ring(settings: &Settings) -> Result<Self, ParameterError> {
        settings.setup.check()?;
        let s = settings;
        let model = match (s.model, s.plant) {
            (ModelKind::BlackBox1, _) => Model::BlackBox1(BlackBox1::try_new(s.black_box_1)?),
            (ModelKind::BlackBox2, _) => Model::BlackBox2(BlackBox2::try_new(s.black_box_2)?),
            (ModelKind::GreyBox, _) => Model::GreyBox(GreyBox::try_new(s.grey_box)?),
            (ModelKind::Board, PlantKind::FirstOrder) => {
                Model::FirstOrder(s.around(FirstOrder::try_new(s.first_order, s.pwm)?)?)
            }
            (ModelKind::Board, PlantKind::Drivetrain) => {
                Model::Drivetrain(s.around(PwmDrivetrain::try_new(&s.drivetrain, s.pwm, None)?)?)
            }
        };
        // The maximum of the parameter is the longest delay.
        let delay = DelayLine::try_new(ticks(s.setup.delay_s)).ok_or(ParameterError::Unknown)?;
        Ok(Self {
            model,
            delay,
            host_ticks: ticks(s.setup.host_period_s),
            sampled_deg: 0.0,
            arrived_deg: 0.0,
            tick: 0,
        })
    }

    /// Advances by this number of ticks of 50 us with a constant command.
    ///
    /// # Errors
    /// [`CommandError`] for a command that is not finite.
    pub fn advance(&mut self, command_deg: f64, ticks: u64) -> Result<(), CommandError> {
        if !command_deg.is_finite() {
            return Err(CommandError);
        }
        for _ in 0..ticks {
            self.step(command_deg);
        }
        Ok(())
    }

    /// Applies a torque to the load from the next PWM period on, Nm, in addition to that of the
    /// parameters; only the drivetrain has a load.
    ///
    /// # Errors
    /// [`CommandError`] for a torque that is not finite.
    pub fn set_load_torque_nm(&mut self, torque_nm: f64) -> Result<(), CommandError> {
        if !torque_nm.is_finite() {
            return Err(CommandError);
        }
        if let Model::Drivetrain(board) = &mut self.model {
            board.plant.set_load_torque_nm(torque_nm);
        }
        Ok(())
    }

    /// Number of ticks so far.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    fn step(&mut self, command_deg: f64) {
        if self.tick.checked_rem(self.host_ticks).unwrap_or(0) == 0 {
            self.sampled_deg = command_deg;
        }
        self.arrived_deg = self.delay.shift(self.sampled_deg);
        let (arrived_deg, tick) = (self.arrived_deg, self.tick);
        match &mut self.model {
            Model::BlackBox1(model) => model.step(arrived_deg),
            Model::BlackBox2(model) => model.step(arrived_deg),
            Model::GreyBox(model) => model.step(arrived_deg),
            Model::FirstOrder(board) => board.advance_tick(tick, arrived_deg),
            Model::Drivetrain(board) => board.advance_tick(tick, arrived_deg),
        }
        self.tick += 1;
    }

    /// The outputs at this instant, before the next step.
    pub fn reading(&self) -> Reading {
        let arrived_deg = self.arrived_deg;
        match &self.model {
            Model::BlackBox1(model) => of_model(model, arrived_deg),
            Model::BlackBox2(model) => of_model(model, arrived_deg),
            Model::GreyBox(model) => of_model(model, arrived_deg),
            Model::FirstOrder(board) => board.reading(self.tick, arrived_deg),
            Model::Drivetrain(board) => {
                let now = board.plant.reading_at(ticks_into_period(self.tick));
                Reading {
                    current_a: now.current_a,
                    back_emf_v: now.back_emf_v,
                    ..board.reading(self.tick, arrived_deg)
                }
            }
        }
    }
}

/// Ticks since the start of the PWM period that ends now or later: 1 to 20, and 0 at tick 0.
fn ticks_into_period(tick: u64) -> usize {
    match tick {
        0 => 0,
        tick => (tick - 1) as usize % PERIOD + 1,
    }
}

fn of_model(model: &impl ActuatorModel, command_deg: f64) -> Reading {
    let output = model.output(command_deg);
    Reading {
        command_deg,
        angle_deg: output.angle_deg,
        rate_deg_s: output.rate_deg_s,
        duty_pct: output.duty_pct,
        angle_meas_deg: output.angle_deg,
        rate_meas_deg_s: output.rate_deg_s,
        ..Default::default()
    }
}

impl<P: Plant> ClosedLoop<P> {
    /// Advances by one tick, with the PWM edge at its start if there is one.
    fn advance_tick(&mut self, tick: u64, arrived_deg: f64) {
        if tick.is_multiple_of(PERIOD as u64) {
            self.start_period(|_| angle(arrived_deg));
        }
    }

    fn reading(&self, tick: u64, command_deg: f64) -> Reading {
        let now = self.plant.at(ticks_into_period(tick));
        Reading {
            command_deg,
            angle_deg: now.angle_deg,
            rate_deg_s: now.rate_deg_s,
            duty_pct: self.duty_pct(),
            angle_meas_deg: self.angle_meas_deg(),
            rate_meas_deg_s: self.rate_meas_deg_s(),
            ..Default::default()
        }
    }
}

/// Streams of the noise generator: one for each sensor, so that they are independent.
const ENCODER_STREAM: u64 = 0;
const CURRENT_STREAM: u64 = 1;
const BACK_EMF_STREAM: u64 = 2;

impl Settings {
    /// The board's loop with a plant.
    ///
    /// # Errors
    /// That of the first parameter of control step or encoder that is out of its range.
    pub fn around<P: Plant>(&self, plant: P) -> Result<ClosedLoop<P>, ParameterError> {
        self.timer.check()?;
        self.encoder.check()?;
        let coefficients = Coefficients::try_new(&self.control)?;
        let encoder = Encoder::new(self.encoder, Noise::new(self.seed, ENCODER_STREAM));
        Ok(ClosedLoop::new(coefficients, self.timer, encoder, plant))
    }

    /// The analogue front ends of the drivetrain: those of the current and of the back-EMF, with
    /// their noise.
    pub fn front_ends(&self) -> [(FrontEnd, Noise); 2] {
        [
            (
                (&self.current_sense).into(),
                Noise::new(self.seed, CURRENT_STREAM),
            ),
            (
                (&self.back_emf_sense).into(),
                Noise::new(self.seed, BACK_EMF_STREAM),
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named::Named;
    use proptest::prelude::*;

    fn actuator(model: ModelKind, plant: PlantKind) -> Actuator {
        Actuator::try_new(&Settings::new(model, plant)).unwrap()
    }

    fn any_settings() -> impl Strategy<Value = (ModelKind, PlantKind)> {
        let models = proptest::sample::select(ModelKind::ALL);
        (models, proptest::sample::select(PlantKind::ALL))
    }

    proptest! {
        #[test]
        fn the_state_at_a_tick_does_not_depend_on_the_length_of_the_steps(
            (model, plant) in any_settings(),
            cuts in proptest::collection::vec(0_u64..90, 1..20),
        ) {
            let mut by_cuts = actuator(model, plant);
            for ticks in &cuts {
                by_cuts.advance(30.0, *ticks).unwrap();
            }
            let mut at_once = actuator(model, plant);
            at_once.advance(30.0, cuts.iter().sum()).unwrap();
            prop_assert_eq!(by_cuts.reading(), at_once.reading());
        }

        #[test]
        fn a_copy_continues_as_the_original(
            (model, plant) in any_settings(), before in 0_u64..2000, after in 0_u64..2000
        ) {
            let mut original = actuator(model, plant);
            original.advance(-40.0, before).unwrap();
            let mut copy = original.clone();
            original.advance(25.0, after).unwrap();
            copy.advance(25.0, after).unwrap();
            prop_assert_eq!(original.reading(), copy.reading());
        }
    }

    #[test]
    fn a_command_that_is_not_finite_is_refused_without_effect() {
        let mut actuator = actuator(ModelKind::Board, PlantKind::Drivetrain);
        for command in [f64::NAN, f64::INFINITY] {
            assert_eq!(actuator.advance(command, 1000), Err(CommandError));
            assert_eq!(actuator.set_load_torque_nm(command), Err(CommandError));
        }
        assert_eq!(
            (actuator.tick(), actuator.reading()),
            (0, Reading::default())
        );
    }

    #[test]
    fn a_torque_on_the_load_slows_the_drivetrain() {
        let angle_after = |torque_nm: f64| {
            let mut actuator = actuator(ModelKind::Board, PlantKind::Drivetrain);
            actuator.set_load_torque_nm(torque_nm).unwrap();
            actuator.advance(60.0, 4000).unwrap();
            actuator.reading().angle_deg
        };
        assert!(angle_after(-0.3) < angle_after(0.0) - 1.0);
    }

    #[test]
    fn a_host_with_a_period_of_20_ms_holds_its_last_sample() {
        let mut settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
        settings.setup.host_period_s = 0.02;
        settings.setup.delay_s = 0.0;
        let mut actuator = Actuator::try_new(&settings).unwrap();
        actuator.advance(0.0, 1).unwrap();
        actuator.advance(10.0, 399).unwrap();
        assert_eq!(actuator.reading().command_deg, 0.0);
        actuator.advance(10.0, 1).unwrap();
        assert_eq!(actuator.reading().command_deg, 10.0);
    }
}
