//! Pins and SPI are configured as the wiring page documents.

use std::fs;
use std::path::Path;

use board_tests::comm::run_comm_script;
use board_tests::program::run_script;
use virtual_board::run::{CommView, Flow, Options, SharedBus, View};

/// A pin and the fields of its registers.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Pin {
    name: String,
    /// MODER: 1 output, 2 alternate, 3 analogue.
    mode: u32,
    /// AFR, if it is an alternate one.
    function: Option<u32>,
    /// PUPDR: 1 up, 2 down.
    pull: u32,
    /// OSPEEDR: 2 high, 3 very high.
    speed: u32,
    /// OTYPER.
    is_open_drain: bool,
    /// LCKR: its bit and that of the key are set.
    is_locked: bool,
}

/// Headings of the boards' sections.
const ACTUATOR: &str = "\n## Pins\n";
const COMM: &str = "\n## The communication board\n";

/// The pins to the CAN transceiver and to the servo bus need edges of less than 100 ns.
const FAST: [&str; 2] = ["PD1", SERVO_BUS];

/// The wire of the servo bus, which all servos pull low: an open drain.
const SERVO_BUS: &str = "PB6";

/// The clock of the encoder: a late feedback of its edges may corrupt the last bit of a byte
/// (ES0206).
const FASTEST: &str = "PA5";

/// The rows of the page's table of pins behind a heading: function, pins, connector, peripheral,
/// pulls, outside.
fn page(heading: &str) -> Vec<Pin> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/hardware.md");
    let text = fs::read_to_string(path).expect("the page");
    let (_, text) = text.split_once(heading).expect("the heading");
    let section = text
        .split_once("\n## ")
        .map_or(text, |(section, _)| section);
    let rows = section.lines().filter_map(|line| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        (cells.len() == 8).then_some(cells)
    });
    let mut pins = Vec::new();
    for cells in rows {
        let function = cells[4]
            .split(", ")
            .find_map(|word| word.strip_prefix("AF"));
        let function = function.map(|number| number.parse().expect("a number"));
        let mode = match cells[4] {
            "output" => 1,
            analog if analog.starts_with("ADC1") => 3,
            _ if function.is_some() => 2,
            _ => continue,
        };
        let pulls = cells[5].split(", ").chain(std::iter::repeat(""));
        pins.extend(cells[2].split(", ").zip(pulls).map(|(name, pull)| Pin {
            name: name.to_owned(),
            mode,
            function,
            pull: match pull {
                "up" => 1,
                "down" => 2,
                _ => 0,
            },
            speed: match name {
                FASTEST => 3,
                _ if FAST.contains(&name) => 2,
                _ => 0,
            },
            is_open_drain: name == SERVO_BUS,
            is_locked: true,
        }));
    }
    pins
}

/// The configuration of a pin by the chip's registers (RM0090, sections 8.4.1 to 8.4.4, 8.4.9 and
/// 8.4.10).
fn configured_pin(mut register: impl FnMut(u64) -> u32, name: &str) -> Pin {
    let (port, number) = name[1..].split_at(1);
    let number: u64 = number.parse().expect("a pin's number");
    let port = 0x4002_0000 + 0x400 * u64::from(port.as_bytes()[0] - b'A');
    let mut two_bits = |offset| register(port + offset) >> (2 * number) & 3;
    let (mode, speed, pull) = (two_bits(0x00), two_bits(0x08), two_bits(0x0c));
    let is_open_drain = register(port + 0x04) >> number & 1 == 1;
    let lock = register(port + 0x1c);
    let function = register(port + 0x20 + 4 * (number / 8)) >> (4 * (number % 8)) & 15;
    Pin {
        name: name.to_owned(),
        mode,
        function: (mode == 2).then_some(function),
        pull,
        speed,
        is_open_drain,
        is_locked: lock >> 16 & lock >> number & 1 == 1,
    }
}

/// The pins, and the control register of SPI1, after the start.
fn actuator_board_pins() -> (Vec<Pin>, u32) {
    let (sender, receiver) = std::sync::mpsc::channel();
    let mut periods = 0;
    let script = move |view: &mut View<'_>| {
        periods += 1;
        if periods < 40 {
            return Flow::Continue;
        }
        let pins = page(ACTUATOR)
            .iter()
            .map(|pin| configured_pin(|address| view.register(address), &pin.name))
            .collect();
        let spi_cr1 = view.register(0x4001_3000);
        sender.send((pins, spi_cr1)).expect("the test waits");
        Flow::End
    };
    run_script(Options::for_ms(100), script);
    receiver.recv().expect("the script has read the registers")
}

#[test]
fn pins_and_encoder_clock_match_the_hardware_page() {
    let (pins, spi_cr1) = actuator_board_pins();
    let page = page(ACTUATOR);
    assert_eq!(page.len(), 17, "the table of the page");
    assert_eq!(pins, page);
    // CPOL is bit 1, CPHA bit 0, the rate bits 3 to 5: 84 MHz over 2^(n + 1) (section 28.5.1).
    let (cpha, cpol, rate) = (spi_cr1 & 1, spi_cr1 >> 1 & 1, spi_cr1 >> 3 & 7);
    let khz = 84_000 >> (rate + 1);
    let expected = format!("CPOL = {cpol}, CPHA = {cpha}, {khz} kHz");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/hardware.md");
    let text = fs::read_to_string(path).expect("the page");
    assert!(text.contains(&expected), "{expected} is not in the page");
}

#[test]
fn pins_and_baud_rate_of_the_communication_board_match_the_hardware_page() {
    let (sender, receiver) = std::sync::mpsc::channel();
    let script = move |view: &mut CommView<'_>| {
        if view.now_ns() < 10_000_000 {
            return Flow::Continue;
        }
        let pins: Vec<_> = page(COMM)
            .iter()
            .map(|pin| configured_pin(|address| view.register(address), &pin.name))
            .collect();
        // BRR of USART3: clock cycles of a bit with 16 samples (section 30.6.3).
        let baud = 40_000_000 / view.register(0x4000_4808);
        sender.send((pins, baud)).expect("the test waits");
        Flow::End
    };
    run_comm_script(&SharedBus::new(Vec::new(), 1), script, 100);
    let (pins, baud) = receiver.recv().expect("the script has read the registers");
    assert_eq!(pins.len(), 4);
    assert_eq!((pins, baud), (page(COMM), 2_000_000));
}
