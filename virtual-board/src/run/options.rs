//! Options of a run.

use crate::board::ChipKind;
use crate::faults::Planned;
use crate::flash::FlashTimes;
use crate::plant::BoardPlantOptions;

/// Options of a run.
#[derive(Debug, Clone)]
pub struct Options {
    /// The chip of the board.
    pub chip: ChipKind,
    /// The plant.
    pub plant: BoardPlantOptions,
    /// External stations on the CAN bus: their bit rates, bit/s.
    pub ports_bit_s: Vec<u32>,
    /// Erase and program times of the flash.
    pub flash_times: FlashTimes,
    /// Faults to be injected.
    pub faults: Vec<Planned>,
    /// Functions whose instructions are counted.
    pub probes: Vec<String>,
    /// Width of the servo pulses, us; `None` for no pulses.
    pub servo_us: Option<f64>,
    /// Initial contents of the chip's memory beside the program, such as saved parameters: an
    /// address, and the bytes from there on.
    pub contents: Vec<(u64, Vec<u8>)>,
    /// Whether the trace keeps its rows; otherwise it only computes their hash.
    pub keeps_trace: bool,
    /// Whether [`Script::at_poll`](super::Script::at_poll) is called at every stop of the run:
    /// those of the plant, four in each PWM period, and those of a shared bus. A script that
    /// exchanges bytes with the servo bus is late by less than 1 ms then, without further stops.
    pub polls_at_stops: bool,
    /// Whether the core has its memory protection unit: a run takes some sixty times longer.
    pub protects_memory: bool,
    /// End of the run, ns of virtual time.
    pub until_ns: u64,
}

impl Options {
    /// A run of this many ms with the default plant, one CAN port at 1 Mbit/s and a stored trace.
    ///
    /// ```
    /// assert_eq!(virtual_board::run::Options::for_ms(5).until_ns, 5_000_000);
    /// ```
    pub fn for_ms(ms: u64) -> Self {
        Self {
            chip: ChipKind::F427,
            plant: BoardPlantOptions::default(),
            ports_bit_s: vec![1_000_000],
            flash_times: FlashTimes::TYPICAL,
            faults: Vec::new(),
            probes: Vec::new(),
            servo_us: None,
            contents: Vec::new(),
            keeps_trace: true,
            polls_at_stops: false,
            protects_memory: false,
            until_ns: ms * 1_000_000,
        }
    }
}
