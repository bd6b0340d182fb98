//! Transports to a CAN bus: slcan over TCP or a serial line, and SocketCAN.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use canopen::CanFrame;
use canopen::slcan::{KBIT_S, SlcanLine, parse_frame};

/// A CAN bus.
pub trait Link {
    /// Sends a frame.
    ///
    /// # Errors
    /// The error of the operating system.
    fn send(&mut self, frame: &CanFrame) -> io::Result<()>;

    /// The next frame, if one arrives within the timeout.
    ///
    /// # Errors
    /// The error of the operating system.
    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>>;

    /// Waits for this time.
    ///
    /// # Errors
    /// The error of the operating system.
    fn pause(&mut self, time: Duration) -> io::Result<()> {
        std::thread::sleep(time);
        Ok(())
    }
}

/// The transmitting direction of a bus, for a separate thread.
pub trait Transmitter: Send {
    /// Sends a frame.
    ///
    /// # Errors
    /// The error of the operating system.
    fn send(&mut self, frame: &CanFrame) -> io::Result<()>;
}

/// A bus whose directions belong to two threads.
pub struct SplitLink {
    /// The thread that receives.
    pub receiver: Box<dyn Link + Send>,
    /// Any other thread.
    pub transmitter: Box<dyn Transmitter>,
}

/// Opens a bus as [`open`] does, with its directions apart.
///
/// # Errors
/// The error of the operating system.
pub fn open_split(name: &str, kbit_s: u16) -> io::Result<SplitLink> {
    match Place::of(name) {
        Place::Tcp(address) => {
            let stream = connect(address)?;
            // A peer that does not read must not delay a stop without end.
            stream.set_write_timeout(Some(Duration::from_secs(1)))?;
            let transmitter = Box::new(SlcanTransmitter(stream.try_clone()?));
            let receiver = Box::new(Slcan::open(stream, kbit_s)?);
            Ok(SplitLink {
                receiver,
                transmitter,
            })
        }
        Place::Serial => {
            let line = Serial::open(name)?;
            let transmitter = Box::new(SlcanTransmitter(Serial(line.0.try_clone()?)));
            let receiver = Box::new(Slcan::open(line, kbit_s)?);
            Ok(SplitLink {
                receiver,
                transmitter,
            })
        }
        #[cfg(target_os = "linux")]
        Place::Interface => {
            let socket = Socket::open(name)?;
            Ok(SplitLink {
                receiver: Box::new(Socket(std::sync::Arc::clone(&socket.0))),
                transmitter: Box::new(socket),
            })
        }
        #[cfg(not(target_os = "linux"))]
        Place::Interface => Err(io::Error::new(
            ErrorKind::Unsupported,
            "this system has no SocketCAN; expected HOST:PORT or a serial device",
        )),
    }
}

/// Where a bus is.
enum Place<'n> {
    /// slcan over TCP at this address.
    Tcp(&'n str),
    /// slcan over a serial line.
    Serial,
    /// A SocketCAN interface.
    Interface,
}

impl<'n> Place<'n> {
    fn of(name: &'n str) -> Self {
        let address = ["tcp://", "socket://"]
            .iter()
            .find_map(|scheme| name.strip_prefix(scheme))
            .unwrap_or(name);
        if let Some((_, port)) = address.rsplit_once(':')
            && port.parse::<u16>().is_ok()
        {
            return Self::Tcp(address);
        }
        if name.contains('/') || name.to_ascii_uppercase().starts_with("COM") {
            return Self::Serial;
        }
        Self::Interface
    }
}

/// Opens a bus by its name: `HOST:PORT` is slcan over TCP, the path of a device (`/dev/ttyACM0`,
/// `COM3`) slcan over a serial line, and any other name (`can0`) a SocketCAN interface.
///
/// # Errors
/// The error of the operating system.
pub fn open(name: &str, kbit_s: u16) -> io::Result<Box<dyn Link>> {
    Ok(open_split(name, kbit_s)?.receiver)
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "no such host");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, Duration::from_secs(3)) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// A stream with a timeout.
pub trait Stream: Read + Write {
    /// Sets the timeout of the reads that follow.
    ///
    /// # Errors
    /// The error of the operating system.
    fn set_timeout(&mut self, timeout: Duration) -> io::Result<()>;
}

impl Stream for TcpStream {
    fn set_timeout(&mut self, timeout: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(timeout))
    }
}

/// A serial line.
struct Serial(serial2::SerialPort);

impl Serial {
    /// The rate of the communication board; USB adapters accept any.
    const BAUD: u32 = 2_000_000;

    fn open(path: &str) -> io::Result<Self> {
        serial2::SerialPort::open(path, Self::BAUD).map(Self)
    }
}

impl Read for Serial {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Write for Serial {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.0.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Stream for Serial {
    fn set_timeout(&mut self, timeout: Duration) -> io::Result<()> {
        self.0.set_read_timeout(timeout)
    }
}

/// An slcan adapter behind a stream.
struct Slcan<S: Stream> {
    stream: S,
    /// Received bytes of an incomplete line.
    partial: Vec<u8>,
}

impl<S: Stream> Slcan<S> {
    fn open(mut stream: S, kbit_s: u16) -> io::Result<Self> {
        let digit = KBIT_S.iter().position(|rate| *rate == kbit_s);
        let digit = digit.ok_or_else(|| {
            let expected =
                format!("{kbit_s} kbit/s is not a bit rate of slcan, expected one of {KBIT_S:?}");
            io::Error::new(ErrorKind::InvalidInput, expected)
        })?;
        // The empty line ends an incomplete command.
        stream.write_all(format!("\rC\rS{digit}\rO\r").as_bytes())?;
        Ok(Self {
            stream,
            partial: Vec::new(),
        })
    }

    /// The next frame among the complete lines.
    fn line(&mut self) -> Option<CanFrame> {
        while let Some(end) = self
            .partial
            .iter()
            .position(|byte| matches!(byte, b'\r' | 7))
        {
            let line: Vec<u8> = self.partial.drain(..=end).collect();
            if let Some(frame) = parse_frame(&line[..end]) {
                return Some(frame);
            }
        }
        None
    }
}

impl<S: Stream> Drop for Slcan<S> {
    fn drop(&mut self) {
        // The adapter may be disconnected already.
        let _ = self.stream.write_all(b"C\r");
    }
}

impl<S: Stream> Link for Slcan<S> {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.stream.write_all(SlcanLine::frame(frame).as_bytes())
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end = Instant::now() + timeout;
        loop {
            if let Some(frame) = self.line() {
                return Ok(Some(frame));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.stream
                .set_timeout(left.max(Duration::from_millis(1)))?;
            let mut buffer = [0; 4096];
            match self.stream.read(&mut buffer) {
                Ok(0) => {
                    return Err(io::Error::new(
                        ErrorKind::UnexpectedEof,
                        "the peer closed the connection",
                    ));
                }
                Ok(length) => self.partial.extend_from_slice(&buffer[..length]),
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                    ) => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// The transmitting direction of an slcan adapter.
struct SlcanTransmitter<W>(W);

impl<W: Write + Send> Transmitter for SlcanTransmitter<W> {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.0.write_all(SlcanLine::frame(frame).as_bytes())
    }
}

/// A SocketCAN interface.
#[cfg(target_os = "linux")]
struct Socket(std::sync::Arc<socketcan::CanSocket>);

#[cfg(target_os = "linux")]
impl Socket {
    fn open(name: &str) -> io::Result<Self> {
        use socketcan::Socket as _;
        let socket = socketcan::CanSocket::open(name)?;
        Ok(Self(std::sync::Arc::new(socket)))
    }
}

#[cfg(target_os = "linux")]
impl Transmitter for Socket {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        Link::send(self, frame)
    }
}

#[cfg(target_os = "linux")]
impl Link for Socket {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        use embedded_can::Frame as _;
        use socketcan::Socket as _;
        let sent = if frame.is_remote_frame() {
            socketcan::CanFrame::new_remote(frame.id(), frame.dlc())
        } else {
            socketcan::CanFrame::new(frame.id(), frame.data())
        };
        self.0.write_frame(&sent.ok_or(ErrorKind::InvalidData)?)
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        use embedded_can::Frame as _;
        use socketcan::Socket as _;
        self.0
            .set_read_timeout(timeout.max(Duration::from_millis(1)))?;
        match self.0.read_frame() {
            Ok(frame) if frame.is_remote_frame() => {
                Ok(CanFrame::new_remote(frame.id(), frame.dlc()))
            }
            Ok(frame) => Ok(CanFrame::new(frame.id(), frame.data())),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}
