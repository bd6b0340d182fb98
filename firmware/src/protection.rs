//! What is watched in every control period; one module for each kind of trouble.
//!
//! Each module counts for how long a condition has lasted and says whether that is too long. A
//! sample that is missing holds its counter: it neither accuses nor acquits. What follows from a
//! condition is the application's decision, by state.

pub mod current;
pub mod encoder;
pub mod following;
mod lasting;
pub mod stall;
pub mod supply;
pub mod temperature;
pub mod timing;

use model_core::control::{
    encoder_word::{EncoderWord, Magnet},
    units::{Angle, Percent, Rate},
};

use self::{
    current::CurrentGuard, encoder::EncoderGuard, following::FollowingGuard, stall::StallGuard,
    supply::SupplyGuard, temperature::TemperatureGuard, timing::TimingGuard,
};
use crate::{
    faults::{Fault, FaultSet},
    interface::{Samples, Scan},
    measure,
    parameters::BoardParameters,
};

/// What the samples of a control period mean; none where a sample is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measured {
    /// The encoder's word for the control step; one without an angle where it must not be used.
    pub word: EncoderWord,
    /// Counts that the shaft has travelled since the last valid word.
    pub travelled: Option<i32>,
    /// What the encoder says of its magnet.
    pub magnet: Option<Magnet>,
    /// Motor current, mA.
    pub current_ma: Option<i32>,
    /// Back-EMF, mV.
    pub back_emf_mv: Option<i32>,
    /// Supply voltage, mV.
    pub supply_mv: Option<i32>,
    /// Temperature, thousandths of a degree Celsius.
    pub temperature_mdeg_c: Option<i32>,
}

/// Everything that the protections look at.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<'a> {
    /// What was measured.
    pub measured: &'a Measured,
    /// Whether the bridge is driven.
    pub is_driving: bool,
    /// Whether the shaft is to follow the command.
    pub is_following: bool,
    /// The angle.
    pub angle: Angle,
    /// The rate.
    pub rate: Rate,
    /// The commanded angle, within the position limits.
    pub command: Angle,
    /// The rate that the position loop commanded in the last control period.
    pub rate_command: Rate,
    /// The duty of the last control period.
    pub duty: Percent,
    /// Whether the source of the command is silent.
    pub is_stale: bool,
    /// Whether the bus that commands is off.
    pub is_bus_lost: bool,
    /// Whether the break input has switched the bridge off.
    pub is_tripped: bool,
    /// Control periods that were missed.
    pub missed_periods: u8,
}

/// All protections.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Protection {
    encoder: EncoderGuard,
    current: CurrentGuard,
    stall: StallGuard,
    following: FollowingGuard,
    supply: SupplyGuard,
    temperature: TemperatureGuard,
    timing: TimingGuard,
    is_complete: bool,
}

impl Protection {
    /// What the samples mean, the encoder's word judged.
    pub fn measure(&mut self, parameters: &BoardParameters, samples: &Samples) -> Measured {
        let judged =
            self.encoder
                .judge(&parameters.encoder, samples.encoder, samples.missed_periods);
        let scan = samples.scan;
        let measured = Measured {
            word: judged.word,
            travelled: judged.travelled,
            magnet: judged.magnet,
            current_ma: samples.current.map(measure::current_ma),
            back_emf_mv: scan.map(|Scan { leg_a, leg_b, .. }| measure::back_emf_mv(leg_a, leg_b)),
            supply_mv: scan.map(|scan| measure::supply_mv(scan.supply)),
            temperature_mdeg_c: scan.and_then(|scan| measure::temperature_mdeg_c(scan.temperature)),
        };
        self.is_complete |= measured.current_ma.is_some() && measured.temperature_mdeg_c.is_some();
        measured
    }

    /// Whether current, supply and temperature have been measured once.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// What is wrong now, whether it matters or not.
    pub fn check(&mut self, p: &BoardParameters, c: &Conditions<'_>) -> FaultSet {
        let mut present = self
            .encoder
            .check(&p.encoder, c)
            .or(self.current.check(&p.current, c))
            .or(self.supply.check(&p.supply, c))
            .or(self.temperature.check(&p.temperature, c))
            .or(self.timing.check(&p.timing, c));
        present.put(Fault::Stall, self.stall.check(&p.stall, c));
        present.put(Fault::FollowingError, self.following.check(&p.following, c));
        present.put(Fault::CommandTimeout, c.is_stale);
        present.put(Fault::BusOff, c.is_bus_lost);
        present.put(Fault::BridgeTripped, c.is_tripped);
        present
    }

    /// The loop is closed: what concerns motion starts over.
    pub fn restart(&mut self) {
        self.stall = StallGuard::default();
        self.following = FollowingGuard::default();
        self.encoder.restart();
    }

    /// The next valid word of the encoder is the first one.
    pub fn reset_position(&mut self) {
        self.encoder.reset_position();
    }
}
