//! CANopen frames to and from the board, which is node 1.

pub use canopen::CanFrame as Frame;
use embedded_can::StandardId;
use virtual_board::can::{self, Outcome};
use virtual_board::run::Finished;

/// "save", the signature that 1010h expects.
pub const SAVE: u32 = u32::from_le_bytes(*b"save");

/// "load", the signature that 1011h expects.
pub const LOAD: u32 = u32::from_le_bytes(*b"load");

/// A data frame with an identifier of 11 bits.
///
/// # Panics
/// If the identifier has more, or there are more than 8 bytes.
pub fn standard(id: u16, data: &[u8]) -> Frame {
    let id = StandardId::new(id).expect("11 bits");
    embedded_can::Frame::new(id, data).expect("at most 8 bytes")
}

/// The frame as the emulated bus carries it.
pub fn to_wire(frame: &Frame) -> can::Frame {
    let id = match frame.raw_id() {
        (id, true) => can::Id::Extended(id),
        (id, false) => can::Id::Standard(id as u16),
    };
    can::Frame::data_frame(id, embedded_can::Frame::data(frame))
}

/// A frame with an identifier of 11 bits from the emulated bus.
///
/// # Panics
/// As [`standard`].
pub fn from_wire(frame: &can::Frame) -> Frame {
    standard(frame.id.value() as u16, frame.payload())
}

/// An NMT command to the node.
pub fn nmt(command: u8) -> Frame {
    standard(0, &[command, 1])
}

/// The node's start.
pub fn start() -> Frame {
    nmt(1)
}

/// RPDO 3: controlword and target position, mdeg.
pub fn control(controlword: u16, mdeg: i32) -> Frame {
    let [a, b] = controlword.to_le_bytes();
    let [c, d, e, f] = mdeg.to_le_bytes();
    standard(0x401, &[a, b, c, d, e, f])
}

/// RPDO 2: controlword and mode of operation.
pub fn mode(controlword: u16, mode: i8) -> Frame {
    let [a, b] = controlword.to_le_bytes();
    standard(0x301, &[a, b, mode as u8])
}

/// RPDO 4: controlword and target velocity, mdeg/s.
pub fn velocity(controlword: u16, mdeg_s: i32) -> Frame {
    let [a, b] = controlword.to_le_bytes();
    let [c, d, e, f] = mdeg_s.to_le_bytes();
    standard(0x501, &[a, b, c, d, e, f])
}

/// An SDO request.
pub fn sdo(bytes: [u8; 8]) -> Frame {
    standard(0x601, &bytes)
}

/// An SDO request that writes `size` bytes.
pub fn write(index: u16, sub: u8, value: u32, size: u8) -> Frame {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    let command = 0x23 | (4 - size.min(4)) << 2;
    sdo([command, low, high, sub, a, b, c, d])
}

/// An SDO request that writes a REAL32.
pub fn write_real(index: u16, sub: u8, value: f32) -> Frame {
    write(index, sub, value.to_bits(), 4)
}

/// An SDO request that reads.
pub fn read(index: u16, sub: u8) -> Frame {
    let [low, high] = index.to_le_bytes();
    sdo([0x40, low, high, sub, 0, 0, 0, 0])
}

/// The SDO client's abort of the transfer of this object.
pub fn abort(index: u16, sub: u8) -> Frame {
    let [low, high] = index.to_le_bytes();
    sdo([0x80, low, high, sub, 0, 0, 0, 0x08])
}

/// A frame that the board sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// Its end, ns.
    pub at_ns: u64,
    /// The frame.
    pub frame: Frame,
}

/// Every frame of the board that was delivered.
pub fn sent<S>(finished: &Finished<S>) -> Vec<Sent> {
    let frames = finished.trace.frames.iter();
    let delivered = frames.filter(|sent| sent.sender == 0 && sent.outcome == Outcome::Delivered);
    delivered
        .map(|sent| Sent {
            at_ns: sent.at_ns,
            frame: from_wire(&sent.frame),
        })
        .collect()
}

/// The frames of the board with this identifier: their ends, ns, and their bytes.
pub fn with_id<S>(finished: &Finished<S>, id: u32) -> impl Iterator<Item = (u64, [u8; 8])> {
    let sent = sent(finished).into_iter();
    sent.filter(move |sent| sent.frame.raw_id() == (id, false))
        .map(|sent| (sent.at_ns, sent.frame.bytes()))
}

/// Statuswords, TPDO 2, with the ends of their frames, ns.
pub fn statuswords<S>(finished: &Finished<S>) -> Vec<(u64, u16)> {
    let word = |(at_ns, [.., a, b]): (u64, [u8; 8])| (at_ns, u16::from_le_bytes([a, b]));
    with_id(finished, 0x281).map(word).collect()
}

/// Angles, TPDO 1, in 0.01 deg, with the ends of their frames, ns.
pub fn angles_cdeg<S>(finished: &Finished<S>) -> Vec<(u64, i16)> {
    let angle = |(at_ns, [a, b, ..]): (u64, [u8; 8])| (at_ns, i16::from_le_bytes([a, b]));
    with_id(finished, 0x181).map(angle).collect()
}

/// Responses of the SDO server.
pub fn responses<S>(finished: &Finished<S>) -> Vec<[u8; 8]> {
    with_id(finished, 0x581).map(|(_, bytes)| bytes).collect()
}

/// EMCY frames report the drive's faults with this value plus the fault's number as instance.
const DRIVE_FAULTS: u8 = 0x80;

/// The number of the fault of the drive that a frame reports as EMCY.
pub fn fault(frame: &Frame) -> Option<u8> {
    let [code, class, _, instance, ..] = frame.bytes();
    let is_raised = frame.raw_id() == (0x081, false) && (code, class) != (0, 0);
    instance.checked_sub(DRIVE_FAULTS).filter(|_| is_raised)
}

/// Faults of the drive as EMCY reports them: the ends of the frames, ns, and the fault's number.
pub fn faults<S>(finished: &Finished<S>) -> Vec<(u64, u8)> {
    let sent = sent(finished).into_iter();
    sent.filter_map(|sent| Some((sent.at_ns, fault(&sent.frame)?)))
        .collect()
}

/// Whether a statusword is that of OPERATION ENABLED (CiA 402, table 30).
pub fn is_operation_enabled(statusword: u16) -> bool {
    statusword & 0x6f == 0x27
}

/// Whether a statusword is that of SWITCH ON DISABLED.
pub fn is_switch_on_disabled(statusword: u16) -> bool {
    statusword & 0x4f == 0x40
}

/// Whether a statusword is that of FAULT.
pub fn is_fault(statusword: u16) -> bool {
    statusword & 0x4f == 0x08
}
