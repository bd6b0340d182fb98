//! Writes what an update needs to bank 2, in the background task: images to the staging area, and
//! records to the log of the bootloader.

use core::task::Poll;

use bootloader::{
    ACTUATOR_BOARD, Bus, HEADER_SIZE, Header, Phase, Policy, State,
    background::{Appending, Staging},
    header_of,
    layout::STM32F427,
    log,
};
use cortex_m::peripheral::DWT;
use firmware::{
    drive::{Image, Slots, UpdateOrder},
    parameters::BusSettings,
};

use super::flash::Flash;
use crate::actuator::{
    comm_task::CAPTURE_WORDS, queues::BackgroundEnds, timing::CYCLES_PER_US,
    update_result::UpdateResult,
};

/// Core cycles after which a call ends, 0.7 ms: a word takes 16 us, so that an image of 100 kB is
/// written in 700 control periods.
const CALL_CYCLES: u32 = 700 * CYCLES_PER_US;

/// Core cycles of an operation after which a call ends: it is an erase. A word takes at most 100 us
/// (data sheet of the STM32F427, flash memory programming).
const WORD_CYCLES: u32 = 100 * CYCLES_PER_US;

/// What is being written.
enum Work {
    None,
    Stage(Staging, &'static mut [i32]),
    Record(Appending, Purpose),
}

/// Why a record is written.
#[derive(Clone, Copy)]
enum Purpose {
    Confirm,
    Install,
    Bus,
}

/// The writer.
pub struct Updater {
    /// The newest record; without an image in the slot there is no bootloader that reads it.
    state: Option<State>,
    /// Node-ID and bit rate that the record shall have.
    bus: Bus,
    work: Work,
}

impl Updater {
    /// A writer, and the bootloader's record of the program that runs; `None` for a program
    /// without a bootloader, whose image has no header.
    pub fn new(flash: &Flash, bus: &BusSettings) -> (Self, Option<Slots>) {
        let image = header_of(flash, &STM32F427.slot);
        let newest = log::newest(flash, &STM32F427.records).map(|newest| newest.state);
        let known = image.zip(newest);
        let updater = Self {
            state: newest.filter(|_| image.is_some()),
            bus: of_settings(bus),
            work: Work::None,
        };
        let staged = header_of(flash, &STM32F427.staging);
        let slots = known.map(|(image, state)| slots(&image, &state, staged.as_ref()));
        (updater, slots)
    }

    /// Node-ID and bit rate were saved.
    pub fn set_bus(&mut self, bus: &BusSettings) {
        self.bus = of_settings(bus);
    }

    /// Whether an image or a record is being written.
    pub fn is_working(&self) -> bool {
        !matches!(self.work, Work::None)
    }

    /// Continues what is being written, or begins what was ordered.
    pub fn run(&mut self, flash: &mut Flash, queues: &mut BackgroundEnds) {
        if !self.is_working() {
            self.begin(queues);
        }
        let start = DWT::cycle_count();
        let mut last_end = start;
        while self.is_working() {
            let was_started = flash.is_started();
            self.poll(flash, queues);
            let now = DWT::cycle_count();
            if !(was_started && flash.is_started()) {
                last_end = now;
            }
            if now.wrapping_sub(start) > CALL_CYCLES || now.wrapping_sub(last_end) > WORD_CYCLES {
                return;
            }
        }
    }

    fn begin(&mut self, queues: &mut BackgroundEnds) {
        let Some(state) = self.state else { return };
        let (next, purpose) = match queues.update_orders.dequeue() {
            Some(UpdateOrder::Stage { buffer, length }) => {
                self.work = Work::Stage(Staging::new(STM32F427.staging, length), buffer);
                return;
            }
            Some(UpdateOrder::Confirm(version)) => (state.confirm(version), Purpose::Confirm),
            Some(UpdateOrder::Install(image)) => (state.request(image), Purpose::Install),
            None if state.bus != self.bus => {
                let bus = self.bus;
                (State { bus, ..state }, Purpose::Bus)
            }
            None => return,
        };
        self.work = Work::Record(Appending::new(next), purpose);
    }

    fn poll(&mut self, flash: &mut Flash, queues: &mut BackgroundEnds) {
        let result = match &mut self.work {
            Work::None => return,
            Work::Stage(staging, image) => match staging.poll(flash, image) {
                Poll::Pending => return,
                Poll::Ready(result) => {
                    if let Err(error) = result {
                        defmt::error!("image not staged, {}", error as u8);
                    }
                    match core::mem::replace(&mut self.work, Work::None) {
                        Work::Stage(_, image) => Some(UpdateResult::Staged(image, result)),
                        _ => None,
                    }
                }
            },
            Work::Record(appending, purpose) => {
                let (next, purpose) = (*appending.state(), *purpose);
                let Poll::Ready(written) = appending.poll(flash, &STM32F427.records) else {
                    return;
                };
                self.work = Work::None;
                self.recorded(next, purpose, written.is_ok())
            }
        };
        if let Some(result) = result {
            // There is room: the device gives the next order after this result.
            let _ = queues.updated.enqueue(result);
        }
    }

    /// A record of this state is written or not.
    fn recorded(
        &mut self,
        state: State,
        purpose: Purpose,
        is_written: bool,
    ) -> Option<UpdateResult> {
        if is_written {
            self.state = Some(state);
        } else {
            defmt::error!("record of the update not written");
            // Not tried again before the next save.
            self.bus = self.state.map_or(self.bus, |state| state.bus);
        }
        match purpose {
            Purpose::Confirm => Some(UpdateResult::Confirmed(is_written)),
            Purpose::Install => Some(UpdateResult::Requested(is_written)),
            Purpose::Bus => None,
        }
    }
}

/// What the drive needs to know of this image, this state and the header in the staging area.
fn slots(image: &Header, state: &State, staged: Option<&Header>) -> Slots {
    let buffer = (CAPTURE_WORDS * size_of::<i32>()) as u32;
    let capacity = STM32F427.slot.size().min(buffer);
    let policy = Policy {
        hardware: ACTUATOR_BOARD,
        floor: state.floor,
    };
    // An image that was installed, or refused or rolled back, stays in the staging area. The header
    // of an image is written when all of it is there; the bootloader checks it again.
    let staged = staged.filter(|staged| {
        staged.identity() != state.image && policy.check(staged, capacity).is_ok()
    });
    Slots {
        identity: image.identity(),
        version: image.version,
        policy,
        capacity,
        staged: staged.map(|staged| Image {
            identity: staged.identity(),
            bytes: HEADER_SIZE.saturating_add(staged.length),
        }),
        outcome: state.outcome,
        is_confirmed: state.phase == Phase::Idle,
    }
}

/// The settings are within these types: their ranges are checked.
fn of_settings(bus: &BusSettings) -> Bus {
    Bus {
        node_id: bus.node_id as u8,
        kbit_s: bus.bit_rate_kbit_s as u16,
    }
}
