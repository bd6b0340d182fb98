//! What a control period of each motion executes.

use std::collections::BTreeMap;

use board_tests::master::PERIODS;
use rand_pcg::{Pcg32, rand_core::Rng};
use virtual_board::run::{Flow, Script, View};

use crate::injection::Injection;
use crate::injector::Injector;
use crate::motion::Motion;
use crate::snapshots::send;
use crate::timetable::{Instant, Timetable};

/// The script of a board that is not disturbed after its warm-up. It records the addresses of the
/// instructions of the control period after the instant at which experiments are copied.
#[derive(Debug)]
pub struct Survey {
    timetable: Timetable,
    injector: Injector,
    recorded: Option<Motion>,
    /// These addresses, in the order of their execution, by motion.
    pub executed: BTreeMap<Motion, Vec<u32>>,
}

impl Survey {
    /// A survey of all motions.
    pub fn new(timetable: Timetable, injector: Injector) -> Self {
        Self {
            timetable,
            injector,
            recorded: None,
            executed: BTreeMap::new(),
        }
    }

    fn act(&mut self, view: &mut View<'_>, is_edge: bool) -> Flow {
        self.timetable.carry_out(view);
        if self.timetable.is_over(view.now_ns()) {
            return Flow::End;
        }
        if let Some(instant) = self.timetable.next(view.now_ns(), is_edge) {
            self.act_at(instant, view);
        }
        Flow::Continue
    }

    fn act_at(&mut self, instant: Instant, view: &mut View<'_>) {
        let Instant { motion, ms, .. } = instant;
        send(view, motion, ms);
        if instant.is_warm_up {
            self.timetable.carry_out_warm_up(ms, view, &self.injector);
        } else if ms == motion.typical_ms() + PERIODS as u32 {
            self.keep();
        } else if ms == motion.typical_ms() {
            self.recorded = Some(motion);
            self.injector.record_addresses();
        }
    }

    /// Keeps what was recorded of a motion.
    fn keep(&mut self) {
        if let Some(motion) = self.recorded.take() {
            self.executed.insert(motion, self.injector.take_addresses());
        }
    }
}

impl Script for Survey {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.act(view, true)
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.act(view, false)
    }
}

/// A skip of each instruction that these motions execute, in one of its executions, chosen at
/// random with this seed.
pub fn one_of_each(seed: u64, executed: &BTreeMap<Motion, Vec<u32>>) -> Vec<Injection> {
    let mut chosen = Vec::new();
    for (motion, addresses) in executed {
        let mut executions: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (number, address) in (0..).zip(addresses) {
            executions.entry(*address).or_default().push(number);
        }
        for (address, numbers) in executions {
            let mut random = Pcg32::new(seed, address.into());
            let at = (u64::from(random.next_u32()) * numbers.len() as u64) >> 32;
            let number = numbers[at as usize];
            chosen.push(Injection::of_period(*motion, number, address));
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_address_of_a_motion_is_skipped_once_at_an_execution_that_the_seed_decides() {
        let addresses = [4, 8, 4, 8, 12, 4, 8].repeat(20);
        let executed = BTreeMap::from([
            (Motion::Position, addresses.clone()),
            (Motion::Holding, vec![4]),
        ]);
        let of = |seed| one_of_each(seed, &executed);
        let chosen = of(1);
        let skipped: Vec<_> = (chosen.iter())
            .filter(|it| it.motion == Motion::Position)
            .map(|it| addresses[it.instructions as usize])
            .collect();
        assert_eq!((skipped, chosen.len()), (vec![4, 8, 12], 4));
        assert_eq!(of(1), chosen);
        assert_ne!(of(2), chosen);
    }
}
