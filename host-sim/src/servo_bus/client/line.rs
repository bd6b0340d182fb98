//! Bytes and packets.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use serial2::SerialPort;
use servo_bus::{Receiver, dynamixel, feetech};

/// A line: a serial port, or bytes over TCP.
pub(super) trait Line: Read + Write + Send {
    /// Discards the bytes that have arrived.
    fn discard(&mut self) -> io::Result<()>;
}

impl Line for SerialPort {
    fn discard(&mut self) -> io::Result<()> {
        self.discard_input_buffer()
    }
}

impl Line for TcpStream {
    fn discard(&mut self) -> io::Result<()> {
        self.set_nonblocking(true)?;
        // Not without end from a server that never pauses; its errors are those of the next read.
        let mut bytes = [0; 4096];
        for _ in 0..16 {
            if !matches!(self.read(&mut bytes), Ok(1..)) {
                break;
            }
        }
        self.set_nonblocking(false)
    }
}

pub(super) enum Framed {
    Feetech(Box<Receiver<feetech::Framing>>),
    Dynamixel(Box<Receiver<dynamixel::Framing>>),
}

/// What a servo has answered.
pub(super) struct Answered {
    pub id: u8,
    pub error: u8,
    pub data: Vec<u8>,
}

impl Framed {
    /// A byte from the line; the answers that it completes. Adapters with one wire also return what
    /// was sent.
    pub fn push(&mut self, byte: u8, sent: &[u8]) -> Vec<Answered> {
        let mut answers = Vec::new();
        match self {
            Self::Feetech(receiver) => {
                receiver.push(byte);
                while let Some(bytes) = receiver.next_packet() {
                    let packet = feetech::Packet::try_new(bytes).filter(|_| bytes != sent);
                    // Its status is a state of the servo, not a refusal.
                    answers.extend(packet.map(|packet| Answered {
                        id: packet.id(),
                        error: 0,
                        data: packet.parameters().to_vec(),
                    }));
                }
            }
            Self::Dynamixel(receiver) => {
                receiver.push(byte);
                while let Some(bytes) = receiver.next_packet() {
                    let Some(packet) = dynamixel::Packet::try_new(bytes) else {
                        continue;
                    };
                    if let [0x55, error, data @ ..] = &*packet.body() {
                        answers.push(Answered {
                            id: packet.id(),
                            error: *error,
                            data: data.to_vec(),
                        });
                    }
                }
            }
        }
        answers
    }

    /// Discards a part of a packet.
    pub fn discard(&mut self) {
        match self {
            Self::Feetech(receiver) => receiver.discard(),
            Self::Dynamixel(receiver) => receiver.discard(),
        }
    }
}

pub(super) fn is_pause(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

pub(super) fn open(port: &str, bit_s: u32) -> io::Result<Box<dyn Line>> {
    let is_address = port
        .rsplit_once(':')
        .is_some_and(|(_, port)| port.parse::<u16>().is_ok());
    // Short, as the time for an answer is looked at between two reads.
    let timeout = Duration::from_millis(10);
    if is_address {
        let stream = connect(port)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(timeout))?;
        return Ok(Box::new(stream));
    }
    let mut line = SerialPort::open(port, bit_s)?;
    line.set_read_timeout(timeout)?;
    Ok(Box::new(line))
}

/// Longest time for a connection: a computer that is off does not answer.
const CONNECTED: Duration = Duration::from_secs(1);

/// Connects to the first of the addresses of a name that answers.
fn connect(name: &str) -> io::Result<TcpStream> {
    let mut refused = ErrorKind::AddrNotAvailable.into();
    for address in name.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECTED) {
            Ok(stream) => return Ok(stream),
            Err(error) => refused = error,
        }
    }
    Err(refused)
}
