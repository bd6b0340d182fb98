//! Commands that exercise all of the program.

use crate::frames::{
    Frame, LOAD, SAVE, control, mode, nmt, read, sdo, standard, start, velocity, write,
};
use crate::master::TICK_RATE_HZ;

/// Targets, deg: steps, sines, a ramp, the end stops of the servo alternately, an angle beyond the
/// position limits, and one of a few encoder counts.
fn target_deg(tick: u64) -> f64 {
    let seconds = tick as f64 / f64::from(TICK_RATE_HZ);
    let sine = |deg: f64, hz: f64| deg * (2.0 * std::f64::consts::PI * hz * seconds).sin();
    match tick / 500 % 7 {
        0 => f64::from((tick / 125 % 3) as i32 - 1) * 30.0,
        1 => sine(20.0, 0.7),
        2 => (seconds % 2.5) * 20.0 - 25.0,
        3 => 70.0,
        4 => sine(2.0, 5.0),
        5 if (tick / 50).is_multiple_of(2) => 60.0,
        5 => -60.0,
        _ => 0.3,
    }
}

/// Each mode for ten seconds, with occasional quick stops, halts and disabled power.
pub fn command(tick: u64) -> Vec<Frame> {
    let code = [8, 1, 3, 9, 4, 10][(tick / 2500 % 6) as usize];
    let within = tick % 2500;
    let mdeg = (target_deg(tick) * 1000.0) as i32;
    let word = match within {
        0..12 => 0x06,
        12..14 => 0x07,
        // A new set-point each time, with the handshake of profile position.
        _ if tick % 50 < 25 => 0x1f,
        _ => 0x0f,
    };
    let word = match within {
        1200..1260 => 0x02,
        1260..1290 => 0x06,
        1290..1300 => 0x07,
        1700..1750 => word | 0x100,
        2000..2020 => 0x00,
        2020..2030 => 0x06,
        2030..2040 => 0x07,
        _ => word,
    };
    if matches!(code, 4 | 10) && tick % 25 == 13 {
        // 5/1000 of the rated torque per degree.
        let torque = (mdeg / 200) as i16;
        return vec![write(0x6071, 0, u32::from(torque as u16), 2)];
    }
    vec![mode(word, code), velocity(word, mdeg), control(word, mdeg)]
}

/// Ticks of [`everything`].
pub const TICKS: u64 = 2450;

/// Everything that takes long, one after the other: settings, saves with and without an erase,
/// defaults, excitations during a capture, uploads in segments and in a block that the client never
/// acknowledges, all with commands at 50 Hz; then a burst of commands at the full bus load, LSS,
/// and resets of communication and node in one call.
pub fn everything(tick: u64) -> Vec<Frame> {
    let excitation = tick.saturating_sub(1000);
    match tick {
        20 => vec![start()],
        60 | 400 => vec![write(0x1010, 1, SAVE, 4)],
        390 => vec![write(0x1017, 0, 500, 2)],
        700 => vec![read(0x1008, 0)],
        710 => vec![read(0x2031, 0)],
        720 => vec![write(0x2030, 3, 1, 1)],
        730 => vec![write(0x2030, 1, 1, 1)],
        1000..2000 => match excitation % 100 {
            0 => vec![write(0x2020, 3, (excitation / 100) as u32, 4)],
            3 => vec![write(0x2020, 1, 1, 1)],
            step if step % 5 == 1 => command(50),
            step if step % 5 == 4 => vec![read(0x6064, 0); 5],
            _ => Vec::new(),
        },
        // A block upload of the capture: 127 segments in one block.
        2010 => vec![upload_block(0x2032)],
        2012 => vec![begin_upload()],
        2100 => vec![control(0x0f, 1_000); 23],
        2101 => [
            vec![sdo([0x40, 0x18, 0x10, 1, 0, 0, 0, 0]); 8],
            vec![control(0x0f, 0); 15],
        ]
        .concat(),
        2150 => vec![
            standard(0x7e5, &[0x04, 1, 0, 0, 0, 0, 0, 0]),
            standard(0x7e5, &[0x17; 8]),
        ],
        2200 => vec![nmt(0x81), nmt(0x82), start()],
        2250 => vec![write(0x1011, 1, LOAD, 4)],
        2251.. => Vec::new(),
        _ if tick > 30 && tick.is_multiple_of(5) => command(tick % 2500),
        _ => Vec::new(),
    }
}

fn upload_block(index: u16) -> Frame {
    let [low, high] = index.to_le_bytes();
    sdo([0xa4, low, high, 0, 127, 0, 0, 0])
}

fn begin_upload() -> Frame {
    sdo([0xa3, 0, 0, 0, 0, 0, 0, 0])
}
