//! The log of the program: defmt over RTT, read by a debugger while the program runs.
//!
//! No control step writes to it, and a frame that would interrupt another one is left out: one lock that nobody waits for
//! is enough, no interrupt is ever masked, and a debugger that does not read costs frames instead of time. The crate
//! defmt-rtt masks interrupts while it writes, waits for the debugger once one is connected, and has a
//! path to a panic.

use core::{
    cell::UnsafeCell,
    sync::atomic::{
        AtomicBool, AtomicU8, AtomicU32,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// Bytes that wait for the debugger; a power of two.
const SIZE: u32 = 512;

/// What a debugger looks for in memory (SEGGER, J-Link user guide UM08001, section RTT).
#[repr(C)]
struct ControlBlock {
    id: [u8; 16],
    up_channels: u32,
    down_channels: u32,
    name: &'static [u8; 6],
    buffer: &'static [AtomicU8; SIZE as usize],
    size: u32,
    written: AtomicU32,
    read: AtomicU32,
    flags: AtomicU32,
}

static BUFFER: [AtomicU8; SIZE as usize] = [const { AtomicU8::new(0) }; SIZE as usize];

/// Mode 0: what does not fit is left out. A debugger may ask for another mode in vain.
#[unsafe(no_mangle)]
static _SEGGER_RTT: ControlBlock = ControlBlock {
    id: *b"SEGGER RTT\0\0\0\0\0\0",
    up_channels: 1,
    down_channels: 0,
    name: b"defmt\0",
    buffer: &BUFFER,
    size: SIZE,
    written: AtomicU32::new(0),
    read: AtomicU32::new(0),
    flags: AtomicU32::new(0),
};

static TAKEN: AtomicBool = AtomicBool::new(false);

/// The frame that is being written.
struct Frame(UnsafeCell<State>);

struct State {
    encoder: defmt::Encoder,
    cursor: Cursor,
    /// Whose it is: nobody's if the log was taken when it began.
    depth: u32,
}

/// How far the frame has come.
struct Cursor {
    /// Where its next byte goes; the debugger sees it when it is whole.
    end: u32,
    /// All of it found a place.
    whole: bool,
}

// SAFETY: whoever has set `TAKEN` alone reaches the state.
unsafe impl Sync for Frame {}

static FRAME: Frame = Frame(UnsafeCell::new(State {
    encoder: defmt::Encoder::new(),
    cursor: Cursor {
        end: 0,
        whole: true,
    },
    depth: 0,
}));

impl Cursor {
    /// Puts bytes there, as far as there is room.
    fn put(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let next = (self.end + 1) % SIZE;
            let place = BUFFER.get(self.end as usize);
            let (Some(place), true) = (place, next != _SEGGER_RTT.read.load(Acquire)) else {
                self.whole = false;
                return;
            };
            place.store(*byte, Relaxed);
            self.end = next;
        }
    }
}

#[defmt::global_logger]
struct Logger;

// SAFETY: `acquire` gives the log to one frame; `write` and `release` of a frame that did not get it,
// because it interrupted another one, do nothing.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // Nested frames are those of an interrupt: they end before the outer one goes on.
        let nested = TAKEN.swap(true, Acquire);
        // SAFETY: see above; a nested frame touches the depth alone.
        let state = unsafe { &mut *FRAME.0.get() };
        if nested {
            state.depth = state.depth.wrapping_add(1);
            return;
        }
        state.cursor = Cursor {
            end: _SEGGER_RTT.written.load(Relaxed),
            whole: true,
        };
        (state.encoder).start_frame(|bytes| state.cursor.put(bytes));
    }

    unsafe fn flush() {}

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: between `acquire` and `release`.
        let state = unsafe { &mut *FRAME.0.get() };
        if state.depth == 0 {
            (state.encoder).write(bytes, |bytes| state.cursor.put(bytes));
        }
    }

    unsafe fn release() {
        // SAFETY: as above.
        let state = unsafe { &mut *FRAME.0.get() };
        if state.depth > 0 {
            state.depth -= 1;
            return;
        }
        (state.encoder).end_frame(|bytes| state.cursor.put(bytes));
        if state.cursor.whole {
            _SEGGER_RTT.written.store(state.cursor.end, Release);
        }
        TAKEN.store(false, Release);
    }
}
