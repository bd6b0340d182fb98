//! The lost motion between motor and shaft: play of the gears, and their elasticity under friction.
//!
//! A motion against the direction of the last one first takes up the play: the motor turns, and
//! the shaft does not. The integral of the back-EMF is the travel of the motor, so
//!
//! ```text
//! play = E(first)/K - travel(first)
//! K = (E(second) - E(first))/(travel(second) - travel(first))
//! ```
//!
//! with the integrals until the shaft has travelled a first and a second angle. `K` is that of the
//! same motion: the play is not in it. The integrals begin with the rest before the motion: there
//! the noise of the encoder turns the motor within the play. The mean back-EMF while the bridge is
//! off is the offset, and is subtracted. A load that presses the gears to one side hides the play.

use super::{Mean, statistics::Statistics};
use crate::timing::{periods, thousandths};
use model_core::control::units::Angle;

/// The first and the second angle of a motion, mdeg.
const FIRST_MDEG: i32 = 8_000;
const SECOND_MDEG: i32 = 24_000;

/// The greatest play, that of objects 2053h:8 and 10, mdeg.
const MOST_MDEG: i32 = 20_000;

/// The shaft is at rest while it stays within this angle, mdeg: two counts of the encoder, and half
/// a count of noise.
const REST_MDEG: i32 = 220;

/// Control periods of a rest at least, 0.1 s.
const SHORTEST_REST: u16 = periods(100);

/// Control periods of a rest and its motion at most, 30 s: the offset is known to 0.1 mV, which is
/// 0.15 deg of 20 mV s/deg then, and cancels in the mean of both ways where their rests are equal.
const LONGEST: u16 = periods(30_000);

/// Motions of a mean, and those of each way after which it is known.
const LENGTH: u16 = 32;
const ENOUGH: u16 = 4;

/// Parts of a mV in which the offset is kept, and the control periods of its mean, 60 s.
const OFFSET_PARTS: i32 = 16;
const OFFSET_LENGTH: u16 = periods(60_000);

/// What the shaft does since the last place where it rested, or which it passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Motion {
    /// It rests, or moves on by steps.
    #[default]
    None,
    /// It turns from a rest against the direction of the last motion: the sum of the back-EMF, mV
    /// times control periods, in its direction, and the travel, mdeg, at the first angle.
    Runs { first: Option<(i32, i32)> },
}

/// The mean of one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Way {
    count: u16,
    mdeg: Mean,
}

/// The lost motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Play {
    motion: Motion,
    /// The direction of the motion, or of the last one; 0 before the first.
    sign: i32,
    /// Where the shaft rested last, or passed; `None` until it is measured.
    from: Option<Angle>,
    /// Control periods since then, and the sum of the back-EMF, mV.
    periods: u16,
    sum: i32,
    /// The offset of the back-EMF, in parts of a mV, and the number of its values.
    offset: Mean,
    offsets: u16,
    positive: Way,
    negative: Way,
    statistics: Statistics,
}

impl Play {
    /// Nothing is taken from the present motion, which has no measurements.
    pub fn interrupt(&mut self) {
        self.restart(None, 0);
    }

    /// Without motions, but for the offset.
    pub fn anew(self) -> Self {
        Self {
            offset: self.offset,
            offsets: self.offsets,
            ..Self::default()
        }
    }

    /// Takes the back-EMF, mV, while the bridge is off. Below `least_mv` the motor hardly turns.
    pub fn idle(&mut self, mean_mv: i32, least_mv: i32) {
        if mean_mv.abs() < least_mv {
            self.offsets = self.offsets.saturating_add(1).min(OFFSET_LENGTH);
            self.offset.take(mean_mv * OFFSET_PARTS, self.offsets);
        }
    }

    /// The offset of the back-EMF, mV; 0 until it is measured.
    pub fn offset_mv(&self) -> i32 {
        self.offset.whole() / OFFSET_PARTS
    }

    /// The shaft has come to this place in a direction.
    fn restart(&mut self, from: Option<Angle>, sign: i32) {
        self.motion = Motion::None;
        (self.from, self.sign) = (from, sign);
        (self.periods, self.sum) = (0, 0);
    }

    /// Takes the mean back-EMF of a control period, mV, and the angle at its end.
    pub fn observe(&mut self, mean_mv: i32, angle: Angle) {
        self.periods = self.periods.saturating_add(1).min(LONGEST);
        self.sum = self.sum.saturating_add(mean_mv);
        let travel = thousandths(angle - *self.from.get_or_insert(angle));
        match self.motion {
            Motion::None if travel.abs() > REST_MDEG => self.leave(travel.signum(), angle),
            Motion::None => {}
            Motion::Runs { first } => self.run(first, self.sign * travel, angle),
        }
    }

    /// The shaft leaves the place in this direction.
    fn leave(&mut self, sign: i32, angle: Angle) {
        let is_from_rest = (SHORTEST_REST..LONGEST).contains(&self.periods);
        if is_from_rest && self.sign == -sign {
            self.motion = Motion::Runs { first: None };
            self.sign = sign;
        } else {
            self.restart(Some(angle), sign);
        }
    }

    /// A motion goes on, to this travel in its direction.
    fn run(&mut self, first: Option<(i32, i32)>, travel: i32, angle: Angle) {
        // Below 2^14 times 30,000 control periods.
        let offset = self.offset.whole() * i32::from(self.periods) / OFFSET_PARTS;
        let sum = self.sign * self.sum.saturating_sub(offset);
        match first {
            _ if travel < -REST_MDEG => self.restart(Some(angle), -self.sign),
            _ if self.periods == LONGEST => {
                // No new rest, and of a direction that the next travel shows.
                self.motion = Motion::None;
                self.from = Some(angle);
            }
            None if travel >= FIRST_MDEG => {
                self.motion = Motion::Runs {
                    first: Some((sum, travel)),
                };
            }
            Some(first) if travel >= SECOND_MDEG => {
                if let Some(mdeg) = play(first, (sum, travel)) {
                    self.take(mdeg);
                }
                self.restart(Some(angle), self.sign);
            }
            _ => {}
        }
    }

    /// Takes the play of a motion, mdeg.
    fn take(&mut self, mdeg: i32) {
        let way = if self.sign > 0 {
            &mut self.positive
        } else {
            &mut self.negative
        };
        way.count = way.count.saturating_add(1).min(LENGTH);
        way.mdeg.take(mdeg, way.count);
        self.statistics.value(self.sign > 0, mdeg, 1);
    }

    /// Motions of the mean, of the way that has fewer.
    fn motions(&self) -> u16 {
        self.positive.count.min(self.negative.count)
    }

    /// The play, mdeg; `None` before there are enough motions.
    pub fn mdeg(&self) -> Option<i32> {
        let (ahead, back) = (self.positive.mdeg.whole(), self.negative.mdeg.whole());
        (self.motions() >= ENOUGH).then_some(ahead.midpoint(back))
    }

    /// Its standard error, mdeg.
    pub fn standard_error(&self) -> Option<i32> {
        self.mdeg()?;
        self.statistics.standard_error(2 * self.motions())
    }
}

/// The play, mdeg, from sums of the back-EMF and travels until the first and the second angle;
/// `None` beyond what is plausible: the back-EMF was not measured all the time.
fn play((sum_1, travel_1): (i32, i32), (sum_2, travel_2): (i32, i32)) -> Option<i32> {
    let motor = i64::from(sum_1) * i64::from(travel_2 - travel_1);
    let motor = motor.checked_div(i64::from(sum_2 - sum_1))?;
    let play = i32::try_from(motor - i64::from(travel_1)).ok()?;
    (-MOST_MDEG..=MOST_MDEG).contains(&play).then_some(play)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::angle_of_mdeg;

    /// A shaft with this play, mdeg, and its motor of 20 mV s/deg.
    struct Bench {
        play: Play,
        play_mdeg: i32,
        /// What is left of the play in the direction of the last motion.
        gap_mdeg: i32,
        sign: i32,
        shaft_mdeg: i32,
        offset_mv: i32,
    }

    impl Bench {
        fn new(play_mdeg: i32, offset_mv: i32) -> Self {
            Self {
                play: Play::default(),
                play_mdeg,
                gap_mdeg: 0,
                sign: 1,
                shaft_mdeg: 0,
                offset_mv,
            }
        }

        /// A motion of 28 deg in this direction, at 50 deg/s first, then at 100 deg/s, and so many
        /// control periods at rest.
        fn turn(&mut self, sign: i32, rest: u32) {
            if self.sign != sign {
                (self.sign, self.gap_mdeg) = (sign, self.play_mdeg - self.gap_mdeg);
            }
            for period in 0..80 {
                let rate = if period < 20 { 50 } else { 100 };
                let motor_mdeg = rate * 4;
                let in_gap = self.gap_mdeg.min(motor_mdeg);
                self.gap_mdeg -= in_gap;
                self.shaft_mdeg += sign * (motor_mdeg - in_gap);
                self.observe(sign * rate * 20);
            }
            (0..rest).for_each(|_| self.observe(0));
        }

        fn observe(&mut self, back_emf_mv: i32) {
            let mean_mv = back_emf_mv + self.offset_mv;
            let angle = angle_of_mdeg(self.shaft_mdeg);
            self.play.observe(mean_mv, angle);
        }
    }

    /// Motions to and fro, with these control periods at rest behind each.
    fn moved(play_mdeg: i32, offset_mv: i32, mut rest: impl FnMut(u32) -> u32) -> Play {
        let mut bench = Bench::new(play_mdeg, offset_mv);
        (0..100).for_each(|_| bench.play.idle(offset_mv, 100));
        for motion in 0..17 {
            bench.turn(if motion % 2 == 0 { 1 } else { -1 }, rest(motion));
        }
        bench.play
    }

    #[test]
    fn the_angle_that_the_motor_turns_alone_is_the_play_whatever_the_offset() {
        for (play_mdeg, offset_mv) in [(0, 0), (200, 0), (1_000, 0), (1_000, 80), (3_000, -80)] {
            let rest = |motion| if motion % 2 == 0 { 50 } else { 400 };
            let found = moved(play_mdeg, offset_mv, rest).mdeg();
            // The offset is known to a sixteenth of a mV: in 400 control periods 5 mdeg.
            let off = found.expect("eight motions each way") - play_mdeg;
            assert!(off.abs() <= 5, "{play_mdeg}, {offset_mv}: {found:?}");
        }
    }

    #[test]
    fn a_motion_on_in_the_direction_of_the_last_one_does_not_count() {
        let mut bench = Bench::new(1_000, 0);
        for motion in 0..32 {
            bench.turn(if motion % 4 < 2 { 1 } else { -1 }, 50);
        }
        assert_eq!(bench.play.mdeg(), Some(1_000));
    }

    #[test]
    fn a_reversal_without_a_rest_behind_one_that_does_not_count_shows_no_play() {
        let mut bench = Bench::new(1_000, 0);
        for motion in 0..32 {
            // On, on, and back at once.
            let (sign, rest) = [(1, 50), (1, 0), (-1, 50), (-1, 0)][motion % 4];
            bench.turn(sign, rest);
        }
        assert_eq!(bench.play.mdeg(), None);
    }

    #[test]
    fn a_back_emf_that_ceases_is_no_play() {
        assert_eq!(play((300_000, 8_000), (300_001, 24_000)), None);
        assert_eq!(play((300_000, 8_000), (300_000, 24_000)), None);
        assert_eq!(play((45_000, 8_000), (125_000, 24_000)), Some(1_000));
    }

    #[test]
    fn a_motion_that_does_not_begin_at_rest_shows_no_play() {
        assert_eq!(moved(1_000, 0, |_| 10).mdeg(), None);
        // The first motion has none against it.
        let rest_until = |last| move |it| if it < last { 50 } else { 0 };
        assert_eq!(moved(1_000, 0, rest_until(8)).mdeg(), Some(1_000));
        assert_eq!(moved(1_000, 0, rest_until(7)).mdeg(), None);
    }

    #[test]
    fn an_interrupted_motion_shows_no_play() {
        // Interrupted at 28 deg, and at -28 deg; then back, or on, at once or from rest.
        for (before, after) in [(1, -1), (1, 1), (-1, 1), (-1, -1)] {
            for rest in [0, 50] {
                let mut bench = Bench::new(1_000, 0);
                bench.turn(before, 50);
                bench.play.interrupt();
                (0..rest).for_each(|_| bench.observe(0));
                bench.turn(after, 0);
                let Play {
                    positive, negative, ..
                } = bench.play;
                assert_eq!((positive, negative), (Way::default(), Way::default()));
            }
        }
    }

    #[test]
    fn a_motion_and_its_rest_of_more_than_30_s_show_no_play() {
        let mut bench = Bench::new(1_000, 0);
        bench.turn(1, u32::from(LONGEST));
        bench.turn(-1, 50);
        assert_eq!(bench.play.negative, Way::default());
        // The shaft stops 5 deg behind a rest; the motor may have turned since.
        let mut bench = Bench::new(1_000, 0);
        bench.turn(1, 50);
        for period in 0..u32::from(LONGEST) {
            bench.shaft_mdeg -= if period < 50 { 100 } else { 0 };
            bench.observe(if period < 50 { -500 } else { 0 });
        }
        bench.turn(1, 50);
        assert_eq!(bench.play.positive, Way::default());
    }

    #[test]
    fn a_motor_that_turns_within_the_play_at_rest_hides_nothing_of_it() {
        let mut bench = Bench::new(1_000, 0);
        for motion in 0..16 {
            bench.turn(if motion % 2 == 0 { 1 } else { -1 }, 50);
            // Back by 0.8 deg, in 100 control periods at 2 deg/s, of the 1 deg.
            bench.gap_mdeg = 800;
            (0..100).for_each(|_| bench.observe(-bench.sign * 40));
        }
        let found = bench.play.mdeg().expect("eight motions each way");
        assert!((found - 1_000).abs() <= 5, "{found}");
    }
}
