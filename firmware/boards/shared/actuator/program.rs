//! Tasks of the actuator board, and the events that start them.
//!
//! | priority | task | event | does |
//! |---|---|---|---|
//! | 4 | `pwm_edge` | each update of the PWM | outputs; starts the encoder and the samplings |
//! | 4 | `sampling_instant` | instants in the last update period | samples; coasting |
//! | 4 | `control_step` | encoder read, 38 us after the first edge | first copy of the control loop, whose outputs act at the next edge |
//! | 4 | `comparison` | after the control step | second copy, comparison, telemetry |
//! | 3 | `frame_received` | received frame | puts it into the queue of the communication |
//! | 3 | `line_event` | pause of the servo bus, or end of the answer | carries out the instructions of the master |
//! | 3 | `line_timer` | return delay | transmits the answer |
//! | 2 | `communication_cycle` | edges of two update periods in between | CANopen node and drive |
//! | 2 | `mailbox_free` | mailbox free, and each communication cycle | frames to the controller |
//! | 2 | `bus_status_changed` | bus error, and each communication cycle | state and bit rate of the controller |
//! | 1 | `background` | after the comparison | flash and log |
//!
//! Nothing delays the tasks of the loop, which have the highest priority: the other ones lock them
//! out for the exchange of two references ([`super::mailboxes`]) and communicate by queues and
//! atomics otherwise.
//!
//! `actuator_program!` is the only list of the handlers. The program contains it as text in the
//! section `.handlers`, which is not loaded: interrupt, task, priority, and runs in a control
//! period (0 for those that depend on the bus).

/// The list of the handlers, as text in the program.
macro_rules! handlers {
    ($($interrupt:ident, $task:ident, $priority:literal, $runs:literal;)+) => {
        /// One line for each handler: interrupt, task, priority, runs in a control period; `#` is
        /// the number of update periods, and `@` the most sampling instants.
        const LIST: &str = concat!(
            $(stringify!($interrupt), ",", stringify!($task), ",", $priority, ",", $runs, "\n"),+
        );

        #[used]
        #[unsafe(link_section = ".handlers")]
        static HANDLERS: [u8; LIST.len()] = {
            let mut bytes = [0; LIST.len()];
            let mut at = 0;
            while at < bytes.len() {
                bytes[at] = match LIST.as_bytes()[at] {
                    // One digit.
                    b'#' => b'0' + (crate::actuator::timing::UPDATE_PERIODS % 10) as u8,
                    b'@' => b'0' + (crate::actuator::pwm_timer::MOST_INSTANTS % 10) as u8,
                    byte => byte,
                };
                at += 1;
            }
            bytes
        };
    };
}

/// The tasks, at the interrupts of a chip. It is a macro since RTIC reads the names of the
/// interrupts before the compiler has read them.
macro_rules! actuator_program {
    (
        edge: $edge:ident,
        instant: $instant:ident,
        encoder_read: $encoder_read:ident,
        frame_received: $frame_received:ident,
        mailbox_free: $mailbox_free:ident,
        bus_status: $bus_status:ident,
        software: [$comparison:ident, $cycle:ident, $background:ident $(,)?] $(,)?
    ) => {
        handlers! {
            $edge, pwm_edge, 4, "#";
            $instant, sampling_instant, 4, "@";
            $encoder_read, control_step, 4, 1;
            $comparison, comparison, 4, 1;
            $frame_received, frame_received, 3, 0;
            USART1, line_event, 3, 0;
            TIM5, line_timer, 3, 0;
            $cycle, communication_cycle, 2, 2;
            $mailbox_free, mailbox_free, 2, 0;
            $bus_status, bus_status_changed, 2, 2;
            $background, background, 1, 1;
        }

        /// Tasks and their resources.
        #[allow(
            missing_docs,
            unsafe_op_in_unsafe_fn,
            reason = "RTIC generates public items that cannot be documented, and unsafe functions"
        )]
        #[rtic::app(device = crate::chip::pac, peripherals = true)]
        mod app {
            use core::mem::MaybeUninit;

            use drivers::can::{self, AcceptedIds, CanController};
            use firmware::{
                application::{Outputs, Start},
                check_value::Checked,
                drive::{Device, Messages, ServoBus, StoredParameters},
                faults::Fault,
                store::{self, Origin},
                supervisor::{ResetCause, Task},
                timing::COMMUNICATION_PERIODS,
            };

            use crate::{
                actuator::{
                    background::{Background, StateLog, StepReport},
                    bus_status,
                    comm_task::{CAPTURE_WORDS, CommTask},
                    loop_memory::LoopMemory,
                    loop_task::LoopTask,
                    mailboxes::{Mailboxes, Poster, Reader, Telemetry},
                    parameter_store::ParameterStore,
                    program_check,
                    pwm_timer::Instant,
                    queues::{ControllerEnds, Queues, ReceivedFrames, StepReports},
                    sampling::Sampling,
                    servo_bus_task,
                    shutdown,
                    timebase::PeriodCounter,
                    timing::{UPDATE_PERIODS, has_window},
                    watchdog_supervisor::{WatchdogSupervisor, report_alive},
                },
                chip::pac::Interrupt,
                peripherals::{
                    ActuatorBridge, Can,
                    servo_line::ServoLine,
                    updater::Updater,
                    wiring::{Peripherals, serial_number},
                },
            };

            #[shared]
            struct Shared {
                #[lock_free]
                bridge: ActuatorBridge,
                #[lock_free]
                sampling: Sampling,
                #[lock_free]
                period_counter: PeriodCounter,
                #[lock_free]
                loop_memory: LoopMemory,
                mailboxes: Mailboxes,
                telemetry: Telemetry,
                servo_bus: Option<&'static mut ServoBus>,
                #[lock_free]
                servo_line: ServoLine,
                #[lock_free]
                can: CanController<Can, ControllerEnds>,
            }

            #[local]
            struct Local {
                reports: StepReports,
                can_receiver: Can,
                received: ReceivedFrames,
                comm_task: CommTask,
                background: Background,
            }

            #[init(local = [
                        queues: Queues = Queues::new(),
                        #[unsafe(link_section = ".core_memory.set_to_save")]
                        set_to_save: MaybeUninit<StoredParameters> = MaybeUninit::uninit(),
                        #[unsafe(link_section = ".core_memory.device")]
                        device: MaybeUninit<Device<'static>> = MaybeUninit::uninit(),
                        #[unsafe(link_section = ".core_memory.servo_bus")]
                        servo_bus: MaybeUninit<ServoBus> = MaybeUninit::uninit(),
                        #[unsafe(link_section = ".core_memory.messages")]
                        messages: [MaybeUninit<Messages>; 2] = [const { MaybeUninit::uninit() }; 2],
                        outputs: [MaybeUninit<Checked<Outputs>>; 2] =
                            [const { MaybeUninit::uninit() }; 2],
                        capture_buffer: [i32; CAPTURE_WORDS] = [0; CAPTURE_WORDS],
                    ])]
            fn init(cx: init::Context) -> (Shared, Local) {
                let mut peripherals = Peripherals::new(cx.device);
                let ends = cx.local.queues.split();

                let (program_check, is_as_built) = program_check::start(peripherals.crc_unit);
                let loaded = store::load::<StoredParameters>(&peripherals.flash);
                defmt::info!(
                    "reset cause {}, parameters from {}, option bytes {:x}",
                    peripherals.reset_cause as u8,
                    loaded.origin as u8,
                    peripherals.flash.option_bytes()
                );
                peripherals.flash.check_option_bytes();
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
                let device = Device::new(loaded.parameters, cx.local.capture_buffer, 0);
                let device = cx.local.device.write(device);
                device.drive.diagnostics.reset_cause = peripherals.reset_cause;
                device.drive.diagnostics.serial_number = serial_number();
                let bus = &loaded.parameters.board.bus;
                let (updater, slots) = Updater::new(&peripherals.flash, bus);
                if let Some(slots) = slots {
                    device.drive.set_slots(slots);
                }

                let initial_ids = AcceptedIds::of(device);
                let (can, can_receiver, acceptance) = Can::new(peripherals.can, &initial_ids);
                let can = CanController::new(can, bus.bit_rate_kbit_s as u16, ends.controller);
                let messages = &device.drive.messages;
                let task = || LoopTask::new(messages.start(start), watchdog);
                let loop_memory = LoopMemory::new(cx.core.MPU, task);
                let [posted, spare] = cx.local.messages;
                let mailboxes = Mailboxes::new(posted.write(messages.clone()));
                let poster = Poster::new(spare.write(messages.clone()));
                let outputs = Checked::new(Outputs::default());
                let [published, read] = cx.local.outputs;
                let telemetry = Telemetry::new(published.write(outputs));
                let reader = Reader::new(read.write(outputs));
                let servo_bus = ServoBus::new_in(cx.local.servo_bus, &loaded.parameters);
                if let Some(bus) = &servo_bus {
                    peripherals.servo_line.start(bus.bit_rate());
                }
                peripherals.period_counter.start();
                peripherals.bridge.timer().start();
                let shared = Shared {
                    bridge: peripherals.bridge,
                    sampling: Sampling::new(
                        peripherals.encoder,
                        peripherals.analog,
                        peripherals.servo_pulse,
                    ),
                    period_counter: peripherals.period_counter,
                    loop_memory,
                    mailboxes,
                    telemetry,
                    servo_bus,
                    servo_line: peripherals.servo_line,
                    can,
                };
                let local = Local {
                    reports: ends.reporter,
                    can_receiver,
                    received: ends.receiver,
                    comm_task: CommTask::new(
                        device,
                        (poster, reader),
                        ends.comm,
                        cx.local.set_to_save.write(loaded.parameters),
                        (acceptance, initial_ids),
                    ),
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

            #[task(binds = $edge, priority = 4, shared = [bridge, sampling, period_counter])]
            fn pwm_edge(cx: pwm_edge::Context) {
                let bridge = cx.shared.bridge;
                let index = cx.shared.period_counter.index();
                if index == 0 {
                    cx.shared.sampling.encoder.start();
                    bridge.begin_control_period();
                }
                bridge.timer().acknowledge_edge();
                bridge.begin_pwm_period();
                if COMMUNICATION_PERIODS.contains(&index) {
                    bus_status::set_period(cx.shared.period_counter.period());
                    rtic::pend(Interrupt::$cycle);
                }
                if index == UPDATE_PERIODS - 1 {
                    let control_period = cx.shared.period_counter.control_period();
                    bridge.timer().enable_sampling_instants(has_window(control_period));
                }
            }

            #[task(binds = $instant, priority = 4, shared = [bridge, sampling])]
            fn sampling_instant(cx: sampling_instant::Context) {
                let analog = &mut cx.shared.sampling.analog;
                match cx.shared.bridge.timer().take_instant() {
                    Some(Instant::Current) => analog.sample_current(),
                    Some(Instant::BackEmf) => analog.start_scan(),
                    Some(Instant::WindowStart) | None => {}
                }
            }

            #[task(
                        binds = $encoder_read,
                        priority = 4,
                        shared = [bridge, sampling, period_counter, loop_memory, mailboxes],
                    )]
            fn control_step(cx: control_step::Context) {
                let (sampling, bridge) = (cx.shared.sampling, cx.shared.bridge);
                let control_period = cx.shared.period_counter.control_period();
                let mut mailboxes = cx.shared.mailboxes;
                cx.shared.loop_memory.with(|task| {
                    let missed_periods = task.begin(control_period);
                    let had_window = (1..=1 + u32::from(missed_periods))
                        .any(|before| has_window(control_period.wrapping_sub(before)));
                    sampling.finish_sampling(bridge, missed_periods, had_window);
                    let samples = sampling.read();
                    mailboxes.lock(|mailboxes| task.step(&samples, mailboxes, bridge));
                });
                rtic::pend(Interrupt::$comparison);
            }

            #[task(
                        binds = $comparison,
                        priority = 4,
                        local = [reports],
                        shared = [bridge, sampling, loop_memory, mailboxes, telemetry],
                    )]
            fn comparison(cx: comparison::Context) {
                let (sampling, bridge) = (cx.shared.sampling, cx.shared.bridge);
                let (mut mailboxes, mut telemetry) = (cx.shared.mailboxes, cx.shared.telemetry);
                cx.shared.loop_memory.with(|task| {
                    let samples = sampling.read();
                    let outputs =
                        mailboxes.lock(|mailboxes| task.repeat(&samples, mailboxes, bridge));
                    telemetry.lock(|telemetry| telemetry.publish(outputs));
                    // The queue is full only if the background task is late: the log then has a
                    // gap.
                    let _ = cx.local.reports.enqueue(StepReport::new(outputs));
                });
                rtic::pend(Interrupt::$background);
            }

            #[task(
                        binds = $cycle,
                        priority = 2,
                        local = [comm_task],
                        shared = [mailboxes, telemetry, servo_bus],
                    )]
            fn communication_cycle(cx: communication_cycle::Context) {
                let (mut mailboxes, mut telemetry) = (cx.shared.mailboxes, cx.shared.telemetry);
                let mut servo_bus = cx.shared.servo_bus;
                let period = bus_status::period();
                let shared = (&mut mailboxes, &mut telemetry, &mut servo_bus);
                if (cx.local.comm_task).communicate(period, shared) {
                    rtic::pend(Interrupt::$mailbox_free);
                }
                rtic::pend(Interrupt::$bus_status);
            }

            // The FIFO holds three frames, 141 us at 1 Mbit/s: longer than the tasks of the loop
            // take, and shorter than a communication cycle.
            #[task(binds = $frame_received, priority = 3, local = [can_receiver, received])]
            fn frame_received(cx: frame_received::Context) {
                loop {
                    let is_lost = match can::receive(cx.local.can_receiver) {
                        Ok(frame) => cx.local.received.enqueue(frame).is_err(),
                        Err(nb::Error::Other(can::Overrun)) => true,
                        Err(nb::Error::WouldBlock) => return,
                    };
                    if is_lost {
                        bus_status::count_lost_frame();
                    }
                }
            }

            #[task(binds = USART1, priority = 3, shared = [servo_line, servo_bus])]
            fn line_event(cx: line_event::Context) {
                let (line, mut bus) = (cx.shared.servo_line, cx.shared.servo_bus);
                bus.lock(|bus| {
                    if let Some(bus) = bus {
                        servo_bus_task::on_line(line, bus);
                    }
                });
            }

            #[task(binds = TIM5, priority = 3, shared = [servo_line, servo_bus])]
            fn line_timer(cx: line_timer::Context) {
                let (line, mut bus) = (cx.shared.servo_line, cx.shared.servo_bus);
                bus.lock(|bus| {
                    if let Some(bus) = bus {
                        servo_bus_task::on_timer(line, bus);
                    }
                });
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

            // Requested by the controller when its state changes, and by each communication cycle.
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
