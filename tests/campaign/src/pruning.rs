//! Which injections are simulated, and which of them others are judged by.

use std::collections::{BTreeMap, HashMap};

use crate::defuse::Decision;
use crate::injection::{Injection, Place};
use crate::outcome::{Basis, Outcome, Verdict};
use crate::twin::Twin;

/// Bytes of a number in a report.
const BYTES: usize = size_of::<u32>();

/// Bytes of a verdict in a report.
const VERDICT_BYTES: usize = 4 * BYTES;

/// What the copy that records reports.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// The undisturbed twin.
    pub twin: Twin,
    /// The decisions on the injections of its motion, in the order of their instants; none if
    /// nothing was recorded.
    pub decisions: Vec<Decision>,
}

impl Report {
    /// The report as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let count = (self.decisions.len() as u32).to_le_bytes();
        let decisions = self
            .decisions
            .iter()
            .flat_map(|it| it.to_number().to_le_bytes());
        let twin = self.twin.to_bytes();
        count.into_iter().chain(decisions).chain(twin).collect()
    }

    /// The report of these bytes; of none, one without decisions and with an empty twin.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let Some((count, rest)) = bytes.split_first_chunk() else {
            return Self::default();
        };
        let end = BYTES * u32::from_le_bytes(*count) as usize;
        let (decisions, twin) = rest.split_at(end.min(rest.len()));
        Self {
            twin: Twin::from_bytes(twin),
            decisions: numbers(decisions).map(Decision::from_number).collect(),
        }
    }
}

/// A verdict, and the indices of the injections that are not judged by it, as bytes.
pub fn to_bytes(verdict: Verdict, exceptions: &[u32]) -> Vec<u8> {
    let mut bytes = verdict.to_bytes();
    bytes.extend(exceptions.iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

fn numbers(bytes: &[u8]) -> impl Iterator<Item = u32> {
    let (words, _) = bytes.as_chunks();
    words.iter().copied().map(u32::from_le_bytes)
}

/// An injection among others.
pub type Key = (Place, u64);

/// The key of an injection.
pub fn key(injection: &Injection) -> Key {
    (injection.place, injection.number)
}

/// Injections that are judged by the experiment of another one, by the key of that.
pub type Members = HashMap<Key, Vec<Injection>>;

/// What the decisions on the injections of a motion lead to.
#[derive(Debug, Default)]
pub struct Plan {
    /// Those that are simulated.
    pub simulated: Vec<Injection>,
    /// Those without effect.
    pub harmless: Vec<Injection>,
    /// Those that are judged by one of the first.
    pub members: Members,
}

impl Plan {
    /// The plan for these injections, which are in the order of their instants. The last of those
    /// that a check reads first stands for the others.
    pub fn new(injections: &[Injection], decisions: &[Decision]) -> Self {
        let mut plan = Self::default();
        let mut checked: BTreeMap<(Place, u32), Vec<Injection>> = BTreeMap::new();
        for (index, injection) in injections.iter().enumerate() {
            match decisions.get(index).unwrap_or(&Decision::Simulate) {
                Decision::Simulate => plan.simulated.push(*injection),
                Decision::NoEffect => plan.harmless.push(*injection),
                Decision::Checked(pass) => {
                    let class = checked.entry((injection.place, *pass)).or_default();
                    class.push(*injection);
                }
            }
        }
        for mut class in checked.into_values() {
            if let Some(last) = class.pop() {
                plan.simulated.push(last);
                if !class.is_empty() {
                    plan.members.insert(key(&last), class);
                }
            }
        }
        plan
    }
}

/// The verdicts on injections that the experiment of another one may stand for, and those for which
/// it does not.
pub fn judge(
    experiment: &Injection,
    members: Vec<Injection>,
    report: &[u8],
) -> (Vec<(Injection, Verdict)>, Vec<Injection>) {
    let (verdict, exceptions) = report.split_at(VERDICT_BYTES.min(report.len()));
    let verdict = Verdict::from_bytes(verdict);
    let exceptions: Vec<u32> = numbers(exceptions).collect();
    // The experiment's own injection is behind the others.
    let is_exception = exceptions.contains(&(members.len() as u32));
    if verdict.outcome != Outcome::Told || is_exception {
        return (Vec::new(), members);
    }
    let (mut judged, mut others) = (Vec::new(), Vec::new());
    for (index, injection) in members.into_iter().enumerate() {
        if exceptions.contains(&(index as u32)) {
            others.push(injection);
        } else {
            judged.push((
                injection,
                later(verdict, experiment.at_ms - injection.at_ms),
            ));
        }
    }
    (judged, others)
}

/// The verdict on an injection that is made earlier.
fn later(verdict: Verdict, earlier_ms: u32) -> Verdict {
    Verdict {
        told_ms: verdict.told_ms.map(|told_ms| told_ms + earlier_ms),
        safe_ms: if verdict.safe_ms == 0 {
            0
        } else {
            verdict.safe_ms + earlier_ms
        },
        basis: Basis::Recording,
        ..verdict
    }
}

/// The verdict in a report of an experiment.
pub fn verdict(report: &[u8]) -> Verdict {
    Verdict::from_bytes(&report[..VERDICT_BYTES.min(report.len())])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn injection(number: u64, at_ms: u32) -> Injection {
        Injection {
            at_ms,
            ..Injection::draw(1, number, Place::Ram, std::slice::from_ref(&(0..100)))
        }
    }

    fn told() -> Verdict {
        Verdict {
            outcome: Outcome::Told,
            told_ms: Some(4),
            ..Verdict::UNJUDGED
        }
    }

    #[test]
    fn the_last_injection_before_a_check_stands_for_the_others_but_for_its_exceptions() {
        let injections: Vec<_> = (0..6).map(|at| injection(at, 10 * at as u32)).collect();
        let checked = Decision::Checked;
        let decisions = [
            checked(1),
            Decision::NoEffect,
            checked(1),
            Decision::Simulate,
            checked(1),
            checked(2),
        ];
        let mut plan = Plan::new(&injections, &decisions);
        let of = |indices: &[usize]| indices.iter().map(|at| injections[*at]).collect::<Vec<_>>();
        assert_eq!(plan.simulated, of(&[3, 4, 5]));
        assert_eq!(plan.harmless, of(&[1]));
        let members = plan.members.remove(&key(&injections[4])).unwrap();
        assert_eq!(members, of(&[0, 2]));
        assert!(plan.members.is_empty());
        let (judged, others) = judge(&injections[4], members.clone(), &to_bytes(told(), &[1]));
        let earlier = Verdict {
            told_ms: Some(44),
            basis: Basis::Recording,
            ..told()
        };
        assert_eq!(judged, [(injections[0], earlier)]);
        assert_eq!(others, of(&[2]));
        let own = to_bytes(told(), &[2]);
        for report in [vec![], Verdict::UNJUDGED.to_bytes(), own] {
            let (judged, others) = judge(&injections[4], members.clone(), &report);
            assert_eq!((judged, others), (vec![], members.clone()));
        }
    }

    #[test]
    fn without_decisions_all_are_simulated() {
        let injections = [injection(0, 1), injection(1, 2)];
        assert_eq!(Plan::new(&injections, &[]).simulated, injections);
    }

    #[test]
    fn a_report_is_the_same_after_its_way_as_bytes() {
        let report = Report {
            decisions: vec![Decision::Checked(3), Decision::NoEffect],
            ..Report::default()
        };
        assert_eq!(Report::from_bytes(&report.to_bytes()), report);
        assert_eq!(Report::from_bytes(&[]), Report::default());
        let bytes = to_bytes(told(), &[7]);
        assert_eq!(verdict(&bytes), told());
        assert_eq!(verdict(&[]), Verdict::UNJUDGED);
    }
}
