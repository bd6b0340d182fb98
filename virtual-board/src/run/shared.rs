//! One bus for several boards, each of which runs in its own thread.
//!
//! No station can begin a frame while one is on the bus, and the outcome of a frame is known when
//! it begins: until it ends, the boards run independently. On a free bus they synchronise: each
//! reports whether it has a frame to transmit and since when, and arbitration takes place at the
//! earliest of these instants. Without a frame to transmit they synchronise after [`QUANTUM_NS`],
//! which is less than the shortest frame: a frame that began within the quantum has not ended, and
//! has not affected the other boards yet. While the cores of all boards sleep, they synchronise one
//! quantum after the first instant at which something may wake one of them. Arbitration,
//! acknowledgement and the instants of frames are therefore exact to the nanosecond. Only an error
//! frame, which is shorter, may be detected up to a quantum after its end.
//!
//! The same programs and scripts give the same frames, however the threads are scheduled.

mod rendezvous;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};

use rigless::time::VirtualNanos;

use self::rendezvous::{Rendezvous, Turns};
use crate::can::{Port, Sent, Station, Transfer, Wire};
use crate::chip::ActuatorChip;

/// Time between two synchronisations on a free bus while a core runs, ns: a frame without data
/// takes 44 bits, 44 us at 1 Mbit/s.
pub const QUANTUM_NS: u64 = 40_000;

/// The same in real time, where the short quantum would take more time than the boards: a frame
/// that begins on a free bus is detected up to this much later. The outcome of arbitration does not
/// change.
const REAL_TIME_QUANTUM_NS: u64 = 200_000;

/// A run that is ahead of real time by more than this sleeps.
const MIN_SLEEP: Duration = Duration::from_micros(500);

/// A run that is behind real time by more than this does not catch up.
const MAX_LAG: Duration = Duration::from_millis(20);

/// State of a board at a synchronisation.
#[derive(Debug, Clone, Copy)]
struct StationState {
    station: Option<Station>,
    since_ns: Option<u64>,
    /// The board gets no frame to transmit before this instant, unless it receives one.
    quiet_until_ns: u64,
}

/// Outcome of a synchronisation.
#[derive(Debug, Clone, Copy)]
struct SyncOutcome {
    began: Option<((u64, u64), Transfer)>,
    next_ns: u64,
}

#[derive(Debug)]
struct SharedBusState {
    wire: Wire,
    /// `None` before the first synchronisation of a board, and after it has left the bus.
    boards: Vec<Option<StationState>>,
    present: Vec<bool>,
    turns: Turns,
    at_ns: u64,
    quantum_ns: u64,
    /// The boards are quiet until then.
    quiet_until_ns: u64,
    /// Real time of virtual time zero.
    pace: Option<Instant>,
}

impl SharedBusState {
    /// Called when every board has reached the synchronisation: ends the frame whose time has
    /// elapsed, and arbitrates if the bus is free.
    fn synchronise_all(&mut self) -> SyncOutcome {
        let now_ns = self.at_ns;
        let mut offers_ns = self.boards.iter().flatten().filter_map(|b| b.since_ns);
        debug_assert!(offers_ns.all(|since_ns| since_ns >= self.quiet_until_ns));
        self.wire.finish(now_ns, self.boards.len());
        if self.pace.is_some() {
            // It would grow without end.
            drop(self.wire.take_log());
        }
        let began = (!self.wire.is_busy()).then(|| self.arbitrate(now_ns));
        let began = began.flatten();
        let next_ns;
        (next_ns, self.quiet_until_ns) = match &began {
            Some(_) => (self.wire.free_at_ns().max(now_ns + 1), 0),
            None => {
                let quiet_until_ns = self.all_quiet_until_ns();
                (self.next_sync_ns(now_ns, quiet_until_ns), quiet_until_ns)
            }
        };
        self.at_ns = next_ns;
        SyncOutcome { began, next_ns }
    }

    /// The first instant at which a board may get a frame to transmit.
    fn all_quiet_until_ns(&self) -> u64 {
        // In real time the ports receive frames at instants that are not known before.
        if self.pace.is_some() {
            return 0;
        }
        let boards = self.boards.iter().flatten();
        let instants_ns = boards.map(|board| board.quiet_until_ns);
        instants_ns.min().unwrap_or(0)
    }

    /// A quantum after a frame may begin, or when a port's frame is due.
    fn next_sync_ns(&self, now_ns: u64, quiet_until_ns: u64) -> u64 {
        let due_ns = self.wire.next_ns(now_ns, false);
        let due_ns = due_ns.filter(|due_ns| *due_ns > now_ns);
        quiet_until_ns
            .max(now_ns)
            .saturating_add(self.quantum_ns)
            .min(due_ns.unwrap_or(u64::MAX))
    }

    fn arbitrate(&mut self, now_ns: u64) -> Option<((u64, u64), Transfer)> {
        let offers = self.boards.iter().flatten().filter_map(|b| b.since_ns);
        let ports_ns = self.wire.next_ns(0, false);
        let earliest_ns = offers.chain(ports_ns).min()?;
        if earliest_ns > now_ns {
            return None;
        }
        let start_ns = earliest_ns.max(self.wire.free_at_ns());
        let stations: Vec<_> = (self.boards.iter())
            .map(|board| {
                let StationState {
                    station, since_ns, ..
                } = (*board)?;
                let offers = since_ns.is_some_and(|since_ns| since_ns <= start_ns);
                station.map(|station| Station {
                    offer: station.offer.filter(|_| offers),
                    ..station
                })
            })
            .collect();
        let (ends_ns, transfer) = self.wire.start(start_ns, &stations)?;
        Some(((start_ns, ends_ns.max(now_ns)), transfer))
    }

    /// By how much the run is ahead of real time.
    fn keep_pace(&mut self) -> Option<Duration> {
        let begun = self.pace.as_mut()?;
        let due = *begun + Duration::from_nanos(self.at_ns);
        let now = Instant::now();
        if now > due + MAX_LAG {
            *begun += now - due;
        }
        (due > now + MIN_SLEEP).then(|| due - now)
    }
}

/// What the boards share.
#[derive(Debug)]
struct Shared {
    state: Mutex<SharedBusState>,
    /// Outcome of the last synchronisation.
    outcome: RwLock<SyncOutcome>,
    rendezvous: Rendezvous,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, SharedBusState> {
        // A board that panicked has left the bus; no state is modified across a possible panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// If all boards have reached it, synchronises and begins the next round; otherwise resumes
    /// `next`.
    fn synchronise(&self, mut state: MutexGuard<'_, SharedBusState>, next: Option<usize>) {
        let mut resumed: Vec<_> = next.into_iter().collect();
        if state.is_complete() {
            if let Some(early) = state.keep_pace() {
                self.rendezvous.pause(early);
            }
            let outcome = state.synchronise_all();
            *self.outcome.write().unwrap_or_else(PoisonError::into_inner) = outcome;
            resumed = state.turns.begin_round();
        }
        drop(state);
        for index in resumed {
            self.rendezvous.resume(index);
        }
    }
}

/// A bus for several boards.
#[derive(Debug, Clone)]
pub struct SharedBus(Arc<Shared>);

impl SharedBus {
    /// A bus with these ports and this number of boards, which runs as fast as possible.
    pub fn new(ports: Vec<Port>, boards: usize) -> Self {
        let rendezvous = Rendezvous::new(boards);
        let state = SharedBusState {
            wire: Wire::new(ports),
            boards: vec![None; boards],
            present: vec![true; boards],
            turns: rendezvous.turns(),
            at_ns: QUANTUM_NS,
            quantum_ns: QUANTUM_NS,
            quiet_until_ns: 0,
            pace: None,
        };
        Self(Arc::new(Shared {
            state: Mutex::new(state),
            outcome: RwLock::new(SyncOutcome {
                began: None,
                next_ns: QUANTUM_NS,
            }),
            rendezvous,
        }))
    }

    /// Runs in real time: the virtual time of no board is ahead of it.
    #[must_use]
    pub fn in_real_time(self) -> Self {
        let mut state = self.0.lock();
        state.pace = Some(Instant::now());
        state.quantum_ns = REAL_TIME_QUANTUM_NS;
        drop(state);
        self
    }

    /// The boards' connections, each for one run. A board leaves the bus when its connection is
    /// dropped.
    pub fn connections(&self) -> Vec<BusConnection> {
        let boards = self.0.lock().boards.len();
        let connection = |index| BusConnection {
            bus: self.clone(),
            index,
            next_ns: QUANTUM_NS,
            is_busy: false,
        };
        (0..boards).map(connection).collect()
    }

    /// Access to a port.
    pub fn with_port<T>(&self, index: usize, act: impl FnOnce(&mut Port) -> T) -> Option<T> {
        self.0.lock().wire.ports.get_mut(index).map(act)
    }

    /// Every frame since the last call. Senders are numbered from 0, boards before ports.
    pub fn take_log(&self) -> Vec<Sent> {
        self.0.lock().wire.take_log()
    }
}

/// A board's connection to a shared bus.
#[derive(Debug)]
pub struct BusConnection {
    bus: SharedBus,
    index: usize,
    next_ns: u64,
    /// A frame is on the bus until the next synchronisation.
    is_busy: bool,
}

impl BusConnection {
    /// Instant of the next synchronisation, ns.
    pub(super) fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Synchronises with the other boards if it is due. The program of this board starts no
    /// transmission before `quiet_until_ns`, unless a frame ends here.
    pub(super) fn synchronise(
        &mut self,
        chip: &mut dyn ActuatorChip,
        at: VirtualNanos,
        quiet_until_ns: u64,
    ) {
        if at.0 < self.next_ns {
            return;
        }
        // A frame that was detected late ends at the instant at which the next one may begin.
        chip.end_frame(at);
        let (station, since_ns) = chip.station(at.0);
        let is_quiet = !self.is_busy && since_ns.is_none();
        let outcome = self.reach(StationState {
            station,
            since_ns,
            quiet_until_ns: if is_quiet { quiet_until_ns } else { 0 },
        });
        self.next_ns = outcome.next_ns;
        self.is_busy = outcome.began.is_some();
        if let Some((times_ns, transfer)) = outcome.began {
            chip.begin_frame(at, times_ns, transfer, self.index);
        }
    }

    fn reach(&self, station_state: StationState) -> SyncOutcome {
        let shared = &*self.bus.0;
        shared.rendezvous.join(self.index);
        let mut state = shared.lock();
        state.boards[self.index] = Some(station_state);
        let next = state.turns.wait(self.index);
        shared.synchronise(state, next);
        shared.rendezvous.wait(self.index, next.is_none());
        *shared
            .outcome
            .read()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl SharedBusState {
    /// Number of boards on the bus.
    fn present(&self) -> usize {
        self.present.iter().filter(|is_there| **is_there).count()
    }

    fn is_complete(&self) -> bool {
        self.present() > 0 && self.turns.waiting() == self.present()
    }
}

impl Drop for BusConnection {
    fn drop(&mut self) {
        let shared = &*self.bus.0;
        let mut state = shared.lock();
        state.present[self.index] = false;
        state.boards[self.index] = None;
        let next = state.turns.leave(self.index);
        shared.synchronise(state, next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::{Frame, Id};
    use crate::chip::Chip;
    use crate::flash::FlashTimes;

    /// Until when the boards are quiet, ns.
    const QUIET_NS: [u64; 2] = [700_000, 500_000];

    fn bus(frame_at_ns: u64) -> SharedBus {
        let mut port = Port::at_rate(1_000_000);
        port.send(frame_at_ns, Frame::data_frame(Id::Standard(0x80), &[]));
        // The other port acknowledges.
        SharedBus::new(vec![port, Port::at_rate(1_000_000)], QUIET_NS.len())
    }

    /// Both boards at their first synchronisation: the instant of the second one, ns.
    fn second_ns(bus: &SharedBus, quiet_ns: [u64; 2]) -> u64 {
        let mut state = bus.0.lock();
        state.boards = quiet_ns
            .map(|quiet_until_ns| StationState {
                station: None,
                since_ns: None,
                quiet_until_ns,
            })
            .map(Some)
            .to_vec();
        state.synchronise_all().next_ns
    }

    #[test]
    fn quiet_boards_synchronise_after_the_first_may_act_or_when_a_port_transmits() {
        let far_ns = 900_000;
        assert_eq!(second_ns(&bus(far_ns), QUIET_NS), 500_000 + QUANTUM_NS);
        assert_eq!(second_ns(&bus(300_000), QUIET_NS), 300_000);
        assert_eq!(second_ns(&bus(far_ns), [700_000, 0]), 2 * QUANTUM_NS);
        let in_real_time = second_ns(&bus(far_ns).in_real_time(), QUIET_NS);
        assert_eq!(in_real_time, QUANTUM_NS + REAL_TIME_QUANTUM_NS);
    }

    #[test]
    fn a_board_whose_program_sleeps_may_act_at_the_end_of_a_frame() {
        let begins_ns = 200_000;
        let bus = bus(begins_ns);
        let mut connections = bus.connections();
        connections.truncate(1);
        let mut chip = Chip::try_new(None, FlashTimes::TYPICAL, 0).unwrap();
        let mut synchronise = || {
            let now_ns = connections[0].next_ns();
            connections[0].synchronise(&mut chip, VirtualNanos(now_ns), u64::MAX);
            now_ns
        };
        assert_eq!([synchronise(), synchronise()], [QUANTUM_NS, begins_ns]);
        let ends_ns = synchronise();
        assert!(ends_ns > begins_ns);
        assert_eq!(synchronise(), ends_ns + QUANTUM_NS);
    }
}
