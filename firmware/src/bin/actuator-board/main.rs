//! The program of the actuator management board: STM32F427, pins, clocks and interrupts.
//!
//! What the board does is decided in the library `firmware`; here it gets its samples, and what it
//! decides is done. `docs/hardware.md` shows the wiring and the instants of a tick.
//!
//! | priority | interrupt | when | does |
//! |---|---|---|---|
//! | 4 | `TIM1_UP_TIM10` | each PWM edge, 1 ms | outputs; in period 0 reads the encoder, in period 3 asks for the window |
//! | 4 | `TIM1_CC` | period 3 | samples the current, opens the window, samples back-EMF, supply, temperature |
//! | 4 | `DMA2_STREAM0` | 38 us into the tick | the control step |
//! | 2 | `CAN1_RX0`, `CAN1_TX` | a frame came in, a mailbox is free | moves frames between controller and queues |
//! | 1 | `background` | after the control step | everything that may wait |
//!
//! Nothing preempts the control step, and nothing less urgent locks it out: it hands over through
//! queues that need no lock.

#![no_std]
#![no_main]
// Registers, and memory that is shared with a DMA controller: each place argues why it is sound.
#![allow(unsafe_code)]

mod analog;
mod bridge;
mod can;
mod can_frame;
mod dma;
mod encoder;
mod log;
mod reset_cause;
mod safe_state;
mod servo_pulse;
mod watchdog;
mod wiring;

/// Interrupts, and what each of them owns.
#[allow(missing_docs)]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use embedded_can::{Frame as _, StandardId};
    use firmware::application::{Application, Outputs, Request, Samples};
    use heapless::spsc::{Consumer, Producer, Queue};
    use model_core::control::{
        cascade::Coefficients, encoder_word::EncoderWord, parameters::ControlParameters,
        units::Angle,
    };
    use stm32f4xx_hal::pac::Interrupt;

    use crate::{
        analog::Analog,
        bridge::{Bridge, Instant},
        can::Can,
        can_frame::CanFrame,
        encoder::Encoder,
        servo_pulse::ServoPulse,
        watchdog::Watchdog,
        wiring::Board,
    };

    const COEFFICIENTS: Coefficients = match Coefficients::try_new(&ControlParameters::DEFAULT) {
        Ok(coefficients) => coefficients,
        Err(_) => panic!("the defaults are valid"),
    };

    /// PWM periods in a tick.
    const PERIODS: u8 = 4;

    type Command = (Angle, Option<Request>);

    #[shared]
    struct Shared {
        #[lock_free]
        bridge: Bridge,
        #[lock_free]
        analog: Analog,
        #[lock_free]
        encoder: Encoder,
        can: Can,
    }

    #[local]
    struct Local {
        period: u8,
        application: Application,
        command: Angle,
        servo_pulse: ServoPulse,
        decided: Producer<'static, Outputs>,
        outputs: Consumer<'static, Outputs>,
        requested: Producer<'static, Command>,
        requests: Consumer<'static, Command>,
        watchdog: Watchdog,
    }

    #[init(local = [output_queue: Queue<Outputs, 4> = Queue::new(), request_queue: Queue<Command, 4> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let mut board = Board::new(cx.device);
        defmt::info!("started after: {}", board.reset_cause);
        let (decided, outputs) = cx.local.output_queue.split();
        let (requested, requests) = cx.local.request_queue.split();
        let watchdog = Watchdog::start(board.watchdog);
        board.bridge.start();
        let shared = Shared {
            bridge: board.bridge,
            analog: board.analog,
            encoder: board.encoder,
            can: board.can,
        };
        let local = Local {
            period: PERIODS - 1,
            application: Application::new(COEFFICIENTS),
            command: Angle::ZERO,
            servo_pulse: board.servo_pulse,
            decided,
            outputs,
            requested,
            requests,
            watchdog,
        };
        (shared, local)
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[task(binds = TIM1_UP_TIM10, priority = 4, local = [period], shared = [bridge, encoder])]
    fn pwm_edge(cx: pwm_edge::Context) {
        *cx.local.period = (*cx.local.period + 1) % PERIODS;
        cx.shared.bridge.period_began();
        match *cx.local.period {
            0 => cx.shared.encoder.start(),
            3 => cx.shared.bridge.open_window_in_this_period(),
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
        local = [application, command, servo_pulse, decided, requests],
        shared = [bridge, analog, encoder],
    )]
    fn control(cx: control::Context) {
        let local = cx.local;
        let word = cx.shared.encoder.finish();
        let _codes = cx.shared.analog.codes();
        let _pulse = local.servo_pulse.take_us();
        while let Some((command, request)) = local.requests.dequeue() {
            *local.command = command;
            if let Some(request) = request {
                local.application.request(request);
            }
        }
        let samples = Samples {
            encoder: word.unwrap_or(EncoderWord::new(0)),
            command: *local.command,
        };
        let outputs = local.application.step(&samples);
        cx.shared.bridge.command(outputs.bridge);
        let _ = local.decided.enqueue(outputs);
        rtic::pend(Interrupt::UART8);
    }

    #[task(binds = CAN1_RX0, priority = 2, local = [requested], shared = [can])]
    fn received(mut cx: received::Context) {
        while let Some(frame) = cx.shared.can.lock(Can::receive) {
            if let Some([a, b, c, d, request]) = frame.data().get(..5) {
                let mdeg = i32::from_le_bytes([*a, *b, *c, *d]);
                let command = Angle::from_bits((i64::from(mdeg) << 32) / 1000);
                let request = match request {
                    1 => Some(Request::Enable),
                    2 => Some(Request::Disable),
                    3 => Some(Request::Acknowledge),
                    _ => None,
                };
                let _ = cx.local.requested.enqueue((command, request));
            }
        }
    }

    #[task(binds = CAN1_TX, priority = 2, shared = [can])]
    fn transmitted(mut cx: transmitted::Context) {
        cx.shared.can.lock(Can::mailbox_is_free);
    }

    // No UART is in use: its interrupt is the one that the control step asks for.
    #[task(binds = UART8, priority = 1, local = [outputs, watchdog], shared = [can])]
    fn background(mut cx: background::Context) {
        while let Some(outputs) = cx.local.outputs.dequeue() {
            let mdeg = ((outputs.angle.to_bits() >> 16) * 1000) >> 16;
            let rate = ((outputs.rate.to_bits() >> 16) * 10) >> 16;
            let [a, b, c, d] = (mdeg as i32).to_le_bytes();
            let [e, f] = (rate as i16).to_le_bytes();
            let id = StandardId::new(0x181);
            if let Some(frame) = id.and_then(|id| CanFrame::new(id, &[a, b, c, d, e, f])) {
                cx.shared.can.lock(|can| can.send(frame));
            }
            cx.local.watchdog.feed();
        }
    }
}
