//! One bus for several boards, each of which runs in a thread of its own.
//!
//! No station can begin a frame while one is on the bus, and the outcome of a frame is known when
//! it begins: until it ends, the boards run independently. On a free bus they synchronise: each
//! reports whether it has a frame to transmit and since when, and arbitration takes place at the
//! earliest of these instants. Without a frame to transmit they synchronise after [`QUANTUM_NS`],
//! which is less than the shortest frame: a frame that began within the quantum has not ended, and
//! has not affected the other boards yet. Arbitration, acknowledgement and the instants of frames
//! are therefore exact to the nanosecond. Only an error frame, which is shorter, may be detected up
//! to a quantum after its end.
//!
//! The same programs and scripts give the same frames, however the threads are scheduled.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rigless::time::VirtualNanos;

use crate::can::{Port, Sent, Station, Transfer, Wire};
use crate::chip::ActuatorChip;

/// Longest time between two synchronisations on a free bus, ns: a frame without data takes 44 bits,
/// 44 us at 1 Mbit/s.
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
    /// `None` for a board that has not reached the synchronisation, or has left the bus.
    boards: Vec<Option<StationState>>,
    present: Vec<bool>,
    arrived: usize,
    round: u64,
    at_ns: u64,
    outcome: SyncOutcome,
    quantum_ns: u64,
    /// Real time of virtual time zero.
    pace: Option<Instant>,
}

impl SharedBusState {
    /// Called when every board has reached the synchronisation: ends the frame whose time has
    /// elapsed, and arbitrates if the bus is free.
    fn synchronise_all(&mut self) {
        let now_ns = self.at_ns;
        self.keep_pace();
        self.wire.finish(now_ns, self.boards.len());
        let began = (!self.wire.is_busy()).then(|| self.arbitrate(now_ns));
        let began = began.flatten();
        let next_ns = match &began {
            Some(_) => self.wire.free_at_ns().max(now_ns + 1),
            None => self.next_sync_ns(now_ns),
        };
        self.outcome = SyncOutcome { began, next_ns };
        self.at_ns = next_ns;
        self.arrived = 0;
        self.round += 1;
    }

    fn next_sync_ns(&self, now_ns: u64) -> u64 {
        let due_ns = self.wire.next_ns(now_ns, false);
        let due_ns = due_ns.filter(|due_ns| *due_ns > now_ns);
        (now_ns + self.quantum_ns).min(due_ns.unwrap_or(u64::MAX))
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
                let StationState { station, since_ns } = (*board)?;
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

    /// Sleeps while the run is ahead of real time.
    fn keep_pace(&mut self) {
        let Some(begun) = &mut self.pace else {
            return;
        };
        let due = *begun + Duration::from_nanos(self.at_ns);
        let now = Instant::now();
        if due > now + MIN_SLEEP {
            std::thread::sleep(due - now);
        } else if now > due + MAX_LAG {
            *begun += now - due;
        }
    }
}

/// A bus for several boards.
#[derive(Debug, Clone)]
pub struct SharedBus(Arc<(Mutex<SharedBusState>, Condvar)>);

impl SharedBus {
    /// A bus with these ports and this number of boards, which runs as fast as possible.
    pub fn new(ports: Vec<Port>, boards: usize) -> Self {
        let state = SharedBusState {
            wire: Wire::new(ports),
            boards: vec![None; boards],
            present: vec![true; boards],
            arrived: 0,
            round: 0,
            at_ns: QUANTUM_NS,
            outcome: SyncOutcome {
                began: None,
                next_ns: QUANTUM_NS,
            },
            quantum_ns: QUANTUM_NS,
            pace: None,
        };
        Self(Arc::new((Mutex::new(state), Condvar::new())))
    }

    /// Runs in real time: the virtual time of no board is ahead of it.
    #[must_use]
    pub fn in_real_time(self) -> Self {
        let mut state = self.lock();
        state.pace = Some(Instant::now());
        state.quantum_ns = REAL_TIME_QUANTUM_NS;
        drop(state);
        self
    }

    /// The boards' connections, each for one run. A board leaves the bus when its connection is
    /// dropped.
    pub fn connections(&self) -> Vec<BusConnection> {
        let boards = self.lock().boards.len();
        let connection = |index| BusConnection {
            bus: self.clone(),
            index,
            next_ns: QUANTUM_NS,
        };
        (0..boards).map(connection).collect()
    }

    /// Access to a port.
    pub fn with_port<T>(&self, index: usize, act: impl FnOnce(&mut Port) -> T) -> Option<T> {
        self.lock().wire.ports.get_mut(index).map(act)
    }

    /// Every frame since the last call. Senders are numbered from 0, boards before ports.
    pub fn take_log(&self) -> Vec<Sent> {
        self.lock().wire.take_log()
    }

    fn lock(&self) -> MutexGuard<'_, SharedBusState> {
        // A board that panicked has left the bus; no state is modified across a possible panic.
        (self.0.0.lock()).unwrap_or_else(PoisonError::into_inner)
    }
}

/// A board's connection to a shared bus.
#[derive(Debug)]
pub struct BusConnection {
    bus: SharedBus,
    index: usize,
    next_ns: u64,
}

impl BusConnection {
    /// Instant of the next synchronisation, ns.
    pub(super) fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Synchronises with the other boards if it is due.
    pub(super) fn synchronise(&mut self, chip: &mut dyn ActuatorChip, at: VirtualNanos) {
        if at.0 < self.next_ns {
            return;
        }
        // A frame that was detected late ends at the instant at which the next one may begin.
        chip.end_frame(at);
        let (station, since_ns) = chip.station(at.0);
        let station_state = StationState { station, since_ns };
        let outcome = self.wait(station_state);
        self.next_ns = outcome.next_ns;
        if let Some((times_ns, transfer)) = outcome.began {
            chip.begin_frame(at, times_ns, transfer, self.index);
        }
    }

    fn wait(&self, station_state: StationState) -> SyncOutcome {
        let mut state = self.bus.lock();
        state.boards[self.index] = Some(station_state);
        state.arrived += 1;
        let round = state.round;
        if state.is_complete() {
            state.synchronise_all();
            self.bus.0.1.notify_all();
        }
        while state.round == round {
            state = (self.bus.0.1.wait(state)).unwrap_or_else(PoisonError::into_inner);
        }
        state.outcome
    }
}

impl SharedBusState {
    fn is_complete(&self) -> bool {
        let present = self.present.iter().filter(|is_there| **is_there).count();
        present > 0 && self.arrived == present
    }
}

impl Drop for BusConnection {
    fn drop(&mut self) {
        let mut state = self.bus.lock();
        state.present[self.index] = false;
        state.boards[self.index] = None;
        if state.is_complete() {
            state.synchronise_all();
            self.bus.0.1.notify_all();
        }
    }
}
