//! The CANopen device on the board: its control step, and its calls for the bus.
//!
//! [`gather`], [`device_control`] and the functions for received frames are not inlined and have
//! fixed symbols, so that the emulator counts their instructions and a debugger shows them.

mod exchange;
mod reception;

use canopen::NodeId;
use cortex_m::peripheral::DWT;
use drivers::bridge::Bridge as _;
use firmware::{
    application::{Bridge as Command, Outputs, Samples},
    drive::{Device, StoredParameters},
    faults::{Fault, FaultSet},
    shutdown::Shutdown,
};

use self::reception::{communicate, is_process_data, receive_twice};
use super::{
    background::StepReport,
    bus_status,
    part_seals::PartSeals,
    program_check,
    queues::DeviceEnds,
    sealed::{Restored, Sealed},
    servo_pulse::ServoPulse,
    shutdown,
    timing::PWM_PERIOD_US,
    watchdog_supervisor::WatchdogSupervisor,
};
use crate::peripherals::{Acceptance, ActuatorBridge, Can, Encoder, analog::Analog};

/// Length of the capture buffer, words: 20 s of eight signals at 250 Hz. An image that is
/// downloaded lies there until it is staged.
pub const CAPTURE_WORDS: usize = 40 * 1024;

/// What a control step was given, and what it has computed.
struct LastStep {
    samples: Samples,
    is_late: bool,
    starved_periods: u32,
    outputs: Outputs,
}

/// Node, drive, and their connections to the other tasks.
pub struct CanopenTask {
    /// Sealed between two uses.
    device: Sealed<Device<'static>>,
    /// Seals of parts of the device, compared and renewed before and after each control step and in
    /// each call.
    part_seals: PartSeals,
    /// Whether the motor was driven before the last control step.
    was_driven: bool,
    /// The last control step, until it has been computed a second time.
    last_step: Option<LastStep>,
    /// After corrupt data or a corrupt program: the device is used no more.
    shutdown: Shutdown,
    /// Node-ID of the last call; 0 for none.
    node_id: u8,
    /// The faults after which the motor brakes, of the last call.
    braking_faults: FaultSet,
    watchdog: WatchdogSupervisor,
    queues: DeviceEnds,
    /// Memory for the set of the next save; none while a save runs.
    set_to_save: Option<&'static mut StoredParameters>,
    /// The filter of the frames that the controller receives.
    acceptance: Acceptance,
    /// Number of the PWM period of the last call, and its time, us.
    last_call: (u32, u64),
    /// Calls in which process data has waited without a frame leaving the board, and the number of
    /// frames that had left it before.
    waited: (usize, u32),
    /// Discarded frames that the device knows of.
    discarded: u32,
}

/// Reads the values sampled since the last control step.
#[unsafe(no_mangle)]
#[inline(never)]
pub fn gather(
    encoder: &mut Encoder,
    analog: &mut Analog,
    pulse: &mut ServoPulse,
    bridge: &mut ActuatorBridge,
) -> Samples {
    let (current, scan) = analog.take();
    Samples {
        encoder: encoder.finish(),
        current,
        scan,
        servo_pulse_us: pulse.take_us(),
        bridge_tripped: bridge.take_trip(),
        missed_periods: 0,
        bus: bus_status::take_worst_state(),
    }
}

/// The control step of the drive.
#[unsafe(no_mangle)]
#[inline(never)]
fn device_control(device: &mut Device<'static>, samples: &Samples) -> Outputs {
    device.control(samples)
}

/// Tells the drive how its control step met its time.
fn apply_timing(device: &mut Device<'static>, is_late: bool, starved_periods: u32) {
    let drive = &mut device.drive;
    if is_late {
        drive.was_late();
    }
    drive.diagnostics.starved_periods = starved_periods;
}

/// The faults after which the motor brakes, by the parameters in force.
fn braking_faults(device: &Device<'static>) -> FaultSet {
    device.drive.application().parameters().braking_faults()
}

impl CanopenTask {
    /// The task of a device, with the filter of its frames.
    pub fn new(
        mut device: Sealed<Device<'static>>,
        watchdog: WatchdogSupervisor,
        queues: DeviceEnds,
        set_to_save: &'static mut StoredParameters,
        acceptance: Acceptance,
    ) -> Self {
        Self {
            part_seals: PartSeals::new(device.get()),
            braking_faults: braking_faults(device.get()),
            device,
            was_driven: false,
            last_step: None,
            shutdown: Shutdown::default(),
            node_id: 0,
            watchdog,
            queues,
            set_to_save: Some(set_to_save),
            acceptance,
            last_call: (0, 0),
            waited: (0, 0),
            discarded: 0,
        }
    }

    /// After a control step computes it a second time and seals the device; before the next one,
    /// while the encoder is read, checks the queues and the device with its parts, and copies the
    /// device.
    pub fn maintain_seal(&mut self, is_driven: bool) {
        match self.last_step.take() {
            Some(step) => {
                if !self.repeat(&step) {
                    // A wrong result may have switched the bridge off.
                    self.begin_shutdown(Fault::DataCorrupt, is_driven || self.was_driven);
                }
                self.device.seal();
            }
            // The device is used no more.
            None if self.shutdown.has_begun() => {}
            None => {
                let is_intact = self.device.unseal_and_copy()
                    && self.part_seals.renew(self.device.get())
                    && self.queues.are_intact();
                self.check(is_intact, is_driven);
            }
        }
    }

    /// Computes a control step again, from the state before it; returns whether the result is the
    /// same, and what it has only read is as before. A register that changes during one
    /// of both computations, or an instruction that is not executed, makes another one.
    fn repeat(&mut self, step: &LastStep) -> bool {
        let state = self.device.get().drive.step_state();
        match self.device.restore() {
            Restored::Intact => {}
            Restored::Corrupt => return false,
            Restored::Absent => return self.part_seals.renew(self.device.get()),
        }
        let device = self.device.get();
        let outputs = device_control(device, &step.samples);
        apply_timing(device, step.is_late, step.starved_periods);
        // Before the comparison, which notices what changes until here; the seals notice the rest.
        let is_intact = self.part_seals.renew(device);
        let is_same = (outputs, device.drive.step_state()) == (step.outputs, state);
        is_same
            && is_intact
            && (self.device).is_as_copied(|device| device.drive.application().parameters())
            && (self.device).is_as_copied(|device| device.drive.axis_parameters())
    }

    /// Begins the shutdown unless the data and the program are as they were.
    fn check(&mut self, is_intact: bool, is_driven: bool) {
        if !is_intact {
            self.begin_shutdown(Fault::DataCorrupt, is_driven);
        } else if program_check::is_corrupt() {
            self.begin_shutdown(Fault::ProgramCorrupt, is_driven);
        }
    }

    /// The motor brakes if it was driven, unless the parameters exclude it.
    #[inline(never)]
    fn begin_shutdown(&mut self, fault: Fault, is_driven: bool) {
        let brakes = is_driven && self.braking_faults.contains(fault);
        self.shutdown.begin(fault, brakes);
    }

    /// Starts the control step of the period of this number; returns the drive's decision, unless
    /// the device is corrupt.
    pub fn begin_step(
        &mut self,
        samples: &mut Samples,
        control_period: u32,
        is_driven: bool,
    ) -> Option<Outputs> {
        self.was_driven = is_driven;
        samples.missed_periods = self.watchdog.begin_step(control_period);
        let is_intact = self.device.unseal();
        self.check(is_intact, is_driven);
        if self.shutdown.has_begun() {
            return None;
        }
        Some(device_control(self.device.get(), samples))
    }

    /// The command to the bridge without a decision of the drive.
    pub fn shut_down(&mut self) -> Command {
        self.shutdown.step().unwrap_or_else(|| shutdown::restart())
    }

    /// Ends the control step with these samples, after its decision is set at the bridge.
    pub fn end_step(&mut self, samples: Samples, outputs: Option<Outputs>, is_late: bool) {
        let starved_periods = self.watchdog.end_step(is_late);
        let Some(outputs) = outputs else { return };
        apply_timing(self.device.get(), is_late, starved_periods);
        // The queue is full only if the background task is late: the log then has a gap.
        let _ = self.queues.reports.enqueue(StepReport::new(&outputs));
        self.last_step = Some(LastStep {
            samples,
            is_late,
            starved_periods,
            outputs,
        });
    }

    /// A call of the CANopen device, in the PWM period of this number. Returns whether there are
    /// frames to transmit.
    pub fn communicate(&mut self, period: u32, is_driven: bool) -> bool {
        let next = self.queues.received.peek();
        let has_process_data = next.is_some_and(|next| is_process_data(&next.unchecked::<Can>()));
        let is_intact = if has_process_data {
            self.device.unseal_and_copy()
        } else {
            self.device.unseal()
        };
        self.check(is_intact, is_driven);
        let now_us = self.time_us(period);
        let start = has_process_data.then(DWT::cycle_count);
        if has_process_data && !self.shutdown.has_begun() && !receive_twice(self, now_us) {
            self.begin_shutdown(Fault::DataCorrupt, is_driven);
        }
        // What the call does must not be undone.
        self.device.discard_copy();
        if self.shutdown.has_begun() {
            if let Some(frame) = self.shutdown.take_frame(self.node_id) {
                match self.queues.to_transmit.enqueue(frame) {
                    // Before everything that waits.
                    Ok(()) => bus_status::request_discard(),
                    // The queue is full, or not intact.
                    Err(frame) => _ = self.queues.process_data.enqueue(frame),
                }
            }
            return true;
        }
        bus_status::set_period(period);
        self.update_diagnostics();
        self.discard_stale();
        communicate(self, now_us, start);
        // Before anything of the device is stored.
        if self.part_seals.renew(self.device.get()) {
            self.exchange_with_store();
            self.exchange_with_updater();
            self.update_controller();
            let node_id = self.device.get().node().node_id();
            self.node_id = node_id.map_or(0, NodeId::get);
            self.braking_faults = braking_faults(self.device.get());
        } else {
            self.begin_shutdown(Fault::DataCorrupt, is_driven);
        }
        self.device.seal();
        self.queues.to_transmit.has_waiting() || self.queues.process_data.has_waiting()
    }

    /// Time of a PWM period from its number, which has 31 bits and wraps.
    fn time_us(&mut self, period: u32) -> u64 {
        let (last_period, last_us) = self.last_call;
        let elapsed = period.wrapping_sub(last_period) & (u32::MAX >> 1);
        let now_us = last_us.wrapping_add(u64::from(elapsed) * u64::from(PWM_PERIOD_US));
        self.last_call = (period, now_us);
        now_us
    }
}
