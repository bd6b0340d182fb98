//! Runs the chip and the plant in lockstep.

use rigless::device::Level;
use rigless::emulator::{Driver, Host, Settled, Stop, Watch};
use rigless::session::Session;
use rigless::time::VirtualNanos;

use model_core::sensors::board_figures::TRIP_A;

use super::RunError;
use super::board_faults::{self, BoardFaults};
use super::firmware::Firmware;
use super::grid::{Grid, PWM_PERIOD_NS};
use super::options::Options;
use super::probe::Probes;
use super::servo::Servo;
use super::shared::BusConnection;
use super::view::{Flow, Script, View};
use crate::board::ActuatorBoard;
use crate::faults::Injector;
use crate::plant::{BoardPlant, Bridge, Slot};
use crate::trace::{Row, Trace};

/// Period of the stops while the timer has not started, ns: the first one after its start is in its
/// first PWM period.
const POLL_NS: u64 = if PWM_PERIOD_NS > 100_000 {
    100_000
} else {
    PWM_PERIOD_NS / 2
};

/// Supply voltage below which the regulator switches the chip off, and above which it switches it
/// on, V.
const BROWN_OUT_V: (f64, f64) = (3.6, 3.9);

/// The driver of a run.
#[derive(Debug)]
pub(super) struct Lockstep<S> {
    pub script: S,
    pub plant: BoardPlant,
    pub trace: Trace,
    pub probes: Probes,
    pub faults: Injector,
    pub servo: Servo,
    /// Virtual time, ns, and instructions at the last stop.
    pub last: (u64, u64),
    /// Active faults outside the plant.
    pub board_faults: BoardFaults,
    /// Entry addresses and names of the functions that start faults.
    entries: Vec<(u64, String)>,
    grid: Grid,
    /// Virtual time of the plant, ns.
    plant_ns: u64,
    until_ns: u64,
    next_poll_ns: u64,
    /// The script is polled at every stop.
    polls_at_stops: bool,
    is_watching: bool,
    is_core_stalled: bool,
    is_powered: bool,
    resets: usize,
    firmware: Firmware,
    row: Row,
    bus: Option<BusConnection>,
}

impl<S: Script> Lockstep<S> {
    pub fn try_new(
        firmware: &Firmware,
        options: Options,
        script: S,
        bus: Option<BusConnection>,
    ) -> Result<Self, RunError> {
        let plant = BoardPlant::try_new(&options.plant)?;
        let faults = Injector::new(options.faults);
        let mut entries = Vec::new();
        for name in faults.symbols() {
            entries.push((firmware.function(name)?.entry, name.to_owned()));
        }
        let sensed = plant.sensed();
        Ok(Self {
            script,
            trace: Trace::new(options.keeps_trace),
            probes: Probes::try_new(firmware, &options.probes)?,
            servo: Servo::new(options.servo_us),
            last: (0, 0),
            board_faults: BoardFaults::default(),
            entries,
            faults,
            grid: Grid::new(),
            plant_ns: 0,
            until_ns: options.until_ns,
            next_poll_ns: 1,
            polls_at_stops: options.polls_at_stops,
            is_watching: false,
            is_core_stalled: false,
            is_powered: true,
            bus,
            resets: 0,
            firmware: firmware.clone(),
            row: Row {
                at_ns: 0,
                instructions: 0,
                bridge: Bridge::Coast,
                sensed,
                angle_deg: 0.0,
                rate_deg_s: 0.0,
                current_a: 0.0,
                supply_v: 0.0,
            },
            plant,
        })
    }

    /// The next instant at which the run has to stop, ns.
    pub fn next_ns(&self, now_ns: u64) -> u64 {
        let bus_ns = self.bus.as_ref().map_or(u64::MAX, BusConnection::next_ns);
        self.own_next_ns().min(bus_ns).max(now_ns + 1)
    }

    /// The same without the bus.
    fn own_next_ns(&self) -> u64 {
        let grid_ns = self.grid.is_locked.then(|| self.grid.next().0);
        let others = [self.faults.next_ns(), self.servo.next_ns(), grid_ns];
        let next_ns = others.into_iter().flatten().min().unwrap_or(u64::MAX);
        next_ns.min(self.next_poll_ns).min(self.until_ns)
    }

    fn watch(&mut self, session: &mut Session<ActuatorBoard>) {
        let faults = self.entries.iter().map(|(address, _)| *address);
        for address in self.probes.addresses().chain(faults) {
            session.watch(Watch::Instruction(address));
        }
    }

    /// Applies everything that is due at this stop.
    fn process(
        &mut self,
        session: &mut Session<ActuatorBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Flow {
        self.detect_resets(session, stop.at, host);
        board_faults::apply_due(self, session, stop, host);
        if self.board_faults.feeds_watchdog {
            session.board_mut().chip.feed_watchdog(stop.at);
        }
        self.align_with_timer(session.board_mut(), stop.at);
        let mut flow = Flow::Continue;
        if self.next_poll_ns != u64::MAX && !self.grid.is_locked {
            self.update_supply(session.board_mut(), stop.at, host);
        }
        if self.next_poll_ns != u64::MAX || self.polls_at_stops {
            flow = self.run_script(session.board_mut(), stop, host, S::at_poll);
        }
        while self.grid.is_locked && self.grid.next().0 <= stop.at.0 {
            let (_, slot) = self.grid.next();
            if self.pass(slot, session.board_mut(), stop, host) == Flow::End {
                flow = Flow::End;
            }
            let timer = session.board_mut().chip.pwm_timer(stop.at);
            self.grid.pass(timer.current_instant());
        }
        if let Some(level) = self.servo.edge(stop.at.0) {
            session.board_mut().chip.drive_servo(stop.at, level);
        }
        flow
    }

    /// Detects resets. The timer restarts after a reset; its phase is unknown until then.
    fn detect_resets(
        &mut self,
        session: &Session<ActuatorBoard>,
        at: VirtualNanos,
        host: &mut dyn Host,
    ) {
        // The supply was cut during a flash operation.
        if session.unpowered() && self.is_powered {
            self.is_powered = false;
            board_faults::randomise_ram(session.board().chip.ram(), host, at.0);
        }
        let resets = session.resets().len();
        if resets != self.resets {
            self.resets = resets;
            self.probes.discard_open_calls();
        }
    }

    fn align_with_timer(&mut self, board: &mut ActuatorBoard, at: VirtualNanos) {
        let timer = board.chip.pwm_timer(at);
        let since_ns = timer.since_edge_ns();
        self.next_poll_ns = if self.grid.is_locked && since_ns.is_some() {
            u64::MAX
        } else {
            at.0 + POLL_NS
        };
        let Some(since_ns) = since_ns else {
            self.grid.lose();
            if self.plant_ns == 0 && !self.grid.is_locked {
                board.set_encoder(self.row.sensed.encoder);
                board.chip.set_sensor_inputs(&self.row.sensed);
            }
            return;
        };
        let edge_ns = at.0.saturating_sub(since_ns);
        let is_first = !self.grid.is_locked;
        if !self.grid.follow(edge_ns) {
            return;
        }
        self.grid.current = timer.current_instant();
        if is_first {
            // The shaft was at rest before the timer started.
            self.plant_ns = edge_ns;
        }
    }

    /// Ends a slot: the plant advances to its end, and the converter's inputs show the new samples.
    fn pass(
        &mut self,
        slot: Slot,
        board: &mut ActuatorBoard,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Flow {
        let bridge = if self.is_powered {
            board.chip.bridge()
        } else {
            Bridge::Coast
        };
        self.move_plant(slot, bridge);
        let sensed = self.plant.sensed();
        self.row.sensed = sensed;
        board.chip.set_sensor_inputs(&sensed);
        self.update_trip(board, stop.at);
        self.update_supply(board, stop.at, host);
        if slot != Slot::Edge {
            return Flow::Continue;
        }
        board.set_encoder(sensed.encoder);
        self.record_row(bridge, stop);
        self.run_script(board, stop, host, S::at_edge)
    }

    fn move_plant(&mut self, slot: Slot, bridge: Bridge) {
        let current = self.grid.current;
        let end_ns = self.grid.end_ns();
        let ahead_ns = end_ns.saturating_sub(self.plant_ns);
        if ahead_ns == slot.length_ns(current) {
            self.plant.advance(bridge, slot, current);
        } else {
            // The timer was restarted.
            self.plant.advance_by(bridge, ahead_ns as f64 * 1e-9);
        }
        self.plant_ns = self.plant_ns.max(end_ns);
    }

    /// The comparator at the bridge's ground return.
    fn update_trip(&mut self, board: &mut ActuatorBoard, at: VirtualNanos) {
        let trips = self.board_faults.trips || self.plant.return_peak_a() > TRIP_A;
        let level = Level::from(!trips);
        if level != board.chip.break_level() {
            board.chip.drive_break(at, level);
        }
    }

    /// The regulator, which switches the chip off when its input is too low.
    fn update_supply(&mut self, board: &mut ActuatorBoard, at: VirtualNanos, host: &mut dyn Host) {
        let supply_v = self.plant.supply_v();
        let limit_v = if self.is_powered {
            BROWN_OUT_V.0
        } else {
            BROWN_OUT_V.1
        };
        let is_powered = supply_v >= limit_v && !self.board_faults.has_lost_power;
        if is_powered != self.is_powered {
            self.is_powered = is_powered;
            board.chip.set_power(at, is_powered);
            if !is_powered {
                board_faults::randomise_ram(board.chip.ram(), host, at.0);
            }
        }
    }

    fn record_row(&mut self, bridge: Bridge, stop: Stop) {
        let reading = self.plant.reading();
        self.row = Row {
            at_ns: self.plant_ns,
            instructions: stop.instruction_count,
            bridge,
            sensed: self.row.sensed,
            angle_deg: reading.output.angle_deg,
            rate_deg_s: reading.output.rate_deg_s,
            current_a: self.plant.motor_current_a(),
            supply_v: self.plant.supply_v(),
        };
        self.trace.row(self.row);
    }

    fn run_script(
        &mut self,
        board: &mut ActuatorBoard,
        stop: Stop,
        host: &mut dyn Host,
        call: impl FnOnce(&mut S, &mut View<'_>) -> Flow,
    ) -> Flow {
        if let Some(wire) = board.chip.wire() {
            wire.take_log()
                .into_iter()
                .for_each(|sent| self.trace.frame(sent));
        }
        let mut view = View {
            row: &self.row,
            plant: &mut self.plant,
            now_ns: stop.at.0,
            board,
            memory: host,
            faults: &mut self.faults,
            servo: &mut self.servo,
            resets: self.resets,
        };
        call(&mut self.script, &mut view)
    }

    /// Stalls the core while the flash bank that it executes from is written, or while a fault is
    /// active that stalls it.
    fn stall_core(&mut self, session: &mut Session<ActuatorBoard>, host: &mut dyn Host) {
        let is_stalled = self.board_faults.stalls || session.board().chip.stalls_core();
        if is_stalled != self.is_core_stalled && !session.unpowered() {
            self.is_core_stalled = is_stalled;
            host.hold(is_stalled);
        }
    }

    /// Schedules a stop at the instant at which the core reaches this instruction count if it does
    /// not sleep; if it does, the next stop follows.
    fn pause_at_instruction(&self, session: &mut Session<ActuatorBoard>, now_ns: u64, count: u64) {
        if let Some(target) = self.faults.next_instruction() {
            let left = target.saturating_sub(count);
            let ns = left * 1_000_000_000 / session.board().chip.core_hz();
            session.pause_at(Some(VirtualNanos(now_ns + ns.max(1))));
        }
    }

    pub(super) fn firmware(&self) -> &Firmware {
        &self.firmware
    }
}

impl<S: Script> Driver<ActuatorBoard> for Lockstep<S> {
    fn on_settled(
        &mut self,
        session: &mut Session<ActuatorBoard>,
        host: &mut dyn Host,
        settled: Settled,
    ) {
        match settled {
            Settled::Hit(hit) => {
                self.probes
                    .on_address(hit.address, hit.at.0, hit.instruction_count);
                if self
                    .entries
                    .iter()
                    .any(|(address, _)| *address == hit.address)
                {
                    let entered = self.entries.iter().filter(|(at, _)| *at == hit.address);
                    entered.for_each(|(_, name)| self.faults.count_entry(name));
                    let (at, count) = (hit.at, hit.instruction_count);
                    board_faults::apply_due_at(self, session, at, count, host);
                }
            }
            Settled::Stop(stop) if self.faults.next_instruction().is_some() => {
                board_faults::apply_due(self, session, stop, host);
                self.pause_at_instruction(session, stop.at.0, stop.instruction_count);
            }
            _ => {}
        }
        self.stall_core(session, host);
    }

    fn on_stop(
        &mut self,
        session: &mut Session<ActuatorBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if !self.is_watching {
            self.is_watching = true;
            self.watch(session);
        }
        self.last = (stop.at.0, stop.instruction_count);
        let has_acted = self.own_next_ns() <= stop.at.0;
        let flow = self.process(session, stop, host);
        self.stall_core(session, host);
        let own_next_ns = self.own_next_ns();
        if let Some(bus) = &mut self.bus {
            let sleep = session.board().sleep.clone();
            let has_acted = has_acted || self.polls_at_stops;
            let has_acted = has_acted || self.faults.next_instruction().is_some();
            let quiet_until_ns = sleep.quiet_until_ns(session.mcu(), has_acted, own_next_ns);
            bus.synchronise(session.board_mut().chip.as_mut(), stop.at, quiet_until_ns);
        }
        if flow == Flow::End || stop.at.0 >= self.until_ns {
            return None;
        }
        Some(VirtualNanos(self.next_ns(stop.at.0)))
    }
}
