//! A CAN bus by UDP multicast, as the simulator of ArduPilot and pip `dronecan` (`mcast:0`) have
//! it.
//!
//! A datagram is a frame: magic number, CRC of what follows, flags, identifier with bit 31 for 29
//! bits, data; all little endian.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::thread;
use std::time::Duration;

use canopen::CanFrame;
use crc::{CRC_16_IBM_3740, Crc};
use embedded_can::Frame;
use socket2::{Domain, Protocol, Socket, Type};

use super::link::{self, SplitLink, Transmitter};

const MAGIC: [u8; 2] = [0x34, 0x29];
/// CRC-16-CCITT-FALSE.
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

const PORT: u16 = 57732;
const EXTENDED: u32 = 1 << 31;

/// The flag of a CAN FD frame, which has no place on this bus.
const FD: u16 = 1;

/// Length of a datagram without data.
const HEADER: usize = 10;

/// The datagram of a frame.
///
/// ```
/// use canopen::CanFrame;
/// use host_sim::can::multicast::{datagram, frame};
/// let status = CanFrame::raw(0x1801_550A, true, false, 8, *b"\0\0\0\0\0\0\0\xC0").unwrap();
/// let bytes = datagram(&status);
/// assert_eq!((&bytes[..2], &bytes[4..10]), (&[0x34, 0x29][..], &[0, 0, 10, 0x55, 1, 0x98][..]));
/// assert_eq!(frame(&bytes), Some(status));
/// assert_eq!(frame(&bytes[..9]), None);
/// ```
pub fn datagram(frame: &CanFrame) -> Vec<u8> {
    let (id, is_extended) = frame.raw_id();
    let id = if is_extended { id | EXTENDED } else { id };
    let mut body = vec![0, 0];
    body.extend(id.to_le_bytes());
    body.extend(frame.data());
    let sum = CRC.checksum(&body).to_le_bytes();
    [&MAGIC[..], &sum, &body].concat()
}

/// The frame of a datagram, if it is one.
pub fn frame(datagram: &[u8]) -> Option<CanFrame> {
    let (head, data) = datagram.split_at_checked(HEADER)?;
    let [m0, m1, s0, s1, f0, f1, i0, i1, i2, i3] = *head.first_chunk()?;
    let is_valid =
        [m0, m1] == MAGIC && u16::from_le_bytes([s0, s1]) == CRC.checksum(&datagram[4..]);
    if !is_valid || u16::from_le_bytes([f0, f1]) & FD != 0 {
        return None;
    }
    let id = u32::from_le_bytes([i0, i1, i2, i3]);
    let mut bytes = [0; 8];
    bytes.get_mut(..data.len())?.copy_from_slice(data);
    let is_extended = id & EXTENDED != 0;
    CanFrame::raw(
        id & !(0b111 << 29),
        is_extended,
        false,
        data.len() as u8,
        bytes,
    )
}

/// Passes frames between the bus of an slcan server and the multicast group of a bus, in threads of
/// its own, until the server ends.
///
/// # Errors
/// Those of the operating system.
pub fn join(bus: u8, server: &str) -> io::Result<()> {
    let group = Ipv4Addr::new(239, 65, 82, bus);
    let receiver = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    // Several programs of a computer take part.
    receiver.set_reuse_address(true)?;
    receiver.bind(&SocketAddrV4::new(group, PORT).into())?;
    receiver.join_multicast_v4(&group, &Ipv4Addr::UNSPECIFIED)?;
    let sender = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    sender.connect((group, PORT))?;
    let own = sender.local_addr()?;
    let server = server.to_owned();
    thread::spawn(move || -> io::Result<()> {
        // The server accepts as soon as it runs.
        let SplitLink {
            receiver: mut from_bus,
            transmitter: mut to_bus,
        } = link::open_split(&server, 1000)?;
        thread::spawn(move || forward(&receiver.into(), own.port(), to_bus.as_mut()));
        loop {
            if let Some(frame) = from_bus.receive(Duration::from_secs(1))? {
                // Without a network nothing receives it.
                let _ = sender.send(&datagram(&frame));
            }
        }
    });
    Ok(())
}

/// Passes datagrams of others to the bus.
fn forward(group: &UdpSocket, own_port: u16, to_bus: &mut dyn Transmitter) -> io::Result<()> {
    let mut bytes = [0; HEADER + 64];
    loop {
        let (length, from) = group.recv_from(&mut bytes)?;
        if from.port() != own_port
            && let Some(frame) = frame(&bytes[..length])
        {
            to_bus.send(&frame)?;
        }
    }
}
