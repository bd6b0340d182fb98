//! USART1 and TIM5 of both chips, as the servo bus uses them, at the level of their registers.

use std::collections::{BTreeMap, BTreeSet};

use rigless::device::Level;
use rigless::emulator::{Error, Memory};
use rigless::mcu::Operate as _;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use crate::board::{ActuatorBoard, ChipKind};
use crate::chip::ActuatorChip;
use crate::flash::FlashTimes;

const USART1: u64 = 0x4001_1000;
const TIM5: u64 = 0x4000_0c00;
/// Their interrupts, on both chips.
const USART1_LINE: u16 = 37;
const TIM5_LINE: u16 = 50;
/// Enables of USART1 and of TIM5 in the registers of RCC.
const USART1EN: u64 = 1 << 4;
const TIM5EN: u64 = 1 << 3;

/// The memory that DMA controllers access.
#[derive(Default)]
struct Bytes(BTreeMap<u64, u8>);

impl Memory for Bytes {
    fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
        let bytes = (0..u64::from(width.bytes())).rev();
        let byte = |at| u64::from(*self.0.get(&(address + at)).unwrap_or(&0));
        Ok(bytes.fold(0, |value, at| value << 8 | byte(at)))
    }

    fn write(&mut self, address: u64, width: Width, value: u64) -> Result<(), Error> {
        for at in 0..u64::from(width.bytes()) {
            self.0.insert(address + at, (value >> (8 * at)) as u8);
        }
        Ok(())
    }
}

/// A board whose core does not run.
struct Bench {
    chip: Box<dyn ActuatorChip>,
    memory: Bytes,
    now_ns: u64,
    high: BTreeSet<u16>,
}

impl Bench {
    fn new(kind: ChipKind) -> Self {
        let board = ActuatorBoard::try_new(kind, None, FlashTimes::TYPICAL, 0).unwrap();
        Self {
            chip: board.chip,
            memory: Bytes::default(),
            now_ns: 0,
            high: BTreeSet::new(),
        }
    }

    fn write(&mut self, address: u64, value: u64) {
        let at = VirtualNanos(self.now_ns);
        self.chip.write(at, address, Width::W32, value).unwrap();
        self.settle();
    }

    fn read(&mut self, address: u64) -> u64 {
        let at = VirtualNanos(self.now_ns);
        let value = self.chip.read(at, address, Width::W32).unwrap();
        self.settle();
        value
    }

    fn settle(&mut self) {
        self.chip.settle(&mut self.memory).unwrap();
        for change in self.chip.drain_interrupts() {
            match change.level {
                Level::High => self.high.insert(change.interrupt),
                Level::Low => self.high.remove(&change.interrupt),
            };
        }
    }

    /// Advances the time as the emulator does: from event to event.
    fn run_us(&mut self, us: u64) {
        let end_ns = self.now_ns + us * 1000;
        loop {
            self.chip.poll(VirtualNanos(self.now_ns));
            self.settle();
            let next = self.chip.next_event().map_or(end_ns, |at| at.0);
            self.now_ns = next.clamp(self.now_ns, end_ns);
            self.chip.advance_to(VirtualNanos(self.now_ns));
            self.settle();
            if self.now_ns >= end_ns {
                return;
            }
        }
    }

    /// Sends bytes to the board.
    fn send(&mut self, bytes: &[u8]) {
        let now_ns = self.now_ns;
        self.chip.servo_bus().unwrap().send(now_ns, bytes);
    }

    /// What the board has sent.
    fn sent(&mut self) -> Vec<u8> {
        let received = self.chip.servo_bus().unwrap().take_received();
        received.into_iter().map(|(_, byte)| byte).collect()
    }
}

/// Registers of the STM32F427 (RM0090, sections 6.3, 10.5 and 30.6).
mod f427 {
    pub const AHB1ENR: u64 = 0x4002_3830;
    pub const APB1ENR: u64 = 0x4002_3840;
    pub const APB2ENR: u64 = 0x4002_3844;
    pub const DMA2EN: u64 = 1 << 22;
    pub const SR: u64 = 0x00;
    pub const DR: u64 = 0x04;
    pub const BRR: u64 = 0x08;
    pub const CR1: u64 = 0x0c;
    pub const CR3: u64 = 0x14;
    pub const IDLE: u64 = 1 << 4;
    pub const TC: u64 = 1 << 6;
    /// UE, IDLEIE; RE; TE, TCIE.
    pub const ON: u64 = 1 << 13 | 1 << 4;
    pub const RE: u64 = 1 << 2;
    pub const TE: u64 = 1 << 3 | 1 << 6;
    /// HDSEL, DMAR, DMAT.
    pub const HALF_DUPLEX_WITH_DMA: u64 = 1 << 3 | 1 << 6 | 1 << 7;

    /// Configuration, count, peripheral and memory address of a stream of DMA2.
    pub const fn stream(number: u64) -> [u64; 4] {
        let base = 0x4002_6410 + 0x18 * number;
        [base, base + 4, base + 8, base + 0xc]
    }

    /// Channel 4 with increments of the memory address; the memory is the source; enabled.
    pub const CHANNEL_4: u64 = 4 << 25 | 1 << 10;
    pub const FROM_MEMORY: u64 = 1 << 6;
    pub const EN: u64 = 1;
}

/// Registers of the STM32H743 (RM0433, sections 8.7 and 48.8).
mod h743 {
    pub const APB1LENR: u64 = 0x5802_44e8;
    pub const APB2ENR: u64 = 0x5802_44f0;
    pub const CR1: u64 = 0x00;
    pub const CR3: u64 = 0x08;
    pub const BRR: u64 = 0x0c;
    pub const ISR: u64 = 0x1c;
    pub const ICR: u64 = 0x20;
    pub const RDR: u64 = 0x24;
    pub const TDR: u64 = 0x28;
    pub const IDLE: u64 = 1 << 4;
    pub const TC: u64 = 1 << 6;
    /// UE, FIFOEN, IDLEIE; RE; TE, TCIE.
    pub const ON: u64 = 1 | 1 << 29 | 1 << 4;
    pub const RE: u64 = 1 << 2;
    pub const TE: u64 = 1 << 3 | 1 << 6;
    pub const HDSEL: u64 = 1 << 3;
}

#[test]
fn dma_of_the_f427_moves_both_directions_of_the_servo_bus() {
    use f427::*;
    const BUFFER: u64 = 0x2000_0100;
    for receive_stream in [2, 5] {
        let mut bench = Bench::new(ChipKind::F427);
        bench.write(AHB1ENR, DMA2EN);
        bench.write(APB2ENR, USART1EN);
        // 1 Mbit/s at 16 MHz.
        bench.write(USART1 + BRR, 16);
        bench.write(USART1 + CR3, HALF_DUPLEX_WITH_DMA);
        let [control, count, peripheral, memory] = stream(receive_stream);
        bench.write(peripheral, USART1 + DR);
        bench.write(memory, BUFFER);
        bench.write(count, 8);
        bench.write(control, CHANNEL_4 | EN);
        // Without a receiver the bytes are lost.
        bench.send(&[9]);
        bench.run_us(5);
        bench.write(USART1 + CR1, ON | RE);
        bench.send(&[1, 2, 3]);
        bench.run_us(39);
        assert!(!bench.high.contains(&USART1_LINE));
        bench.run_us(2);
        assert!(bench.high.contains(&USART1_LINE));
        assert_eq!(bench.read(USART1 + SR) & IDLE, IDLE);
        bench.read(USART1 + DR);
        assert!(!bench.high.contains(&USART1_LINE));
        assert_eq!(bench.read(count), 5);
        let received: Vec<_> = (BUFFER..BUFFER + 3).map(|at| bench.memory.0[&at]).collect();
        assert_eq!(received, [1, 2, 3]);
        // The answer, while the receiver is off.
        let [control, count, peripheral, memory] = stream(7);
        bench.write(peripheral, USART1 + DR);
        bench.write(memory, BUFFER);
        bench.write(count, 3);
        bench.write(USART1 + SR, !TC & 0x3ff);
        bench.write(USART1 + CR1, ON | TE);
        bench.write(control, CHANNEL_4 | FROM_MEMORY | EN);
        bench.send(&[8]);
        bench.run_us(39);
        assert!(!bench.high.contains(&USART1_LINE));
        // The idle frame and three bytes.
        bench.run_us(2);
        assert!(bench.high.contains(&USART1_LINE));
        assert_eq!(bench.sent(), [1, 2, 3]);
        bench.write(USART1 + CR1, ON | RE);
        bench.run_us(50);
        assert_eq!(bench.read(stream(receive_stream)[1]), 5);
    }
}

#[test]
fn the_fifos_of_the_h743_carry_the_servo_bus() {
    use h743::*;
    let mut bench = Bench::new(ChipKind::H743);
    bench.write(APB2ENR, USART1EN);
    // 1 Mbit/s at 64 MHz.
    bench.write(USART1 + BRR, 64);
    bench.write(USART1 + CR3, HDSEL);
    bench.send(&[9]);
    bench.run_us(5);
    bench.write(USART1 + CR1, ON | RE);
    bench.send(&[1, 2, 3]);
    bench.run_us(41);
    assert!(bench.high.contains(&USART1_LINE));
    assert_eq!([(); 3].map(|()| bench.read(USART1 + RDR)), [1, 2, 3]);
    bench.write(USART1 + ICR, IDLE);
    assert!(!bench.high.contains(&USART1_LINE));
    bench.write(USART1 + ICR, TC);
    bench.write(USART1 + CR1, ON | TE);
    for byte in [1, 2, 3] {
        bench.write(USART1 + TDR, byte);
    }
    bench.send(&[8]);
    bench.run_us(39);
    assert!(!bench.high.contains(&USART1_LINE));
    bench.run_us(2);
    assert!(bench.high.contains(&USART1_LINE));
    assert_eq!(bench.sent(), [1, 2, 3]);
    bench.write(USART1 + ICR, TC);
    bench.write(USART1 + CR1, ON | RE);
    bench.run_us(50);
    // Neither data nor an idle line.
    assert_eq!(bench.read(USART1 + ISR) & (1 << 5 | IDLE), 0);
}

#[test]
fn tim5_of_both_chips_raises_its_interrupt_once_in_one_pulse_mode() {
    let [control, enables_of, status, generate, prescaler, reload] =
        [0x00, 0x0c, 0x10, 0x14, 0x28, 0x2c].map(|offset| TIM5 + offset);
    let [enabled, one_pulse] = [1, 1 << 3 | 1 << 2];
    for (kind, enables, mhz) in [
        (ChipKind::F427, f427::APB1ENR, 16),
        (ChipKind::H743, h743::APB1LENR, 64),
    ] {
        let mut bench = Bench::new(kind);
        bench.write(enables, TIM5EN);
        bench.write(prescaler, mhz - 1);
        bench.write(control, one_pulse);
        bench.write(generate, 1);
        bench.write(enables_of, 1);
        for us in [20, 500] {
            bench.write(reload, us - 1);
            bench.write(generate, 1);
            bench.write(control, one_pulse | enabled);
            bench.run_us(us - 1);
            assert!(!bench.high.contains(&TIM5_LINE));
            bench.run_us(2);
            assert!(bench.high.contains(&TIM5_LINE));
            assert_eq!(bench.read(control) & enabled, 0);
            bench.write(status, 0);
            bench.run_us(2 * us);
            assert!(!bench.high.contains(&TIM5_LINE));
        }
    }
}
