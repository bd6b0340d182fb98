//! The program of the communication board: STM32F427, between a serial line and a CAN bus.
//!
//! What the lines mean is decided in `canopen::slcan`; here bytes and frames are moved, with queues in between that
//! nobody waits for. `docs/chain.md` shows the way of a command and of a frame.
//!
//! | priority | interrupt | when | does |
//! |---|---|---|---|
//! | 3 | `USART3` | a byte came in, or the next one may go out | moves it between the line and a queue |
//! | 2 | `CAN1_RX0`, `CAN1_TX`, `CAN1_SCE` | a frame came in, a mailbox is free, something went wrong | moves frames between controller and queues |
//! | 1 | `UART8`, which is no UART here | a line or a frame is there | the adapter |
//! | 1 | `TIM3` | each millisecond | the watchdog, and what the controller was not ready for |
//!
//! Nothing locks the serial line out: at 2,000,000 baud a byte has to be fetched within 5 us. The lowest priority
//! feeds the watchdog, which it does only if everything above it came to an end.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers, and the start of the program: each place argues why it is sound"
)]

mod board;
mod comm;

/// Interrupts, and what each of them owns.
#[allow(
    missing_docs,
    reason = "RTIC makes public items here that nobody can document"
)]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use heapless::spsc::{Producer, Queue};
    use stm32f4xx_hal::pac::Interrupt;

    use crate::{
        board::{stack, watchdog::Watchdog},
        comm::{
            adapter::{FRAMES, Gateway, Stamped},
            can_bus::CanBus,
            serial::{INCOMING, OUTGOING, Serial},
            stopwatch::{Millisecond, Stopwatch},
            wiring::Board,
        },
    };

    #[shared]
    struct Shared {
        can: CanBus,
        #[lock_free]
        gateway: Gateway,
    }

    #[local]
    struct Local {
        serial: Serial,
        frames: Producer<'static, Stamped, FRAMES>,
        stopwatch: Stopwatch,
        millisecond: Millisecond,
        watchdog: Watchdog,
    }

    #[init(local = [
        incoming: Queue<u8, INCOMING> = Queue::new(),
        outgoing: Queue<u8, OUTGOING> = Queue::new(),
        frame_queue: Queue<Stamped, FRAMES> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = Board::new(cx.device);
        defmt::info!("reset cause {}", board.reset_cause as u8);
        let (heard, commands) = cx.local.incoming.split();
        let (said, to_say) = cx.local.outgoing.split();
        let (frames, received) = cx.local.frame_queue.split();
        let shared = Shared {
            can: CanBus::new(board.can),
            gateway: Gateway::new(commands, received, said),
        };
        let local = Local {
            serial: Serial::new(board.usart, heard, to_say),
            frames,
            stopwatch: board.stopwatch,
            millisecond: board.millisecond,
            watchdog: Watchdog::start(board.watchdog),
        };
        (shared, local)
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[task(binds = USART3, priority = 3, local = [serial])]
    fn byte(cx: byte::Context) {
        if cx.local.serial.serve() {
            rtic::pend(Interrupt::UART8);
        }
    }

    #[task(binds = CAN1_RX0, priority = 2, local = [frames, stopwatch], shared = [can])]
    fn received(mut cx: received::Context) {
        let (frames, now_us) = (cx.local.frames, cx.local.stopwatch.now_us());
        cx.shared.can.lock(|can| {
            while let Some(frame) = can.receive() {
                if frames.enqueue((frame, now_us)).is_err() {
                    can.lost();
                }
            }
        });
        rtic::pend(Interrupt::UART8);
    }

    #[task(binds = CAN1_TX, priority = 2, shared = [can])]
    fn mailbox_is_free(mut cx: mailbox_is_free::Context) {
        cx.shared.can.lock(CanBus::mailbox_is_free);
    }

    #[task(binds = CAN1_SCE, priority = 2, shared = [can])]
    fn trouble(mut cx: trouble::Context) {
        cx.shared.can.lock(CanBus::note_error);
    }

    #[task(binds = UART8, priority = 1, shared = [can, gateway])]
    fn adapt(mut cx: adapt::Context) {
        let can = &mut cx.shared.can;
        let gateway = cx.shared.gateway;
        let has_answered = gateway.obey(|adapter, byte| can.lock(|can| adapter.receive(byte, can)));
        if gateway.report() || has_answered {
            rtic::pend(Interrupt::USART3);
        }
    }

    #[task(binds = TIM3, priority = 1, local = [millisecond, watchdog], shared = [can, gateway])]
    fn millisecond(mut cx: millisecond::Context) {
        cx.local.millisecond.begun();
        cx.shared.can.lock(CanBus::proceed);
        let now_us = cx.local.millisecond.now_us();
        cx.shared.gateway.pass_time(now_us);
        cx.local.watchdog.feed();
        if cx.local.millisecond.is_report_due() {
            defmt::info!("deepest stack {} bytes", stack::deepest_use());
        }
        rtic::pend(Interrupt::UART8);
    }
}
