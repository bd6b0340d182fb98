//! Tasks of the actuator board, and the events that start them.
//!
//! - Priority 5: a received frame goes into the queue of the CANopen device.
//! - Priority 4, each PWM edge: outputs; in the first PWM period it starts the encoder, in the last
//!   one it enables the sampling instants.
//! - Priority 4, sampling instants in the last PWM period: start of the samples of current,
//!   back-EMF, supply and temperature; switches to coasting.
//! - Priority 4, encoder read, 38 us after the edge: control step.
//! - Priority 4, first PWM edge while the encoder is read, and after the control step: checks that
//!   the memory of the CANopen device and the queues have not changed; seals the device.
//! - Priority 4, edges of two PWM periods in between: call of the CANopen device with received
//!   frames, timers, and frames to transmit; acceptance filter of the controller.
//! - Priority 2, mailbox free, bus error, and each call: frames to the controller; its state and
//!   bit rate.
//! - Priority 1, after the control step: flash and log.
//!
//! Only the reception of a frame preempts the control step, for a microsecond, and no task of lower
//! priority locks it out. The calls of the device have its priority, so that both use the device
//! without a lock; a call ends long before the next control step, and before the last PWM period
//! with its sampling instants. All other tasks communicate by queues and atomics without locks.

/// The tasks, at the interrupts of a chip. It is a macro since RTIC reads the names of the
/// interrupts before the compiler knows them.
macro_rules! actuator_program {
    (
        edge: $edge:ident,
        instant: $instant:ident,
        encoder_read: $encoder_read:ident,
        frame_received: $frame_received:ident,
        mailbox_free: $mailbox_free:ident,
        bus_status: $bus_status:ident,
        software: [$seal:ident, $call:ident, $background:ident $(,)?] $(,)?
    ) => {
        /// Tasks and their resources.
        #[allow(
            missing_docs,
            unsafe_op_in_unsafe_fn,
            reason = "RTIC generates public items that cannot be documented, and unsafe functions"
        )]
        #[rtic::app(device = crate::chip::pac, peripherals = true)]
        mod app {
            use core::mem::MaybeUninit;

            use drivers::{
                bridge::Bridge as _,
                can::{self, AcceptedIds, CanController},
            };
            use firmware::{
                application::Start,
                drive::{Device, StoredParameters},
                faults::Fault,
                store::{self, Origin},
                supervisor::{ResetCause, Task},
                timing::CALL_PERIODS,
            };
            use task_queues::Producer;

            use crate::{
                actuator::{
                    background::{Background, StateLog},
                    bus_status,
                    canopen_task::{CAPTURE_WORDS, CanopenTask, gather},
                    parameter_store::ParameterStore,
                    program_check,
                    pwm_timer::Instant,
                    queues::{ControllerEnds, ReceivedFrames, ends},
                    sealed::Sealed,
                    servo_pulse::ServoPulse,
                    shutdown,
                    timebase::PeriodCounter,
                    timing::PWM_PERIODS,
                    watchdog_supervisor::{WatchdogSupervisor, report_alive},
                },
                chip::pac::Interrupt,
                peripherals::{
                    ActuatorBridge, Can, Encoder,
                    analog::Analog,
                    updater::Updater,
                    wiring::{Peripherals, serial_number},
                },
            };

            #[shared]
            struct Shared {
                #[lock_free]
                bridge: ActuatorBridge,
                #[lock_free]
                analog: Analog,
                #[lock_free]
                encoder: Encoder,
                #[lock_free]
                period_counter: PeriodCounter,
                #[lock_free]
                canopen_task: CanopenTask,
                #[lock_free]
                can: CanController<Can, ControllerEnds>,
            }

            #[local]
            struct Local {
                servo_pulse: ServoPulse,
                can_receiver: Can,
                received: Producer<ReceivedFrames>,
                background: Background,
            }

            #[init(local = [
                        set_to_save: MaybeUninit<StoredParameters> = MaybeUninit::uninit(),
                        device: MaybeUninit<Device<'static>> = MaybeUninit::uninit(),
                        copy_of_device: MaybeUninit<Device<'static>> = MaybeUninit::uninit(),
                        capture_buffer: [i32; CAPTURE_WORDS] = [0; CAPTURE_WORDS],
                    ])]
            fn init(cx: init::Context) -> (Shared, Local) {
                let mut peripherals = Peripherals::new(cx.device);
                // SAFETY: the only call, as this task runs once.
                let ends = unsafe { ends() };

                let (program_check, is_as_built) = program_check::start(peripherals.crc_unit);
                let loaded = store::load::<StoredParameters>(&peripherals.flash);
                defmt::info!(
                    "reset cause {}, parameters from {}, option bytes {:x}",
                    peripherals.reset_cause as u8,
                    loaded.origin as u8,
                    peripherals.flash.option_bytes()
                );
                // First of all, as what follows may fail if the flash is corrupt.
                let mut watchdog =
                    WatchdogSupervisor::start(peripherals.watchdogs, cx.core.DCB, cx.core.DWT);
                let braking = loaded.parameters.board.braking_faults();
                if !is_as_built && braking.contains(Fault::ProgramCorrupt) {
                    shutdown::brake_before_the_tasks(&mut peripherals.bridge, &mut watchdog);
                }
                let start = Start {
                    watchdog: peripherals.reset_cause == ResetCause::Watchdog,
                    parameters_corrupt: loaded.origin == Origin::DefaultsInsteadOfCorrupt,
                    data_corrupt: peripherals.was_shut_down && is_as_built,
                    program_corrupt: !is_as_built,
                };
                let device = Device::new(loaded.parameters, start, cx.local.capture_buffer, 0);
                let device = cx.local.device.write(device);
                device.drive.diagnostics.reset_cause = peripherals.reset_cause;
                device.drive.diagnostics.serial_number = serial_number();
                let bus = &loaded.parameters.board.bus;
                let (updater, slots) = Updater::new(&peripherals.flash, bus);
                if let Some(slots) = slots {
                    device.drive.set_slots(slots);
                }

                let initial_ids = AcceptedIds::new(device.node().identifiers());
                let kbit_s = device.drive.application().parameters().bus.bit_rate_kbit_s as u16;
                let (can, can_receiver, acceptance) = Can::new(peripherals.can, &initial_ids);
                let can = CanController::new(can, kbit_s, ends.controller);
                peripherals.period_counter.start();
                peripherals.bridge.timer().start();
                let shared = Shared {
                    bridge: peripherals.bridge,
                    analog: peripherals.analog,
                    encoder: peripherals.encoder,
                    period_counter: peripherals.period_counter,
                    canopen_task: CanopenTask::new(
                        Sealed::new(device, cx.local.copy_of_device),
                        watchdog,
                        ends.device,
                        cx.local.set_to_save.write(loaded.parameters),
                        acceptance,
                    ),
                    can,
                };
                let local = Local {
                    servo_pulse: peripherals.servo_pulse,
                    can_receiver,
                    received: ends.receiver,
                    background: Background {
                        queues: ends.background,
                        flash: peripherals.flash,
                        store: ParameterStore::new(&loaded),
                        updater,
                        log: StateLog::default(),
                        program_check,
                    },
                };
                (shared, local)
            }

            #[idle]
            fn idle(_: idle::Context) -> ! {
                loop {
                    cortex_m::asm::wfi();
                }
            }

            #[task(binds = $edge, priority = 4, shared = [bridge, encoder, period_counter])]
            fn pwm_edge(cx: pwm_edge::Context) {
                let bridge = cx.shared.bridge;
                let period = cx.shared.period_counter.index();
                if period == 0 {
                    cx.shared.encoder.start();
                    bridge.begin_control_period();
                    rtic::pend(Interrupt::$seal);
                }
                bridge.timer().acknowledge_edge();
                bridge.begin_pwm_period();
                if CALL_PERIODS.contains(&period) {
                    rtic::pend(Interrupt::$call);
                }
                if period == PWM_PERIODS - 1 {
                    bridge.timer().enable_sampling_instants();
                }
            }

            #[task(binds = $instant, priority = 4, shared = [bridge, analog])]
            fn sampling_instant(cx: sampling_instant::Context) {
                match cx.shared.bridge.timer().take_instant() {
                    Some(Instant::Current) => cx.shared.analog.sample_current(),
                    Some(Instant::BackEmf) => cx.shared.analog.start_scan(),
                    Some(Instant::WindowStart) | None => {}
                }
            }

            #[task(
                        binds = $encoder_read,
                        priority = 4,
                        local = [servo_pulse],
                        shared = [bridge, analog, encoder, period_counter, canopen_task],
                    )]
            fn control_step(cx: control_step::Context) {
                let (task, bridge) = (cx.shared.canopen_task, cx.shared.bridge);
                let mut samples = gather(
                    cx.shared.encoder,
                    cx.shared.analog,
                    cx.local.servo_pulse,
                    bridge,
                );
                let period = cx.shared.period_counter.control_period();
                let outputs = task.begin_step(&mut samples, period, bridge.is_on());
                let command = outputs.as_ref().map(|outputs| outputs.bridge);
                bridge.command(command.unwrap_or_else(|| task.shut_down()));
                task.end_step(samples, outputs, bridge.timer().is_late());
                rtic::pend(Interrupt::$seal);
                rtic::pend(Interrupt::$background);
            }

            #[task(binds = $seal, priority = 4, shared = [bridge, canopen_task])]
            fn seal(cx: seal::Context) {
                let is_driven = cx.shared.bridge.is_on();
                cx.shared.canopen_task.maintain_seal(is_driven);
            }

            #[task(binds = $call, priority = 4, shared = [bridge, period_counter, canopen_task])]
            fn canopen_call(cx: canopen_call::Context) {
                let period = cx.shared.period_counter.period();
                let is_driven = cx.shared.bridge.is_on();
                if cx.shared.canopen_task.communicate(period, is_driven) {
                    rtic::pend(Interrupt::$mailbox_free);
                }
                rtic::pend(Interrupt::$bus_status);
            }

            // The highest priority, and short: the FIFO holds three frames, and a call of the
            // device can take longer than three frames.
            #[task(binds = $frame_received, priority = 5, local = [can_receiver, received])]
            fn frame_received(cx: frame_received::Context) {
                loop {
                    let is_lost = match can::receive_checked(cx.local.can_receiver) {
                        Ok(frame) => cx.local.received.enqueue(frame).is_err(),
                        Err(nb::Error::Other(can::Overrun)) => true,
                        Err(nb::Error::WouldBlock) => return,
                    };
                    if is_lost {
                        bus_status::count_lost_frame();
                    }
                }
            }

            #[task(binds = $mailbox_free, priority = 2, shared = [can])]
            fn mailbox_free(cx: mailbox_free::Context) {
                let can = cx.shared.can;
                bus_status::count_transmitted(can.take_transmitted());
                if bus_status::take_discard_request() {
                    bus_status::count_discarded(can.discard_process_data());
                }
                can.fill_mailboxes();
            }

            // Requested by the controller when its state changes, and by each call of the device.
            #[task(binds = $bus_status, priority = 2, shared = [can])]
            fn bus_status_changed(cx: bus_status_changed::Context) {
                let can = cx.shared.can;
                bus_status::record_state(can.take_state());
                if can.update(bus_status::period()) {
                    bus_status::count_bus_off();
                    bus_status::count_discarded(can.discard_process_data());
                }
                if let Some(kbit_s) = bus_status::take_requested_bit_rate() {
                    // Queued frames must not be transmitted with the new bit rate while the network
                    // switches.
                    can.set_bit_rate(kbit_s, bus_status::period());
                }
                report_alive(Task::Bus);
            }

            #[task(binds = $background, priority = 1, local = [background])]
            fn background(cx: background::Context) {
                cx.local.background.run();
            }
        }
    };
}
