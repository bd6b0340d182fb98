//! Protections, evaluated in every control period; one module for each group of faults.
//!
//! Each module counts for how long a condition has lasted and reports a fault when that exceeds its
//! limit. A missing sample does not change the counter. The application decides by its state which
//! faults it latches and how it reacts.

mod counters;
pub mod encoder;
pub mod following;
mod lasting;
mod over_current;
pub mod plausibility;
pub mod stall;
pub mod supply;
pub mod temperature;
pub mod timing;
pub mod travel;
mod winding;

use model_core::control::{
    cascade::Setpoint,
    encoder_word::{EncoderCount, Magnet},
    pwm_timer::PwmCompare,
    shaft_tracker::ShaftTracker,
    units::{Angle, Percent, Rate},
};

pub use self::{counters::Counter, winding::Winding};

use self::{
    encoder::EncoderGuard,
    following::FollowingGuard,
    over_current::OverCurrentGuard,
    plausibility::PlausibilityGuard,
    stall::StallGuard,
    supply::SupplyGuard,
    temperature::TemperatureGuard,
    timing::TimingGuard,
    travel::{LegOffset, TravelGuard},
};
use crate::{
    faults::{Fault, FaultSet},
    interface::{Samples, Settings},
    measure::{self, PeriodCurrent},
};

/// The measurements of a control period; `None` where a sample is missing or invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measured {
    /// The encoder's count, if the word is valid and plausible.
    pub count: Option<EncoderCount>,
    /// Counts that the shaft has travelled since the last valid count.
    pub travelled: Option<i32>,
    /// The encoder's magnet status.
    pub magnet: Option<Magnet>,
    /// Motor current at the sample in the on time, near its peak, mA.
    pub sampled_ma: Option<i32>,
    /// Motor current over the PWM period.
    pub current: Option<PeriodCurrent>,
    /// Back-EMF, mV.
    pub back_emf_mv: Option<i32>,
    /// The back-EMF is not measured, and no diode explains that.
    pub is_blind: bool,
    /// The back-EMF is that of an earlier control period.
    pub is_back_emf_held: bool,
    /// Change of the rate since the last control period by the back-EMF, mdeg/s.
    pub rate_change_mdeg_s: Option<i32>,
    /// Supply voltage, mV.
    pub supply_mv: Option<i32>,
    /// Temperature, thousandths of a degree Celsius.
    pub temperature_mdeg_c: Option<i32>,
}

impl Measured {
    /// Current and back-EMF, mV, of the same control period.
    pub fn at_scan(&self) -> Option<(PeriodCurrent, i32)> {
        let pair = self.current.zip(self.back_emf_mv);
        pair.filter(|_| !self.is_back_emf_held)
    }
}

/// The inputs of the protections.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// The measurements.
    pub measured: &'a Measured,
    /// Whether the bridge is driven.
    pub is_driving: bool,
    /// Whether the shaft has to follow the setpoint.
    pub is_following: bool,
    /// The angle.
    pub angle: Angle,
    /// The rate.
    pub rate: Rate,
    /// The setpoint, an angle within the position limits.
    pub setpoint: Setpoint,
    /// The input of the rate loop in the last control period.
    pub rate_command: Rate,
    /// The duty of the last control period.
    pub duty: Percent,
    /// Whether the last command is too old.
    pub is_stale: bool,
    /// Whether the bus is the source of commands and off.
    pub is_bus_lost: bool,
    /// Whether the break input has switched the bridge off.
    pub is_tripped: bool,
    /// Control periods that were missed.
    pub missed_periods: u8,
}

/// What was learned of the motor and its measurements, and holds after a restart.
#[derive(Debug, Clone, Copy)]
pub struct Learned {
    winding: Winding,
    offset: LegOffset,
}

/// The state of all protections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Protection {
    encoder: EncoderGuard,
    over_current: OverCurrentGuard,
    stall: StallGuard,
    following: FollowingGuard,
    supply: SupplyGuard,
    temperature: TemperatureGuard,
    timing: TimingGuard,
    plausibility: PlausibilityGuard,
    travel: TravelGuard,
    winding: Winding,
    is_complete: bool,
}

impl Protection {
    /// All protections without a history. Not inlined: its memory is then cleared as a whole.
    #[inline(never)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Converts the samples and validates the encoder's word; `shaft` has not seen it yet. The
    /// current was sampled in a PWM period with this compare value.
    pub fn measure(
        &mut self,
        settings: Settings<'_>,
        samples: &Samples,
        shaft: &ShaftTracker,
        compare: PwmCompare,
    ) -> Measured {
        let Settings { board, motor, .. } = settings;
        let scan = samples.scan;
        let back_emf_mv =
            scan.and_then(|scan| measure::back_emf_mv(scan.leg_a, scan.leg_b, scan.supply));
        let is_blind = back_emf_mv.is_none()
            && !scan
                .is_some_and(|scan| measure::diode_conducts(scan.leg_a, scan.leg_b, scan.supply));
        let rate_change_mdeg_s = if samples.is_scan_held() && back_emf_mv.is_some() {
            self.travel.hold(samples.missed_periods)
        } else {
            (self.travel).advance(motor, back_emf_mv, samples.missed_periods)
        };
        let encoder = self.encoder.validate(
            (&board.encoder, board.control.is_reversed()),
            samples.encoder,
            shaft,
            &mut self.travel,
        );
        let sampled_ma = samples.current.map(measure::current_ma);
        let supply_mv = scan.map(|scan| measure::supply_mv(scan.supply));
        let current = sampled_ma.zip(supply_mv).map(|(sampled_ma, supply_mv)| {
            motor.ripple.over_period(sampled_ma, compare, supply_mv)
        });
        let measured = Measured {
            count: encoder.count,
            travelled: encoder.travelled,
            magnet: encoder.magnet,
            sampled_ma,
            current,
            back_emf_mv,
            is_blind,
            is_back_emf_held: samples.is_scan_held(),
            rate_change_mdeg_s,
            supply_mv,
            temperature_mdeg_c: scan.and_then(|scan| measure::temperature_mdeg_c(scan.temperature)),
        };
        self.is_complete |= measured.current.is_some() && measured.temperature_mdeg_c.is_some();
        measured
    }

    /// Whether current, supply and temperature have been measured at least once.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The faults that are present, in any operating state.
    pub fn check(&mut self, settings: Settings<'_>, c: &Conditions<'_>) -> FaultSet {
        let p = settings.board;
        let mut present = self
            .encoder
            .check(&p.encoder, c)
            .or(self.over_current.check(&p.current, c))
            .or(self.supply.check(&p.supply, c))
            .or(self.temperature.check(&p.temperature, c))
            .or(self.timing.check(&p.timing, c))
            .or(self.travel.check())
            .or(self.plausibility.check(
                &p.encoder,
                &settings.motor.ripple,
                self.travel.is_beyond_play(),
                c,
            ));
        (self.travel).learn(c.is_driving, c.measured.travelled, c.measured.back_emf_mv);
        self.winding.update(settings, c);
        present.put(Fault::Overload, settings.limits.is_exceeded(&self.winding));
        present.put(Fault::Stall, self.stall.check(&p.stall, c));
        present.put(Fault::FollowingError, self.following.check(&p.following, c));
        present.put(Fault::CommandTimeout, c.is_stale);
        present.put(Fault::BusOff, c.is_bus_lost);
        present.put(Fault::BridgeTripped, c.is_tripped);
        present
    }

    /// The temperatures of the motor.
    pub fn winding(&self) -> &Winding {
        &self.winding
    }

    /// What was learned of the motor and its measurements.
    pub fn learned(&self) -> Learned {
        Learned {
            winding: self.winding,
            offset: self.travel.learned_offset(),
        }
    }

    /// Continues with what was learned.
    pub fn continue_with(&mut self, learned: Learned) {
        self.winding = learned.winding;
        self.travel.continue_with(learned.offset);
    }

    /// The constants of the motor are others.
    pub fn forget_constant(&mut self) {
        self.travel.forget_constant();
    }

    /// The loop is closed: protections of the motion restart.
    pub fn restart(&mut self) {
        self.stall = StallGuard::default();
        self.following = FollowingGuard::default();
        self.plausibility = PlausibilityGuard::default();
        self.travel.restart();
    }
}

#[cfg(test)]
mod tests;
