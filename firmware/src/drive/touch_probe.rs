//! Touch probes, 60B8h to 60BDh. Their only source is the index of the encoder, which is one count
//! wide: its positive edge is where the shaft enters it, its negative edge where it leaves it.

use canopen::Abort;

/// Half of a count of the encoder, mdeg.
const HALF_COUNT_MDEG: i32 = 44;

/// A turn, mdeg.
const TURN_MDEG: i32 = 360_000;

/// Bits of 60B8h for one probe: enabled, not only the first event, index instead of an input,
/// another source, positive edge, negative edge.
const ENABLE: u16 = 1 << 0;
const CONTINUOUS: u16 = 1 << 1;
const INDEX: u16 = 1 << 2;
const OTHER_SOURCE: u16 = 1 << 3;
const EDGES: [u16; 2] = [1 << 4, 1 << 5];

/// Bits of 60B9h for one probe: enabled, and a position of each edge.
const IS_ENABLED: u16 = 1 << 0;
const HAS_POSITION: [u16; 2] = [1 << 1, 1 << 2];

/// One probe.
#[derive(Debug, Clone, Copy, Default)]
struct Probe {
    function: u16,
    status: u16,
    positions: [i32; 2],
}

impl Probe {
    fn set(&mut self, function: u16) {
        if function & ENABLE == 0 {
            self.status = 0;
        } else if function != self.function {
            self.status = IS_ENABLED;
        }
        self.function = function;
    }

    fn latch(&mut self, edge: usize, position: i32) {
        let selected = EDGES.get(edge).is_some_and(|bit| self.function & bit != 0);
        let Some(bit) = HAS_POSITION.get(edge).filter(|_| selected) else {
            return;
        };
        let is_open = self.function & CONTINUOUS != 0 || self.status & bit == 0;
        if let Some(place) = self.positions.get_mut(edge).filter(|_| is_open) {
            *place = position;
            self.status |= bit;
        }
    }
}

/// Both probes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TouchProbes {
    probes: [Probe; 2],
    /// The last angle of the encoder, mdeg.
    last_mdeg: Option<i32>,
}

impl TouchProbes {
    /// 60B8h.
    pub fn function(&self) -> u16 {
        let [first, second] = self.probes.map(|probe| probe.function);
        first | second << 8
    }

    /// Sets 60B8h; refuses sources that the board does not have.
    pub fn set(&mut self, function: u16) -> Result<(), Abort> {
        let halves = [function & 0xFF, function >> 8];
        let is_possible = |half: &u16| half & ENABLE == 0 || half & (INDEX | OTHER_SOURCE) == INDEX;
        if !halves.iter().all(is_possible) {
            return Err(Abort::Value);
        }
        if self.function() == 0 {
            self.last_mdeg = None;
        }
        for (probe, half) in self.probes.iter_mut().zip(halves) {
            probe.set(half);
        }
        Ok(())
    }

    /// 60B9h.
    pub fn status(&self) -> u16 {
        let [first, second] = self.probes.map(|probe| probe.status);
        first | second << 8
    }

    /// The position of a probe at its positive edge, 0, or its negative one, 1.
    pub fn position(&self, probe: usize, edge: usize) -> i32 {
        let probe = self.probes.get(probe);
        let position = probe.and_then(|probe| probe.positions.get(edge));
        position.copied().unwrap_or(0)
    }

    /// The shaft has turned to this angle of the encoder, mdeg, if it is known; `origin` is the
    /// position of its zero.
    pub fn turned(&mut self, angle_mdeg: Option<i32>, origin_mdeg: i32) {
        let before = core::mem::replace(&mut self.last_mdeg, angle_mdeg);
        let is_used = self.status() != 0;
        let Some((before, now)) = before.zip(angle_mdeg).filter(|_| is_used) else {
            return;
        };
        let direction = (now - before).signum();
        // The index that is nearest to where the shaft is now.
        let near = now.saturating_add(TURN_MDEG / 2);
        let index = near - near.rem_euclid(TURN_MDEG);
        for (edge, side) in [(0, -HALF_COUNT_MDEG), (1, HALF_COUNT_MDEG)] {
            let place = index.saturating_add(side * direction);
            let was_short = (place - before) * direction > 0;
            if was_short && (now - place) * direction >= 0 {
                for probe in &mut self.probes {
                    probe.latch(edge, place.saturating_add(origin_mdeg));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probes(function: u16, angles: &[i32]) -> TouchProbes {
        let mut probes = TouchProbes::default();
        assert!(probes.set(function).is_ok());
        for angle in angles {
            probes.turned(Some(*angle), 5_000);
        }
        probes
    }

    #[test]
    fn both_edges_of_the_index_are_latched_in_both_directions_and_each_turn() {
        for (angles, edges) in [
            ([-1_000, 1_000], [4_956, 5_044]),
            ([1_000, -1_000], [5_044, 4_956]),
            ([359_000, 361_000], [364_956, 365_044]),
            ([-359_000, -361_000], [-354_956, -355_044]),
        ] {
            let probes = probes(0x35, &angles);
            assert_eq!(probes.status(), 0x07);
            assert_eq!([0, 1].map(|edge| probes.position(0, edge)), edges);
        }
    }

    #[test]
    fn the_first_event_is_kept_and_the_last_one_in_continuous_mode() {
        let angles = [-1_000, 1_000, -1_000];
        assert_eq!(probes(0x15, &angles).position(0, 0), 4_956);
        assert_eq!(probes(0x17, &angles).position(0, 0), 5_044);
        // Probe 2, negative edge only.
        let second = probes(0x2500, &angles);
        assert_eq!((second.status(), second.position(1, 1)), (0x0500, 5_044));
    }

    #[test]
    fn nothing_is_latched_beside_the_index_or_without_an_angle() {
        assert_eq!(
            probes(0x35, &[1_000, 179_000, 181_000, 358_000]).status(),
            1
        );
        let mut probes = probes(0x35, &[-1_000]);
        probes.turned(None, 0);
        probes.turned(Some(1_000), 0);
        assert_eq!(probes.status(), 1);
    }

    #[test]
    fn only_the_index_is_a_source_and_a_disabled_probe_has_no_status() {
        let mut probes = probes(0x35, &[-1_000, 1_000]);
        for refused in [0x11, 0x1D, 0x1100] {
            assert_eq!(probes.set(refused), Err(Abort::Value), "{refused:x}");
        }
        assert_eq!(probes.function(), 0x35);
        assert_eq!((probes.set(0), probes.status()), (Ok(()), 0));
    }
}
