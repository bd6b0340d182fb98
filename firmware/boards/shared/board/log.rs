//! Log: defmt over RTT, read by a debugger while the program runs.
//!
//! The control step does not log, and a frame that would interrupt another one is discarded. A
//! single lock without waiting is sufficient, no interrupt is masked, and if the debugger does not
//! read, frames are lost instead of time. The crate defmt-rtt masks interrupts while it writes,
//! waits for a connected debugger, and has a path to a panic.

use core::{
    cell::UnsafeCell,
    sync::atomic::{
        AtomicBool, AtomicU8, AtomicU32,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// Size of the buffer, bytes; a power of two.
const SIZE: u32 = 512;

/// The structure that a debugger searches for in memory (SEGGER, J-Link user guide UM08001, section
/// RTT).
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

/// Mode 0: frames that do not fit are discarded. Other modes that a debugger sets have no effect.
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

/// Whether a frame is being written.
static IS_LOCKED: AtomicBool = AtomicBool::new(false);

/// Frames that interrupt the frame being written; they are discarded.
static NESTED_FRAMES: AtomicU32 = AtomicU32::new(0);

/// The frame that is being written.
struct Frame(UnsafeCell<FrameState>);

struct FrameState {
    encoder: defmt::Encoder,
    cursor: Cursor,
}

/// Write position.
struct Cursor {
    /// Index of the next byte; the debugger sees the frame when it is complete.
    end: u32,
    /// Whether all bytes of the frame have fitted.
    is_complete: bool,
}

// SAFETY: only the context that has set `IS_LOCKED` accesses the state, until it clears the lock.
// Contexts that interrupt it count nested frames and access nothing else.
unsafe impl Sync for Frame {}

static FRAME: Frame = Frame(UnsafeCell::new(FrameState {
    encoder: defmt::Encoder::new(),
    cursor: Cursor {
        end: 0,
        is_complete: true,
    },
}));

impl Cursor {
    /// Appends bytes while there is space.
    fn append(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let next = (self.end + 1) % SIZE;
            let element = BUFFER.get(self.end as usize);
            let (Some(element), true) = (element, next != _SEGGER_RTT.read.load(Acquire)) else {
                self.is_complete = false;
                return;
            };
            element.store(*byte, Relaxed);
            self.end = next;
        }
    }
}

#[defmt::global_logger]
struct Logger;

// SAFETY: `acquire` locks the log for one frame; `acquire`, `write` and `release` of a frame that
// interrupts it count nested frames only.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // A nested frame is that of an interrupt, which ends before the outer frame continues.
        if IS_LOCKED.swap(true, Acquire) {
            NESTED_FRAMES.fetch_add(1, Relaxed);
            return;
        }
        // SAFETY: this context has just set the lock.
        let frame = unsafe { &mut *FRAME.0.get() };
        frame.cursor = Cursor {
            end: _SEGGER_RTT.written.load(Relaxed),
            is_complete: true,
        };
        frame
            .encoder
            .start_frame(|bytes| frame.cursor.append(bytes));
    }

    unsafe fn flush() {}

    unsafe fn write(bytes: &[u8]) {
        if NESTED_FRAMES.load(Relaxed) == 0 {
            // SAFETY: without nested frames, this context has set the lock in `acquire`.
            let frame = unsafe { &mut *FRAME.0.get() };
            frame
                .encoder
                .write(bytes, |bytes| frame.cursor.append(bytes));
        }
    }

    unsafe fn release() {
        if NESTED_FRAMES.load(Relaxed) > 0 {
            NESTED_FRAMES.fetch_sub(1, Relaxed);
            return;
        }
        // SAFETY: as in `write`.
        let frame = unsafe { &mut *FRAME.0.get() };
        frame.encoder.end_frame(|bytes| frame.cursor.append(bytes));
        if frame.cursor.is_complete {
            _SEGGER_RTT.written.store(frame.cursor.end, Release);
        }
        IS_LOCKED.store(false, Release);
    }
}
