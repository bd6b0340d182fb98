//! The program of the actuator management board: STM32F427, pins, clocks and interrupts. It speaks CANopen.
//!
//! What the board does is decided in the library `firmware`; here it gets its samples, and what it
//! decides is done. `docs/hardware.md` shows the wiring and the instants of a tick.
//!
//! | priority | interrupt | when | does |
//! |---|---|---|---|
//! | 5 | `CAN1_RX0` | a frame came in | puts it into the node's queue |
//! | 4 | `TIM1_UP_TIM10` | each PWM edge, 1 ms | outputs; in period 0 reads the encoder, in period 3 asks for the window |
//! | 4 | `TIM1_CC` | period 3 | samples the current, opens the window, samples back-EMF, supply, temperature |
//! | 4 | `DMA2_STREAM0` | 38 us into the tick | the control step of the drive |
//! | 4 | `UART7`, which is no UART here | at the edges of periods 1 and 2 | the CANopen node: what came in, what is due, what goes out |
//! | 2 | `CAN1_TX`, `CAN1_SCE` | a mailbox is free; the bus is in trouble, and each turn of the node | frames to the controller, its state, bit rate and filters |
//! | 1 | `UART8`, which is no UART here | after the control step | everything that may wait |
//!
//! Nothing preempts the control step but a frame that comes in, for a microsecond, and nothing less urgent locks it out. The node shares the drive with it
//! without a lock, as it has its priority; its turns end long before the next edge, and the instants of period 3 have that period
//! for themselves. Everybody else hands over through queues that need no lock.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers, and memory that is shared with a DMA controller: each place argues why it is sound"
)]

mod actuator;
mod board;

/// The last PWM period of a control period.
const LAST_PERIOD: u32 = model_core::time::PWM_PERIODS_PER_CONTROL_PERIOD - 1;

/// Interrupts, and what each of them owns.
#[allow(
    missing_docs,
    reason = "RTIC makes public items here that nobody can document"
)]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use core::mem::MaybeUninit;

    use canopen::CanFrame;
    use firmware::{
        application::{BusState, Outputs},
        drive::StoredParameters,
        supervisor::Part,
    };
    use heapless::spsc::{Consumer, Producer, Queue};
    use stm32f4xx_hal::pac::Interrupt;

    use crate::actuator::{
        analog::Analog,
        bridge::{Bridge, Instant},
        bus_state,
        can::{Can, Receiver},
        canopen::{
            background::Background,
            built::{Built, build},
            setup,
            station::{Queues, RECEIVED, Station, TO_SEND},
            wanted::Wanted,
        },
        encoder::Encoder,
        heard,
        report::Report,
        sampling::gather,
        servo_pulse::ServoPulse,
        slot::{Slot, Taker},
        ticks::Clock,
        vigil::Vigil,
        wiring::Board,
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
        #[lock_free]
        station: Station,
        #[lock_free]
        can: Can,
        #[lock_free]
        to_send: Consumer<'static, CanFrame, TO_SEND>,
    }

    #[local]
    struct Local {
        servo_pulse: ServoPulse,
        received: Producer<'static, CanFrame, RECEIVED>,
        receiver: Receiver,
        wanted: Taker<Wanted>,
        background: Background,
    }

    #[init(local = [
        output_queue: Queue<Outputs, 3> = Queue::new(),
        received_queue: Queue<CanFrame, RECEIVED> = Queue::new(),
        send_queue: Queue<CanFrame, TO_SEND> = Queue::new(),
        wanted_slot: Slot<Wanted> = Slot::new(),
        save_slot: Slot<StoredParameters> = Slot::new(),
        saved_slot: Slot<bool> = Slot::new(),
        capture_buffer: [i32; CAPTURE_WORDS] = [0; CAPTURE_WORDS],
        built: MaybeUninit<Built> = MaybeUninit::uninit(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let mut board = Board::new(cx.device);
        let (save, to_save) = cx.local.save_slot.split();
        let built = build(
            cx.local.built,
            (board.flash, to_save),
            board.reset_cause,
            cx.local.capture_buffer,
        );
        defmt::info!(
            "reset cause {}, parameters from {}",
            board.reset_cause as u8,
            built.origin as u8
        );
        let (decided, outputs) = cx.local.output_queue.split();
        let (came_in, received) = cx.local.received_queue.split();
        let (to_send, goes_out) = cx.local.send_queue.split();
        let (give_wanted, take_wanted) = cx.local.wanted_slot.split();
        let (tell_saved, saved) = cx.local.saved_slot.split();

        let wanted = Wanted::of(built.device.node().identifiers());
        let bit_rate_kbit_s = built
            .device
            .drive
            .application()
            .parameters()
            .bus
            .bit_rate_kbit_s;
        let (can, receiver) = Can::new(board.can, bit_rate_kbit_s as u16, wanted.iter());
        let queues = Queues {
            received,
            to_send,
            outputs: decided,
            wanted: give_wanted,
            save,
            saved,
        };
        let vigil = Vigil::start(board.watchdog, cx.core.DCB, cx.core.DWT);
        board.clock.start();
        board.bridge.start();
        let shared = Shared {
            bridge: board.bridge,
            analog: board.analog,
            encoder: board.encoder,
            clock: board.clock,
            station: Station::new(&mut built.device, vigil, queues, wanted),
            can,
            to_send: goes_out,
        };
        let local = Local {
            servo_pulse: board.servo_pulse,
            received: came_in,
            receiver,
            wanted: take_wanted,
            background: Background {
                outputs,
                keeper: &mut built.keeper,
                saved: tell_saved,
                report: Report::default(),
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

    #[task(binds = TIM1_UP_TIM10, priority = 4, shared = [bridge, encoder, clock])]
    fn pwm_edge(cx: pwm_edge::Context) {
        let bridge = cx.shared.bridge;
        let (period, _) = cx.shared.clock.now();
        if period == 0 {
            cx.shared.encoder.start();
            bridge.tick_began();
        }
        bridge.period_began();
        match period {
            1 | 2 => rtic::pend(Interrupt::UART7),
            crate::LAST_PERIOD => bridge.open_window_in_this_period(),
            _ => {}
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
        local = [servo_pulse],
        shared = [bridge, analog, encoder, clock, station],
    )]
    fn control(cx: control::Context) {
        let (station, bridge) = (cx.shared.station, cx.shared.bridge);
        let mut samples = gather(
            cx.shared.encoder,
            cx.shared.analog,
            cx.local.servo_pulse,
            bridge,
        );
        let outputs = station.control(&mut samples, cx.shared.clock.now().1);
        bridge.command(outputs.bridge);
        station.end(outputs, bridge.is_late());
        rtic::pend(Interrupt::UART8);
    }

    #[task(binds = UART7, priority = 4, shared = [clock, station])]
    fn node(cx: node::Context) {
        if cx.shared.station.communicate(cx.shared.clock.period()) {
            rtic::pend(Interrupt::CAN1_TX);
        }
        rtic::pend(Interrupt::CAN1_SCE);
    }

    // Above everything, and short: the controller keeps three frames, and a turn of the node may take longer.
    #[task(binds = CAN1_RX0, priority = 5, local = [receiver, received])]
    fn received(cx: received::Context) {
        if cx.local.receiver.take_overrun() {
            setup::lost();
        }
        while let Some(frame) = cx.local.receiver.receive() {
            if cx.local.received.enqueue(frame).is_err() {
                setup::lost();
            }
        }
    }

    #[task(binds = CAN1_TX, priority = 2, shared = [can, to_send])]
    fn mailbox_is_free(cx: mailbox_is_free::Context) {
        let can = cx.shared.can;
        can.mailbox_is_free();
        while can.is_idle()
            && let Some(frame) = cx.shared.to_send.dequeue()
        {
            can.send(frame);
        }
    }

    // The controller asks for this when it goes to another state, the node at each of its times.
    #[task(
        binds = CAN1_SCE,
        priority = 2,
        local = [wanted, was: BusState = BusState::Active],
        shared = [can, to_send],
    )]
    fn bus(cx: bus::Context) {
        let can = cx.shared.can;
        can.proceed();
        let state = can.state();
        bus_state::note(state);
        if state == BusState::Off && *cx.local.was != BusState::Off {
            setup::left_the_bus();
        }
        *cx.local.was = state;
        if let Some(kbit_s) = setup::take_bit_rate() {
            // What waits would break in upon the silence of the network.
            while cx.shared.to_send.dequeue().is_some() {}
            can.set_bit_rate(kbit_s);
        }
        if let Some(wanted) = cx.local.wanted.take() {
            can.set_filters(wanted.iter());
        }
        heard::from(Part::Bus);
    }

    #[task(binds = UART8, priority = 1, local = [background])]
    fn background(cx: background::Context) {
        cx.local.background.run();
    }
}
