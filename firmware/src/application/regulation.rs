//! What the motor does in a control period: the duty of the loop, of a stop and of the brake, and
//! the command to the bridge.

use model_core::control::{
    cascade::{CascadeStep, Setpoint},
    pwm_timer::PwmCompare,
    units::Percent,
};

use super::{
    AFTER_A_RESET, Application, BoardState, Bridge, ENCODER_WRONG, Settings, TorqueSetpoint,
    back_emf_brake::{self, BackEmfBrake},
    stop_progress::StopProgress,
    stopping, torque,
};
use crate::{
    faults::{Fault, FaultSet},
    parameters::BoardParameters,
    protection::Measured,
    timing::{angle_of_mdeg, rate_of_mdeg_s, thousandths},
};

impl Application {
    /// Starts the stop without encoder; if a ramp is running, within the time of the whole stop.
    pub(super) fn stop_by_back_emf(&mut self) {
        let progress = match self.state {
            BoardState::Enabled => StopProgress::default(),
            _ => self.stopping.progress(),
        };
        self.back_emf_stop = self.back_emf_stop.or(Some(progress.continued()));
        self.setpoints.stop();
    }

    /// Closes the loop. Without a valid count the last duty stays in force.
    pub(super) fn regulate(
        &mut self,
        settings: Settings<'_>,
        measured: &Measured,
        setpoint: Setpoint,
    ) {
        let parameters = settings.board;
        let is_valid = measured.count.is_some();
        let supply = measured.current.zip(measured.supply_mv);
        match supply.filter(|_| self.state == BoardState::Enabled) {
            Some((current, supply_mv)) => {
                let voltages = (measured.back_emf_mv.unwrap_or(0), supply_mv);
                (self.current_limit).observe(settings, voltages, current);
            }
            None => self.current_limit.reset(),
        }
        if self.state != BoardState::Enabled {
            self.feed_forward.end();
        }
        match self.state {
            BoardState::FaultReaction if self.back_emf_stop.is_some() => {
                self.stop_without_encoder(parameters, measured.back_emf_mv);
                self.oppose_back_emf(settings, measured);
            }
            BoardState::QuickStop | BoardState::FaultReaction | BoardState::FaultHold => {
                self.decelerate(settings, measured)
            }
            BoardState::Enabled if is_valid => {
                if let Some((current, back_emf_mv)) = measured.at_scan() {
                    self.back_emf_brake.observe_driven(current, back_emf_mv);
                }
                let step = match self.setpoints.torque() {
                    Some(torque) => {
                        self.feed_forward.end();
                        self.follow_torque(settings, measured, torque)
                    }
                    None => self.follow_setpoint(settings, setpoint),
                };
                self.apply_limited(settings, measured, step);
            }
            BoardState::Enabled => self.apply_limited(settings, measured, self.last_step),
            _ => {}
        }
        if !self.state.is_driving() {
            self.control.release();
            self.back_emf_stop = None;
            match self.brakes(parameters) {
                true => self.oppose_back_emf(settings, measured),
                false => {
                    self.last_step = CascadeStep::default();
                    self.compare = PwmCompare::default();
                }
            }
        }
    }

    /// A step of the control law around a setpoint, with what is fed forward, or of a shaft that
    /// rests there.
    #[inline(always)]
    fn follow_setpoint(&mut self, settings: Settings<'_>, setpoint: Setpoint) -> CascadeStep {
        let control = &settings.board.control;
        let mdeg_s = self.feed_forward.rate_mdeg_s();
        let is_forward = self.feed_forward.is_active();
        if is_forward {
            // At a position limit of the loop the shaft stands, whatever the axis demands.
            if self.last_step.limits.position {
                self.feed_forward.demand(0, 0);
            }
            let supply_mv = self.outputs.telemetry.supply_mv;
            let change = self.feed_forward.change(supply_mv);
            self.control.feed_forward(change);
        }
        // A shaft that a demanded voltage holds does not rest without duty.
        if settings.dead_band.is_on() && !is_forward && self.rests(settings, setpoint) {
            return (self.control).follow_duty(control, Percent::ZERO, Percent::ZERO);
        }
        match (mdeg_s, setpoint) {
            (0, _) | (_, Setpoint::Rate(_)) => self.control.regulate(control, setpoint),
            (mdeg_s, Setpoint::Angle(angle)) => {
                (self.control).track(control, angle, rate_of_mdeg_s(mdeg_s))
            }
        }
    }

    /// Whether the shaft rests at the setpoint without duty.
    #[inline(never)]
    fn rests(&mut self, settings: Settings<'_>, setpoint: Setpoint) -> bool {
        let control = &settings.board.control;
        let telemetry = &self.outputs.telemetry;
        // The command is still that of the last control period.
        let error = match setpoint {
            Setpoint::Angle(angle) if angle == telemetry.command => Some(
                control
                    .reachable(angle)
                    .saturating_sub(self.control.angle()),
            ),
            _ => None,
        };
        let (duty, supply_mv) = (self.last_step.duty, telemetry.supply_mv);
        (self.dead_band).rests(settings.dead_band, error, duty, supply_mv)
    }

    /// A step of the control law that makes a torque.
    #[inline(never)]
    fn follow_torque(
        &mut self,
        settings: Settings<'_>,
        measured: &Measured,
        torque: TorqueSetpoint,
    ) -> CascadeStep {
        let supply_mv = self.outputs.telemetry.supply_mv;
        let voltages = (measured.back_emf_mv.unwrap_or(0), supply_mv);
        let winding = self.protection.winding();
        let control = &settings.board.control;
        let permitted = |mdeg_s| {
            let rate = self.control.permitted(control, rate_of_mdeg_s(mdeg_s));
            thousandths(rate)
        };
        let (slowest, fastest) = torque.rates_mdeg_s;
        let torque = TorqueSetpoint {
            rates_mdeg_s: (permitted(slowest), permitted(fastest)),
            ..torque
        };
        let (duty, is_rate_limited) = torque::duty(torque, settings, winding, voltages);
        let rest = match stopping::stands(self.control.rate()) {
            true => duty,
            false => back_emf_brake::duty_of(voltages.0, voltages.1),
        };
        let mut step = self.control.follow_duty(control, duty, rest);
        step.limits.rate = is_rate_limited;
        step
    }

    /// One period of a stop by the back-EMF, and its end.
    fn stop_without_encoder(&mut self, parameters: &BoardParameters, back_emf_mv: Option<i32>) {
        if let Some(progress) = &mut self.back_emf_stop {
            progress.next(back_emf_mv.map(back_emf_brake::stands));
            if progress.is_over(&parameters.stop) {
                self.state = BoardState::Fault;
            }
        }
    }

    /// The back-EMF by the rate of an encoder that is trusted; zero without one.
    #[inline(never)]
    fn back_emf_by_encoder_mv(&self, settings: Settings<'_>, measured: &Measured) -> i32 {
        let is_trusted = self.latched.all().and(ENCODER_WRONG).is_empty();
        if !is_trusted || measured.count.is_none() {
            return 0;
        }
        let rate_mdeg_s = thousandths(self.control.rate());
        settings.motor.back_emf_mv(rate_mdeg_s)
    }

    /// A duty that opposes the back-EMF. Where it is not measured it follows from the encoder, or
    /// the duty is zero, which shorts the motor.
    fn oppose_back_emf(&mut self, settings: Settings<'_>, measured: &Measured) {
        let back_emf_mv = measured.back_emf_mv;
        if let Some((current, back_emf_mv)) = measured.at_scan() {
            self.back_emf_brake.observe_braked(current, back_emf_mv);
            if measured.count.is_some() {
                let of_back_emf_ma = settings.motor.ripple.of_back_emf_ma(back_emf_mv);
                let expected_ma = current.stall_ma - of_back_emf_ma;
                let (duty, rate) = (self.last_step.duty, self.control.rate());
                (self.back_emf_brake).verify(duty, rate, current, expected_ma);
            }
        }
        let back_emf_mv =
            back_emf_mv.unwrap_or_else(|| self.back_emf_by_encoder_mv(settings, measured));
        let voltages = (back_emf_mv, self.outputs.telemetry.supply_mv);
        self.apply(CascadeStep {
            duty: opposing(self.back_emf_brake, settings, voltages),
            ..CascadeStep::default()
        });
    }

    /// One period of a quick stop, and its end.
    fn decelerate(&mut self, settings: Settings<'_>, measured: &Measured) {
        let BoardParameters { stop, control, .. } = settings.board;
        let is_valid = measured.count.is_some();
        let rate = self.control.rate();
        let command = self.stopping.next(stop, rate);
        if is_valid && self.stopping.arrives(rate) {
            self.stopping.hold(self.control.angle());
            if self.stopping.began_in_motion() {
                self.control.start_from(Percent::ZERO);
            }
        }
        let held = self.stopping.holds_at();
        if is_valid {
            let step = match held {
                Some(angle) => self.control.regulate(control, angle),
                None => self.control.decelerate(control, command),
            };
            self.apply_limited(settings, measured, step);
        }
        match self.state {
            BoardState::QuickStop if !self.stopping.is_over(stop) => {}
            BoardState::QuickStop if stop.quick_stop_hold == 1 => {}
            BoardState::QuickStop => self.state = BoardState::Disabled,
            BoardState::FaultHold if self.is_held(settings.board) => {}
            BoardState::FaultHold => self.state = BoardState::Fault,
            _ if self.stopping.is_late(stop) => self.state = self.after_the_stop(settings.board),
            _ => {}
        }
    }

    /// The shaft is held where it has come to rest, if all faults permit it.
    fn after_the_stop(&self, parameters: &BoardParameters) -> BoardState {
        let others = (self.latched.all()).without(parameters.holding_faults());
        match self.stopping.holds_at() {
            Some(_) if others.is_empty() => BoardState::FaultHold,
            _ => BoardState::Fault,
        }
    }

    /// Whether the shaft is where it is held, within the window of the following error.
    fn is_held(&self, parameters: &BoardParameters) -> bool {
        let window = angle_of_mdeg(parameters.following.following_window_mdeg);
        let place = self.stopping.holds_at();
        place.is_some_and(|place| (self.control.angle() - place).abs() <= window)
    }

    /// Applies a step of the control law, or the last one, within the limit of the current. A
    /// back-EMF that is not measured counts as zero, as for the brake: the shaft may have stopped.
    fn apply_limited(
        &mut self,
        settings: Settings<'_>,
        measured: &Measured,
        mut step: CascadeStep,
    ) {
        let supply_mv = self.outputs.telemetry.supply_mv;
        let voltages = (measured.back_emf_mv.unwrap_or(0), supply_mv);
        let braking = || opposing(self.back_emf_brake, settings, voltages);
        let winding = self.protection.winding();
        let window = (self.current_limit).window(settings.limits, winding, voltages, braking);
        if let Some(window) = window {
            (self.control).limit_duty(&settings.board.control, &mut step, window);
        }
        self.apply(step);
    }

    /// Takes the duty of a control step as a compare value for the timer.
    pub(super) fn apply(&mut self, step: CascadeStep) {
        self.last_step = step;
        self.compare = self.modulator.next(step.duty);
    }

    /// Whether the motor brakes while the loop is open, which limits the travel of the shaft: in
    /// [`BoardState::Fault`], unless one of the faults excludes it or the current is too large, and
    /// after a reset, which may have come in motion.
    fn brakes(&self, parameters: &BoardParameters) -> bool {
        let faults = match self.state {
            BoardState::Initialising if self.start.is_empty() => AFTER_A_RESET,
            BoardState::Initialising => self.start,
            BoardState::Fault => self.latched.all(),
            _ => FaultSet::EMPTY,
        };
        let is_unsafe = self.outputs.telemetry.present.contains(Fault::OverCurrent);
        let braking = parameters.braking_faults();
        !faults.is_empty() && faults.without(braking).is_empty() && !is_unsafe
    }

    /// The command to the bridge.
    pub(super) fn bridge(&self, parameters: &BoardParameters) -> Bridge {
        if self.state.is_driving() {
            return Bridge::Driven(self.compare);
        }
        match self.brakes(parameters) {
            true if self.compare == PwmCompare::default() => Bridge::Brake,
            true => Bridge::Driven(self.compare),
            false => Bridge::Coast,
        }
    }
}

/// The duty of the brake at these voltages of back-EMF and supply.
fn opposing(brake: BackEmfBrake, settings: Settings<'_>, voltages: (i32, i32)) -> Percent {
    let Settings { board, motor, .. } = settings;
    let duty = brake.opposing(&board.current, &motor.ripple, voltages);
    duty.limited(board.control.duty_limit())
}
