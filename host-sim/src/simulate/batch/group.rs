//! Boards side by side, with the delay of each one's commands, and those among them that have to be
//! computed alone.

use std::array;

use model_core::{
    actuator::{
        Settings,
        lanes::{LoopLanes, Seen},
    },
    control::units::{Angle, angle},
    parameter::ParameterError,
    plant::lanes::PlantLanes,
    time::{CONTROL_PERIOD_TICKS, ticks},
};

use super::{ABREAST, BatchState, Refused, Single};

/// Up to [`ABREAST`] boards around plants `P`. The lanes of boards that are computed alone, and
/// those without a board, repeat the first.
pub struct Group<P> {
    first: Settings,
    settings: [Settings; ABREAST],
    boards: LoopLanes<P, ABREAST>,
    transit: Transit,
    /// The boards that cannot be computed beside the first.
    alone: [Option<Single>; ABREAST],
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

/// The settings that can be computed beside the first ones, in whose lanes the others are repeated
/// by the first, and the others.
struct Sorted {
    beside: [Settings; ABREAST],
    alone: [Option<Settings>; ABREAST],
}

impl Sorted {
    /// Sorts these settings, of which those that are not new are beside the first already.
    fn new<P: PlantLanes<ABREAST>>(
        first: &Settings,
        settings: &[Settings; ABREAST],
        is_new: impl Fn(usize) -> bool,
    ) -> Self {
        let mut sorted = Self {
            beside: *settings,
            alone: [None; ABREAST],
        };
        if boards::<P>(settings).is_some() {
            return sorted;
        }
        for lane in (0..ABREAST).filter(|lane| is_new(*lane)) {
            let mut pair = [*first; ABREAST];
            pair[0] = settings[lane];
            if boards::<P>(&pair).is_none() {
                sorted.beside[lane] = *first;
                sorted.alone[lane] = Some(settings[lane]);
            }
        }
        sorted
    }
}

impl<P: PlantLanes<ABREAST>> Group<P> {
    /// The boards of these settings; `None` where fewer than `least` of them can be computed side
    /// by side.
    pub fn try_new(settings: &[Settings], least: usize) -> Result<Option<Self>, Refused> {
        let is_usable = |s: &&Settings| boards::<P>(&[**s; ABREAST]).is_some();
        let Some(first) = settings.iter().find(is_usable) else {
            return Ok(None);
        };
        let all = array::from_fn(|lane| *settings.get(lane).unwrap_or(first));
        let Sorted { beside, alone } = Sorted::new::<P>(first, &all, |_| true);
        let Some(boards) = boards(&beside) else {
            return Ok(None);
        };
        if settings.len() < least + alone.iter().flatten().count() {
            return Ok(None);
        }
        let mut group = Self {
            first: *first,
            settings: beside,
            boards,
            transit: Transit::new(&beside),
            alone: [const { None }; ABREAST],
        };
        for (lane, settings) in settings.iter().enumerate() {
            settings.setup.check().map_err(Refused::at(lane))?;
            group.alone[lane] = single(lane, &alone)?;
        }
        Ok(Some(group))
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
            if let Some(single) = &mut self.alone[lane] {
                *state = single.step(periods * CONTROL_PERIOD_TICKS, commands[lane]);
                continue;
            }
            let (now, measured) = (self.boards.state(lane), self.boards.measured(lane));
            *state = BatchState {
                angle_deg: now.angle_deg,
                rate_deg_s: now.rate_deg_s,
                angle_meas_deg: measured.0,
                rate_meas_deg_s: measured.1,
            };
        }
    }

    /// Replaces boards by lane.
    pub fn replace(&mut self, fresh: &[(usize, Settings)]) -> Result<(), Refused> {
        let mut settings = self.settings;
        let mut is_fresh = [false; ABREAST];
        for (lane, new) in fresh {
            new.setup.check().map_err(Refused::at(*lane))?;
            (settings[*lane], is_fresh[*lane]) = (*new, true);
        }
        let Sorted { beside, alone } = Sorted::new::<P>(&self.first, &settings, |i| is_fresh[i]);
        let singles: Vec<_> = fresh
            .iter()
            .map(|(lane, _)| single(*lane, &alone))
            .collect();
        let singles = singles.into_iter().collect::<Result<Vec<_>, _>>()?;
        let Some(mut boards) = boards::<P>(&beside) else {
            let first = fresh.first().map_or(0, |(lane, _)| *lane);
            return Err(Refused::at(first)(ParameterError::Unknown));
        };
        let mut transit = Transit::new(&beside);
        transit.keep(&self.transit, |lane| !is_fresh[lane]);
        for lane in (0..ABREAST).filter(|lane| !is_fresh[*lane]) {
            boards.keep(&self.boards, lane);
        }
        (self.boards, self.settings, self.transit) = (boards, beside, transit);
        for ((lane, _), single) in fresh.iter().zip(singles) {
            self.alone[*lane] = single;
        }
        Ok(())
    }
}

/// The board of a lane that is computed alone.
fn single(lane: usize, alone: &[Option<Settings>; ABREAST]) -> Result<Option<Single>, Refused> {
    let board = alone[lane].as_ref().map(Single::try_new).transpose();
    board.map_err(Refused::at(lane))
}

/// The lanes; `None` where these boards cannot be computed side by side, be it that a parameter is
/// refused. A command that is sampled less often than in every control period has no lane.
fn boards<P: PlantLanes<ABREAST>>(settings: &[Settings; ABREAST]) -> Option<LoopLanes<P, ABREAST>> {
    let is_sampled = |s: &Settings| s.setup.host_period_s == 0.0;
    if !settings.iter().all(is_sampled) {
        return None;
    }
    LoopLanes::try_new(settings.each_ref()).ok()?
}

/// A step, with the widest vectors of the processor.
struct Pass<'a, P> {
    group: &'a mut Group<P>,
    periods: u64,
    held: [Angle; ABREAST],
}

impl<P: PlantLanes<ABREAST>> pulp::NullaryFnOnce for Pass<'_, P> {
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
