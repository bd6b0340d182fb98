//! Which objects are parameters of the board, by their numbers in [`BoardParameters`].

use canopen::Abort;
use canopen::dictionary::Address;

use crate::{
    application::{Application, Refused},
    parameters::BoardParameters,
};

/// Sub-indices in a row that are parameters in a row.
struct Run {
    index: u16,
    /// The first sub-index, and the last one.
    subs: (u8, u8),
    /// The number of the first.
    number: u8,
}

const fn run(index: u16, first: u8, last: u8, number: u8) -> Run {
    Run {
        index,
        subs: (first, last),
        number,
    }
}

/// A test holds the names, ranges and defaults of the dictionary to those of the parameters.
const RUNS: [Run; 15] = [
    run(0x2001, 4, 8, 20),
    run(0x2010, 3, 4, 12),
    run(0x2010, 5, 6, 6),
    run(0x2040, 1, 1, 18),
    run(0x2040, 4, 4, 19),
    run(0x2100, 1, 24, 27),
    run(0x2101, 1, 3, 14),
    run(0x2102, 1, 2, 25),
    run(0x6065, 0, 0, 41),
    run(0x6066, 0, 0, 43),
    run(0x6075, 0, 0, 36),
    run(0x60F9, 1, 5, 1),
    run(0x60F9, 6, 7, 10),
    run(0x60FB, 1, 1, 0),
    run(0x60FB, 2, 3, 8),
];

/// `command_source`.
pub(super) const SOURCE: u8 = 17;

/// The parameter that an object is.
pub(super) fn number_of(address: Address) -> Option<u8> {
    let run = RUNS.iter().find(|run| {
        let (first, last) = run.subs;
        run.index == address.index && (first..=last).contains(&address.sub)
    })?;
    Some(run.number + (address.sub - run.subs.0))
}

/// The value as the bits of its data type; those of an integer go on to 64 bits.
pub(super) fn read(parameters: &BoardParameters, number: u8) -> Result<u64, Abort> {
    let word = parameters.word(number).ok_or(Abort::NoObject)?;
    Ok(word as i32 as u64)
}

/// Takes a new value, if it goes together with all others.
pub(super) fn write(application: &mut Application, number: u8, value: u64) -> Result<(), Abort> {
    let mut parameters = *application.parameters();
    if !parameters.set_word(number, value as u32) {
        return Err(Abort::Value);
    }
    application.retune(&parameters).map_err(abort)
}

/// Why a request was refused, as SDO tells it.
pub(super) fn abort(refused: Refused) -> Abort {
    match refused {
        // It is in its range: another one does not let it.
        Refused::Parameter(_) => Abort::Incompatible,
        _ => Abort::DeviceState,
    }
}
