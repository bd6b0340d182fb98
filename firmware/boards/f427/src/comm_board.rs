//! Program of the communication board: STM32F427, between a serial line and a CAN bus.
//!
//! `canopen::slcan` interprets the lines; this program moves bytes and frames through queues, and
//! never waits. `docs/chain.md` shows the path of a command and of a frame.
//!
//! | priority | interrupt | event | function |
//! |---|---|---|---|
//! | 3 | `USART3` | byte received, or line ready for the next one | moves it between line and queue |
//! | 2 | `CAN1_RX0`, `CAN1_TX`, `CAN1_SCE` | frame received, mailbox free, error | moves frames between controller and queues |
//! | 1 | `UART8`, used as a software interrupt | a command or a frame is in the queue | slcan adapter |
//! | 1 | `TIM3` | each millisecond | watchdog; joins the bus when the controller is ready |
//!
//! No task locks the serial line out: at 2,000,000 baud a byte has to be read within 5 us. The
//! lowest priority feeds the watchdog: it runs only if all higher ones end.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers and exception handlers: each block states why it is sound"
)]

#[macro_use]
#[path = "../../shared/board/mod.rs"]
mod board;
mod chip;
mod comm;

board_is!("communication board", "STM32F427");

/// Tasks and their resources.
#[allow(
    missing_docs,
    reason = "RTIC generates public items that cannot be documented"
)]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use heapless::spsc::{Producer, Queue};
    use stm32f4xx_hal::pac::Interrupt;

    use crate::{
        board::{diagnostics, watchdog::Watchdog},
        comm::{
            can_controller::CanController,
            serial::{RECEIVE_QUEUE, Serial, TRANSMIT_QUEUE},
            slcan_adapter::{FRAME_QUEUE, SlcanAdapter, StampedFrame},
            timers::{MicrosecondCounter, MillisecondTimer},
            wiring::Peripherals,
        },
    };

    #[shared]
    struct Shared {
        can: CanController,
        #[lock_free]
        adapter: SlcanAdapter,
    }

    #[local]
    struct Local {
        serial: Serial,
        frames: Producer<'static, StampedFrame, FRAME_QUEUE>,
        receive_clock: MicrosecondCounter,
        adapter_clock: MicrosecondCounter,
        milliseconds: MillisecondTimer,
        watchdog: Watchdog,
    }

    #[init(local = [
        receive_queue: Queue<u8, RECEIVE_QUEUE> = Queue::new(),
        transmit_queue: Queue<u8, TRANSMIT_QUEUE> = Queue::new(),
        frame_queue: Queue<StampedFrame, FRAME_QUEUE> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let peripherals = Peripherals::new(cx.device);
        defmt::info!("reset cause {}", peripherals.reset_cause as u8);
        let (received, commands) = cx.local.receive_queue.split();
        let (lines, to_transmit) = cx.local.transmit_queue.split();
        let (frames, received_frames) = cx.local.frame_queue.split();
        let shared = Shared {
            can: CanController::new(peripherals.can),
            adapter: SlcanAdapter::new(commands, received_frames, lines),
        };
        let local = Local {
            serial: Serial::new(peripherals.usart, received, to_transmit),
            frames,
            receive_clock: peripherals.microseconds,
            adapter_clock: peripherals.microseconds,
            milliseconds: peripherals.milliseconds,
            watchdog: Watchdog::start(peripherals.watchdog),
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
    fn serial_byte(cx: serial_byte::Context) {
        if cx.local.serial.on_interrupt() {
            rtic::pend(Interrupt::UART8);
        }
    }

    #[task(binds = CAN1_RX0, priority = 2, local = [frames, receive_clock], shared = [can])]
    fn frame_received(mut cx: frame_received::Context) {
        let (frames, now_us) = (cx.local.frames, cx.local.receive_clock.now_us());
        cx.shared.can.lock(|can| {
            while let Some(frame) = can.receive() {
                if frames.enqueue((frame, now_us)).is_err() {
                    can.record_lost_frame();
                }
            }
        });
        rtic::pend(Interrupt::UART8);
    }

    #[task(binds = CAN1_TX, priority = 2, shared = [can])]
    fn mailbox_free(mut cx: mailbox_free::Context) {
        cx.shared.can.lock(CanController::on_mailbox_free);
    }

    #[task(binds = CAN1_SCE, priority = 2, shared = [can])]
    fn bus_error(mut cx: bus_error::Context) {
        cx.shared.can.lock(CanController::on_error);
    }

    #[task(binds = UART8, priority = 1, shared = [can, adapter])]
    fn adapt(mut cx: adapt::Context) {
        let can = &mut cx.shared.can;
        let adapter = cx.shared.adapter;
        let has_answered =
            adapter.execute_commands(|slcan, byte| can.lock(|can| slcan.receive(byte, can)));
        if adapter.forward_frames() || has_answered {
            rtic::pend(Interrupt::USART3);
        }
    }

    #[task(
        binds = TIM3,
        priority = 1,
        local = [milliseconds, adapter_clock, watchdog],
        shared = [can, adapter],
    )]
    fn millisecond(mut cx: millisecond::Context) {
        let is_report_due = cx.local.milliseconds.acknowledge();
        cx.shared.can.lock(CanController::join_bus_if_pending);
        let now_us = cx.local.adapter_clock.now_us();
        cx.shared.adapter.update_time(now_us);
        cx.local.watchdog.feed();
        if is_report_due {
            defmt::info!("deepest stack {} bytes", diagnostics::maximum_stack_use());
        }
        rtic::pend(Interrupt::UART8);
    }
}
