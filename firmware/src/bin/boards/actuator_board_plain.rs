//! The program of the actuator management board with plain CAN frames: `actuator-board` is the one that speaks
//! CANopen, this one shows what the application takes without it.
//!
//! What the board does is decided in the library `firmware`; here it gets its samples, and what it
//! decides is done. `docs/hardware.md` shows the wiring and the instants of a tick.
//!
//! | priority | interrupt | when | does |
//! |---|---|---|---|
//! | 4 | `TIM1_UP_TIM10` | each PWM edge, 1 ms | outputs; in period 0 reads the encoder, in period 3 asks for the window |
//! | 4 | `TIM1_CC` | period 3 | samples the current, opens the window, samples back-EMF, supply, temperature |
//! | 4 | `DMA2_STREAM0` | 38 us into the tick | the control step |
//! | 2 | `CAN1_RX0`, `CAN1_TX`, `CAN1_SCE` | a frame came in, a mailbox is free, the bus is in trouble | moves frames between controller and queues |
//! | 1 | `UART8`, which is no UART here | after the control step | everything that may wait |
//!
//! Nothing preempts the control step, and nothing less urgent locks it out: it hands over through
//! queues that need no lock.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers, and memory that is shared with a DMA controller: each place argues why it is sound"
)]
#![allow(dead_code, reason = "the CANopen half of the board's modules")]

mod actuator;
mod board;
mod plain;

/// Interrupts, and what each of them owns.
#[allow(
    missing_docs,
    reason = "RTIC makes public items here that nobody can document"
)]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use firmware::{
        application::{Application, Outputs, Start},
        capture::Capture,
        command::excitation::{ExcitationSettings, Run, Sample},
        frames::{Frames, Message},
        parameters::BoardParameters,
        service::Service,
        store::{self, Origin},
        supervisor::{Part, ResetCause},
    };
    use heapless::spsc::{Producer, Queue};
    use stm32f4xx_hal::pac::Interrupt;

    use crate::{
        actuator::{
            analog::Analog,
            bridge::{Bridge, Instant},
            bus_state,
            can::{Can, Receiver},
            encoder::Encoder,
            heard,
            keeper::Keeper,
            sampling::gather,
            servo_pulse::ServoPulse,
            slot::Slot,
            ticks::Clock,
            vigil::Vigil,
            wiring::Board,
        },
        plain::{
            background::{Background, Excitations},
            control_step::{Answer, COMMANDS, ControlStep, Numbered, Queues, Wanted},
        },
    };

    /// Words of the capture: 20 s of eight signals.
    const CAPTURE_WORDS: usize = 40 * 1024;

    #[shared]
    struct Shared {
        #[lock_free]
        bridge: Bridge,
        #[lock_free]
        analog: Analog,
        #[lock_free]
        encoder: Encoder,
        #[lock_free]
        clock: Clock,
        can: Can,
    }

    #[local]
    struct Local {
        step: ControlStep,
        servo_pulse: ServoPulse,
        frames: Frames,
        receiver: Receiver,
        commands: Producer<'static, Message, COMMANDS>,
        accesses: Producer<'static, Message, 8>,
        background: Background,
    }

    #[init(local = [
        output_queue: Queue<Outputs, 3> = Queue::new(),
        command_queue: Queue<Message, COMMANDS> = Queue::new(),
        access_queue: Queue<Message, 8> = Queue::new(),
        answer_queue: Queue<Answer, 8> = Queue::new(),
        save_slot: Slot<BoardParameters> = Slot::new(),
        excitation_slot: Slot<Numbered<ExcitationSettings>> = Slot::new(),
        run_slot: Slot<Numbered<Run>> = Slot::new(),
        due_slot: Slot<Numbered<u64>> = Slot::new(),
        sample_slot: Slot<Numbered<Sample>> = Slot::new(),
        capture_buffer: [i32; CAPTURE_WORDS] = [0; CAPTURE_WORDS],
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let mut board = Board::new(cx.device);
        let loaded = store::load::<BoardParameters>(&board.flash);
        let parameters = loaded.parameters;
        let start = Start {
            watchdog: board.reset_cause == ResetCause::Watchdog,
            parameters_corrupt: loaded.origin == Origin::DefaultsInsteadOfCorrupt,
        };
        defmt::info!(
            "reset cause {}, parameters from {}",
            board.reset_cause as u8,
            loaded.origin as u8
        );
        let (decided, outputs) = cx.local.output_queue.split();
        let (commands, commanded) = cx.local.command_queue.split();
        let (accesses, accessed) = cx.local.access_queue.split();
        let (answered, answers) = cx.local.answer_queue.split();
        let (save, to_save) = cx.local.save_slot.split();
        let (excitations, asked) = cx.local.excitation_slot.split();
        let (made, runs) = cx.local.run_slot.split();
        let (wanted, due) = cx.local.due_slot.split();
        let (computed, samples) = cx.local.sample_slot.split();

        let node_id = parameters.bus.node_id as u8;
        let bit_rate_kbit_s = parameters.bus.bit_rate_kbit_s as u16;
        let frames = Frames::new(node_id);
        let (can, receiver) = Can::new(board.can, bit_rate_kbit_s, frames.identifiers());
        let step = ControlStep {
            application: Application::after(parameters, start),
            capture: Capture::new(cx.local.capture_buffer),
            service: Service::after(board.reset_cause),
            vigil: Vigil::start(board.watchdog, cx.core.DCB, cx.core.DWT),
            queues: Queues {
                commands: commanded,
                accesses: accessed,
                answers: answered,
                save,
                outputs: decided,
                excitations,
                runs,
                due: wanted,
                samples,
            },
            wanted: Wanted::default(),
        };
        board.clock.start();
        board.bridge.start();
        let shared = Shared {
            bridge: board.bridge,
            analog: board.analog,
            encoder: board.encoder,
            clock: board.clock,
            can,
        };
        let local = Local {
            step,
            servo_pulse: board.servo_pulse,
            frames,
            receiver,
            commands,
            accesses,
            background: Background::new(
                outputs,
                answers,
                Keeper::new(to_save, board.flash, &loaded),
                Excitations {
                    asked,
                    made,
                    due,
                    samples: computed,
                },
                node_id,
            ),
        };
        (shared, local)
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[task(binds = TIM1_UP_TIM10, priority = 4, shared = [bridge, encoder, clock])]
    fn pwm_edge(cx: pwm_edge::Context) {
        let bridge = cx.shared.bridge;
        match cx.shared.clock.now() {
            (0, _) => {
                cx.shared.encoder.start();
                bridge.tick_began();
                bridge.period_began();
            }
            (period, _) => {
                bridge.period_began();
                if period + 1 == model_core::time::PWM_PERIODS_PER_CONTROL_PERIOD {
                    bridge.open_window_in_this_period();
                }
            }
        }
    }

    #[task(binds = TIM1_CC, priority = 4, shared = [bridge, analog])]
    fn instant(cx: instant::Context) {
        match cx.shared.bridge.instant() {
            Some(Instant::Current) => cx.shared.analog.sample_current(),
            Some(Instant::BackEmf) => cx.shared.analog.start_scan(),
            Some(Instant::Opened) | None => {}
        }
    }

    #[task(
        binds = DMA2_STREAM0,
        priority = 4,
        local = [step, servo_pulse],
        shared = [bridge, analog, encoder, clock],
    )]
    fn control(cx: control::Context) {
        let (step, bridge) = (cx.local.step, cx.shared.bridge);
        let mut samples = gather(
            cx.shared.encoder,
            cx.shared.analog,
            cx.local.servo_pulse,
            bridge,
        );
        let outputs = step.run(&mut samples, cx.shared.clock.now().1);
        bridge.command(outputs.bridge);
        step.end(outputs, bridge.is_late());
        rtic::pend(Interrupt::UART8);
    }

    #[task(binds = CAN1_RX0, priority = 2, local = [frames, receiver, commands, accesses])]
    fn received(cx: received::Context) {
        while let Some(frame) = cx.local.receiver.receive() {
            let _ = match cx.local.frames.receive(&frame) {
                Some(command @ Message::Command { .. }) => cx.local.commands.enqueue(command),
                // Who asks for more before the answers came gets fewer answers.
                Some(access @ Message::Access(_)) => cx.local.accesses.enqueue(access),
                None => continue,
            };
        }
    }

    #[task(binds = CAN1_TX, priority = 2, shared = [can])]
    fn mailbox_is_free(mut cx: mailbox_is_free::Context) {
        cx.shared.can.lock(Can::mailbox_is_free);
    }

    // The controller asks for this when it goes to another state, the background in each tick.
    #[task(binds = CAN1_SCE, priority = 2, shared = [can])]
    fn bus(mut cx: bus::Context) {
        bus_state::note(cx.shared.can.lock(|can| {
            can.proceed();
            can.state()
        }));
        heard::from(Part::Bus);
    }

    #[task(binds = UART8, priority = 1, local = [background], shared = [can])]
    fn background(mut cx: background::Context) {
        cx.local.background.run(|frame| {
            // A bus that takes no frames loses telemetry, which is out of date by then.
            cx.shared.can.lock(|can| can.send(frame));
        });
        rtic::pend(Interrupt::CAN1_SCE);
    }
}
