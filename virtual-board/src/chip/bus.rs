//! The bus of the chip: that of rigless, with CAN1 and with a flash that its interface programs.
//!
//! A bus description cannot be modified, and rigless does not expose parts of its own. Instances,
//! reset values and clocks are therefore read from a built part. What a built part does not expose
//! (clock gates, reset lines, request listeners, write rules) is declared here for the instances
//! that the boards use.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::mcu::{Mcu, Operate};
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::peripherals::{TIMERS, flash, rcc};
use rigless::soc::{Builder, Bus, Clock, EraseBlocks, Error, Gate, Region, WriteModify};
use rigless::time::VirtualNanos;

const fn blocks(bytes: u64, count: u32) -> EraseBlocks {
    match (NonZeroU64::new(bytes), NonZeroU32::new(count)) {
        (Some(size), Some(count)) => EraseBlocks { size, count },
        _ => panic!("a block has bytes"),
    }
}

/// RM0090, table 6.
static SECTORS: [EraseBlocks; 6] = [
    blocks(16 << 10, 4),
    blocks(64 << 10, 1),
    blocks(128 << 10, 7),
    blocks(16 << 10, 4),
    blocks(64 << 10, 1),
    blocks(128 << 10, 7),
];

/// RM0090, section 2.3.
static MEMORY: [Region; 5] = [
    Region::flash("flash", crate::flash::BASE, crate::flash::SIZE)
        .erased_in(&SECTORS)
        .erased_to(0xff)
        .programmed_by("FLASH"),
    Region::ram("ccm", 0x1000_0000, 64 << 10),
    Region::system("system", 0x1fff_0000, 32 << 10),
    Region::ram("sram", 0x2000_0000, 192 << 10),
    Region::ram("backup_sram", 0x4002_4000, 4 << 10),
];

/// First and last address of each area between the memories and the peripherals that is reserved
/// (DS9405, figure of the memory map): an access is a bus error. The aliases of bits, and the areas
/// of external memories, are not among them.
const RESERVED: [(u64, u64); 10] = [
    (0x0020_0000, 0x07ff_ffff),
    (0x0820_0000, 0x0fff_ffff),
    (0x1001_0000, 0x1ffe_bfff),
    (0x2003_0000, 0x21ff_ffff),
    (0x2400_0000, 0x3fff_ffff),
    (0x4008_0000, 0x41ff_ffff),
    (0x4400_0000, 0x4fff_ffff),
    (0x5006_0c00, 0x5fff_ffff),
    (0xa000_1000, 0xbfff_ffff),
    (0xe010_0000, 0xffff_ffff),
];

/// An instance with the RCC bits that enable its clock and reset it, which have its name.
macro_rules! clocked {
    ($($bus:literal: $($instance:literal)*;)*) => {
        [$($((
            $instance,
            Gate::by("RCC", concat!($bus, "ENR"), concat!($instance, "EN")),
            Gate::by("RCC", concat!($bus, "RSTR"), concat!($instance, "RST")),
        ),)*)*]
    };
}

/// RM0090, sections 6.3.5 to 6.3.14.
const CLOCKED: [(&str, Gate, Gate); 25] = clocked! {
    "AHB1": "GPIOA" "GPIOB" "GPIOC" "GPIOD" "GPIOE" "GPIOF" "GPIOG" "GPIOH" "GPIOI" "DMA1" "DMA2" "CRC";
    "APB1": "TIM2" "TIM3" "TIM4" "TIM5" "SPI2" "SPI3" "CAN1" "PWR" "WWDG";
    "APB2": "TIM1" "TIM8" "SPI1" "USART1";
};

/// The converters and their common block, which share one reset bit.
const CONVERTERS: [(&str, &str); 4] = [
    ("ADC1", "ADC1EN"),
    ("ADC2", "ADC2EN"),
    ("ADC3", "ADC3EN"),
    ("C_ADC", "ADC1EN"),
];

/// Instances that read requests of others: DMA requests, trigger events, chip selects. Each reads
/// each request: those that the boards do not use are omitted.
const LISTENERS: [&str; 7] = ["RTC", "SPI1", "TIM1", "RCC", "C_ADC", "ADC1", "DMA2"];

const NO_PART: VirtualNanos = VirtualNanos(0);

/// The bus description.
///
/// # Errors
/// An error of rigless if its own part cannot be built.
pub fn builder() -> Result<Builder, Error> {
    let mut stock = Stm32f427::new()?;
    let instances: Vec<_> = stock.bus().peripherals().copied().collect();
    let cpu = Operate::cpu(&stock);
    let mut builder = Bus::builder(cpu, &MEMORY, instances.iter().copied());
    for instance in &instances {
        for register in instance.registers {
            let address = instance.base + u64::from(register.offset);
            let width = register.width;
            // Registers that share an address are excluded: a read returns the value of only one of
            // them.
            if let Ok(value) = stock.peek(NO_PART, address, width)
                && value != register.reset & width.mask()
                && is_alone(instance.registers, register.offset)
            {
                builder = builder.reset(instance.name, register.name, value);
            }
        }
        if let Some(clock) = stock.bus().clock_of(instance.name) {
            builder = builder.clocked_by(instance.name, clock);
        }
    }
    Ok(wired(builder))
}

fn is_alone(registers: &[rigless::soc::RegisterSpec], offset: u32) -> bool {
    registers
        .iter()
        .filter(|other| other.offset == offset)
        .count()
        == 1
}

fn wired(mut builder: Builder) -> Builder {
    for instance in ["CAN1", "WWDG"] {
        builder = builder.clocked_by(instance, Clock::output("RCC", rcc::PCLK1));
    }
    for (instance, enable, reset) in CLOCKED {
        builder = builder.gate(instance, enable).reset_by(instance, reset);
    }
    for (instance, enable) in CONVERTERS {
        builder = builder.gate(instance, Gate::by("RCC", "APB2ENR", enable));
        builder = builder.reset_by(instance, Gate::by("RCC", "APB2RSTR", "ADCRST"));
    }
    // Its reset bit has a different name in the vendor's file.
    builder = builder
        .gate("USART3", Gate::by("RCC", "APB1ENR", "USART3EN"))
        .reset_by("USART3", Gate::by("RCC", "APB1RSTR", "UART3RST"));
    builder = builder.gate_writes("RCC", &["BDCR"], Gate::by("PWR", "CR", "DBP"));
    builder = builder.gate_writes("RTC", &[], Gate::by("PWR", "CR", "DBP"));
    for listener in LISTENERS {
        builder = builder.reads_requests(listener);
    }
    for (first, last) in RESERVED {
        builder = builder.aborts_in("reserved", first, last - first + 1);
    }
    let timers = TIMERS.iter().map(|timer| timer.instance);
    for timer in timers.chain(["TIM1", "TIM8"]) {
        builder = builder.write_modify(timer, "SR", WriteModify::ZeroToClear);
    }
    builder
        .field("FLASH", "ACR", "LATENCY", flash::LATENCY)
        .field("FLASH", "CR", "LOCK", flash::LOCK)
        .field("FLASH", "CR", "STRT", flash::STRT)
        .field("FLASH", "OPTCR", "OPTLOCK", flash::OPTLOCK)
        .field("FLASH", "OPTCR", "OPTSTRT", flash::OPTSTRT)
        .declare("FLASH", "SR", &flash::RDERR)
}

#[cfg(test)]
mod tests {
    use rigless::soc::{Fault, Width};

    use super::*;

    #[test]
    fn every_register_of_the_bus_has_the_reset_value_of_the_stock_part() {
        let mut stock = Stm32f427::new().unwrap();
        let mut own = rigless::mcu::Bare::new(builder().unwrap()).unwrap();
        let instances: Vec<_> = stock.bus().peripherals().copied().collect();
        let mut compared = 0;
        for instance in &instances {
            for register in instance.registers {
                let address = instance.base + u64::from(register.offset);
                let of = |part: &mut dyn Mcu| part.peek(NO_PART, address, register.width).ok();
                let (expected, found) = (of(&mut stock), of(&mut own));
                // The clock tree model reports states that are not in its register file.
                if instance.name != "RCC" {
                    assert_eq!(found, expected, "{}.{}", instance.name, register.name);
                }
                compared += 1;
            }
        }
        assert!(compared > 1000, "{compared}");
    }

    #[test]
    fn an_access_to_a_reserved_area_is_a_bus_error_and_one_beside_it_is_not() {
        let mut part = rigless::mcu::Bare::new(builder().unwrap()).unwrap();
        let mut is_bus_error = |address| {
            let read = part.read(NO_PART, address, Width::W32);
            matches!(read, Err(Fault::BusError { .. }))
        };
        for (first, last) in RESERVED {
            assert!(is_bus_error(first) && is_bus_error(last - 3), "{first:#x}");
            assert!(!is_bus_error(first - 4), "{first:#x}");
            assert!(
                last == u64::from(u32::MAX) || !is_bus_error(last + 1),
                "{last:#x}"
            );
        }
    }
}
