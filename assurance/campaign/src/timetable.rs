//! The times of the board that experiments are copies of.
//!
//! They do not depend on the injections that are asked for, so that an experiment can be repeated
//! alone: the contents of the RAM and the phase of the timers at power-on follow from the time of
//! the power-on.

use virtual_board::can::Port;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{BoardPlant, BoardPlantOptions};
use virtual_board::run::View;

use crate::experiment::inject;
use crate::injection::{Injection, LATEST_MS};
use crate::injector::Injector;
use crate::motion::Motion;

/// ns in a ms.
const MS_NS: u64 = 1_000_000;

/// Time from the cut of the supply before a motion to the next one, ms: a start, and the latest
/// injection.
const MOTION_MS: u64 = 800 + LATEST_MS as u64;

/// Duration of the cut, ms, and the time from its begin until the supply is on again.
const CUT_MS: u64 = 3;
const OFF_MS: u64 = 6;

/// First and last address of the stored parameters.
const STORE: [u64; 2] = [0x0810_0000, 0x0810_8000];

/// A blank word of the flash.
const BLANK: u32 = u32::MAX;

/// A millisecond of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instant {
    /// The motion.
    pub motion: Motion,
    /// Time since the first PWM period after power-on, ms.
    pub ms: u32,
    /// Whether the emulator only warms up.
    pub is_warm_up: bool,
}

/// The state of the timetable.
#[derive(Debug)]
pub struct Timetable {
    /// Injections into the board itself before the motions. After them, the emulator has
    /// translated what runs in a disturbed board, and no copy has to translate it again.
    warm_up: Vec<Injection>,
    /// Number of motions that have begun, with those of the warm-up.
    begun: usize,
    /// Time at which the supply is on again, ns, while it is cut.
    on_ns: Option<u64>,
    /// Start of the first PWM period after power-on, ns.
    start_ns: Option<u64>,
    /// The last ms since then.
    last_ms: Option<u32>,
}

impl Timetable {
    /// The timetable with these injections before the motions.
    pub fn new(warm_up: Vec<Injection>) -> Self {
        Self {
            warm_up,
            begun: 0,
            on_ns: None,
            start_ns: None,
            last_ms: None,
        }
    }

    /// Number of motions.
    fn motions(&self) -> usize {
        self.warm_up.len() + Motion::ALL.len()
    }

    /// Begin of the next motion, ns.
    fn next_motion_ns(&self) -> u64 {
        MS_NS * (self.begun as u64 * MOTION_MS + 1)
    }

    /// Whether the last motion is over.
    pub fn is_over(&self, now_ns: u64) -> bool {
        self.begun == self.motions() && now_ns >= self.next_motion_ns()
    }

    /// Virtual time that all motions need, ms.
    pub fn duration_ms(&self) -> u64 {
        (self.motions() as u64 + 1) * MOTION_MS
    }

    /// Cuts the supply between two motions.
    pub fn carry_out(&mut self, view: &mut View<'_>) {
        let now_ns = view.now_ns();
        if self.begun < self.motions() && now_ns >= self.next_motion_ns() {
            self.begun += 1;
            self.cut_supply(view);
        }
        if self.on_ns.is_some_and(|on_ns| now_ns >= on_ns) {
            self.on_ns = None;
            restore(view);
        }
    }

    fn cut_supply(&mut self, view: &mut View<'_>) {
        let now_ns = view.now_ns();
        view.plan(Planned::at_ns(now_ns + MS_NS, Fault::PowerLoss).for_ms(CUT_MS));
        self.on_ns = Some(now_ns + OFF_MS * MS_NS);
        (self.start_ns, self.last_ms) = (None, None);
    }

    /// The next ms of the motion, if it has begun.
    pub fn next(&mut self, now_ns: u64, is_edge: bool) -> Option<Instant> {
        if self.on_ns.is_some() {
            return None;
        }
        if is_edge {
            self.start_ns.get_or_insert(now_ns);
        }
        let since_ns = now_ns - self.start_ns?;
        let ms = ((since_ns + MS_NS / 2) / MS_NS) as u32;
        if self.last_ms >= Some(ms) {
            return None;
        }
        self.last_ms = Some(ms);
        let index = self.begun.checked_sub(1)?;
        let warm_up = self.warm_up.get(index);
        Some(Instant {
            motion: match warm_up {
                Some(injection) => injection.motion,
                None => Motion::ALL[index - self.warm_up.len()],
            },
            ms,
            is_warm_up: warm_up.is_some(),
        })
    }

    /// Makes the injection of the warm-up in this millisecond, if there is one.
    pub fn carry_out_warm_up(&self, ms: u32, view: &mut View<'_>, injector: &Injector) {
        let warm_up = self
            .begun
            .checked_sub(1)
            .and_then(|at| self.warm_up.get(at));
        if let Some(injection) = warm_up.filter(|injection| injection.at_ms == ms) {
            inject(view, *injection, injector);
        }
    }
}

/// Shaft, bus and stored parameters are as at the first power-on.
fn restore(view: &mut View<'_>) {
    if let Ok(plant) = BoardPlant::try_new(&BoardPlantOptions::default()) {
        *view.plant = plant;
    }
    if let Some(port) = view.port(0) {
        *port = Port::at_rate(1_000_000);
    }
    for address in (STORE[0]..STORE[1]).step_by(4) {
        if view.word(address) != Some(BLANK) {
            view.program_word(address, BLANK);
        }
    }
}
