//! Boards side by side, with the delay of each one's commands.

use std::array;

use model_core::{
    actuator::{
        Settings,
        lanes::{MotorLoops, Seen},
    },
    control::units::{Angle, angle},
    parameter::ParameterError,
    time::{CONTROL_PERIOD_TICKS, ticks},
};

use super::{ABREAST, BatchState, Refused};

/// Up to [`ABREAST`] boards; the remaining lanes repeat the first.
pub struct Group {
    boards: MotorLoops<ABREAST>,
    settings: [Settings; ABREAST],
    transit: Transit,
}

/// Commands in transit: a row for each control period, the present one at `now`.
struct Transit {
    rows: Vec<[Angle; ABREAST]>,
    now: usize,
    /// Control periods after which each command is sampled by the control step.
    periods: [usize; ABREAST],
    /// Whether a first command was received, which is also its past.
    started: [bool; ABREAST],
}

/// Control periods from a command to the control step that samples it.
fn periods(settings: &Settings) -> usize {
    ticks(settings.setup.delay_s).div_ceil(CONTROL_PERIOD_TICKS) as usize
}

impl Transit {
    fn new(settings: &[Settings; ABREAST]) -> Self {
        let periods = array::from_fn(|lane| periods(&settings[lane]));
        let longest = periods.iter().copied().max().unwrap_or(0);
        Self {
            rows: vec![[Angle::ZERO; ABREAST]; longest + 1],
            now: 0,
            periods,
            started: [false; ABREAST],
        }
    }

    /// Takes over the commands of lanes whose delays are the same.
    fn keep(&mut self, other: &Self, is_kept: impl Fn(usize) -> bool) {
        let (count, others) = (self.rows.len(), other.rows.len());
        for lane in (0..ABREAST).filter(|lane| is_kept(*lane)) {
            self.started[lane] = other.started[lane];
            for age in 0..count.min(others) {
                let old = other.rows[(other.now + others - age) % others][lane];
                self.rows[(self.now + count - age) % count][lane] = old;
            }
        }
    }

    /// The commands that hold from now on: the given ones, deg, as far as they are finite.
    fn held(&mut self, commands: &[f64]) -> [Angle; ABREAST] {
        let mut held = self.rows[self.now];
        for (lane, command_deg) in commands.iter().enumerate() {
            if command_deg.is_finite() {
                held[lane] = angle(*command_deg);
            }
            if !self.started[lane] {
                self.started[lane] = true;
                self.rows.iter_mut().for_each(|row| row[lane] = held[lane]);
            }
        }
        held
    }

    /// Takes the commands of the next control period, and returns those that have arrived.
    #[inline(always)]
    fn shift(&mut self, commands: &[Angle; ABREAST]) -> [Angle; ABREAST] {
        let count = self.rows.len();
        self.now = (self.now + 1) % count;
        self.rows[self.now] = *commands;
        array::from_fn(|lane| {
            let sent = self.now + count - self.periods[lane];
            // Below twice the count: the remainder costs more than the rest of the shift.
            self.rows[if sent < count { sent } else { sent - count }][lane]
        })
    }
}

impl Group {
    /// The boards of these settings; `None` where they cannot run side by side.
    pub fn try_new(settings: &[Settings]) -> Result<Option<Self>, Refused> {
        let Some(first) = settings.first() else {
            return Ok(None);
        };
        for (lane, settings) in settings.iter().enumerate() {
            settings.setup.check().map_err(Refused::at(lane))?;
        }
        let all = array::from_fn(|lane| *settings.get(lane).unwrap_or(first));
        Ok(boards(&all)?.map(|boards| Self {
            boards,
            transit: Transit::new(&all),
            settings: all,
        }))
    }

    /// Passes control periods with a command a board, deg, and writes the states at their end.
    pub fn step(&mut self, periods: u64, commands: &[f64], states: &mut [BatchState]) {
        let held = self.transit.held(commands);
        pulp::Arch::new().dispatch(Pass {
            group: self,
            periods,
            held,
        });
        for (lane, state) in states.iter_mut().enumerate() {
            let (now, measured) = (self.boards.state(lane), self.boards.measured(lane));
            *state = BatchState {
                angle_deg: now.angle_deg,
                rate_deg_s: now.rate_deg_s,
                angle_meas_deg: measured.0,
                rate_meas_deg_s: measured.1,
            };
        }
    }

    /// Replaces boards by lane with others that can run side by side.
    pub fn replace(&mut self, fresh: &[(usize, Settings)]) -> Result<(), Refused> {
        let mut settings = self.settings;
        let mut is_fresh = [false; ABREAST];
        for (lane, new) in fresh {
            new.setup.check().map_err(Refused::at(*lane))?;
            (settings[*lane], is_fresh[*lane]) = (*new, true);
        }
        let Some(mut boards) = boards(&settings)? else {
            let first = fresh.first().map_or(0, |(lane, _)| *lane);
            return Err(Refused::at(first)(ParameterError::Unknown));
        };
        let mut transit = Transit::new(&settings);
        transit.keep(&self.transit, |lane| !is_fresh[lane]);
        for lane in (0..ABREAST).filter(|lane| !is_fresh[*lane]) {
            boards.keep(&self.boards, lane);
        }
        (self.boards, self.settings, self.transit) = (boards, settings, transit);
        Ok(())
    }
}

/// The lanes, or the first of them whose parameters are refused.
fn boards(settings: &[Settings; ABREAST]) -> Result<Option<MotorLoops<ABREAST>>, Refused> {
    MotorLoops::try_new(settings.each_ref()).map_err(|error| {
        let is_refused = |one: &Settings| MotorLoops::<1>::try_new([one]).is_err();
        Refused::at(settings.iter().position(is_refused).unwrap_or(0))(error)
    })
}

/// A step, with the widest vectors of the processor.
struct Pass<'a> {
    group: &'a mut Group,
    periods: u64,
    held: [Angle; ABREAST],
}

impl pulp::NullaryFnOnce for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Group {
            boards, transit, ..
        } = self.group;
        for _ in 0..self.periods {
            let arrived = transit.shift(&self.held);
            boards.pass_each(&arrived, CONTROL_PERIOD_TICKS as usize, Seen::Edges);
        }
    }
}
