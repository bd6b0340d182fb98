//! One connection: a request and its response, or a WebSocket.

use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use mio::net::TcpStream;
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{
    CloseFrame, Role, WebSocket, WebSocketConfig, frame::coding::CloseCode,
};
use tungstenite::{Bytes, Error};

use super::assets;
use super::guard::{Guard, Route};
use super::response::response;

/// Time for a request and its response.
const PATIENCE: Duration = Duration::from_secs(5);

/// The longest message of a page: a file of parameters.
pub const MESSAGE_BYTES: usize = 1 << 18;

/// Bytes that wait until the page reads.
const UNSENT_BYTES: usize = 1 << 20;

/// Messages of a page that are handled in a turn.
const TURN_MESSAGES: usize = 32;

/// A file that is made for the user.
pub struct Download {
    /// Its name.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Result of the work on a connection.
pub enum Turn {
    /// It continues.
    Goes,
    /// The page has joined.
    Joined,
    /// It has ended, with a reason to report.
    Ended(Option<Reason>),
}

/// Why a connection has ended.
pub enum Reason {
    /// A request was refused.
    Refused(&'static str),
    /// A page was closed.
    Closed(String),
}

enum State {
    /// The bytes of the request.
    Head(Vec<u8>),
    /// The bytes of the response that are not sent.
    Response(Vec<u8>, Option<&'static str>),
    Socket(Box<WebSocket<TcpStream>>),
}

/// One connection.
pub struct Connection {
    /// Address of the other side.
    pub from: String,
    stream: Option<TcpStream>,
    state: State,
    since: Instant,
    /// Whether there may be something to read.
    pub is_readable: bool,
    has_unsent: bool,
    /// Samples lost since the last report to the page.
    pub lost_samples: u64,
}

impl Connection {
    /// A new one.
    pub fn new(stream: TcpStream, from: String) -> Self {
        Self {
            from,
            stream: Some(stream),
            state: State::Head(Vec::new()),
            since: Instant::now(),
            is_readable: true,
            has_unsent: false,
            lost_samples: 0,
        }
    }

    /// Whether it is a page, which has shown the token.
    pub fn is_page(&self) -> bool {
        matches!(self.state, State::Socket(_))
    }

    /// Time since it was accepted.
    pub fn age(&self) -> Duration {
        self.since.elapsed()
    }

    /// Time at which it is closed unless it is a page.
    pub fn deadline(&self) -> Option<Instant> {
        (!self.is_page()).then(|| self.since + PATIENCE)
    }

    /// Handles what has arrived; `receive` gets each message of a page.
    pub fn take_turn(
        &mut self,
        guard: &Guard,
        download: &dyn Fn(&str) -> Option<Download>,
        receive: &mut dyn FnMut(&str),
    ) -> Turn {
        match &mut self.state {
            State::Head(_) => match self.read_head(guard, download) {
                Ok(turn) => turn,
                Err(_) => Turn::Ended(None),
            },
            State::Response(..) => self.respond(),
            State::Socket(_) => self.read_socket(receive),
        }
    }

    fn read_head(
        &mut self,
        guard: &Guard,
        download: &dyn Fn(&str) -> Option<Download>,
    ) -> io::Result<Turn> {
        let (Some(stream), State::Head(head)) = (&mut self.stream, &mut self.state) else {
            return Ok(Turn::Ended(None));
        };
        let mut buffer = [0; 4096];
        loop {
            match stream.read(&mut buffer) {
                Ok(0) => return Ok(Turn::Ended(None)),
                Ok(length) => head.extend_from_slice(&buffer[..length]),
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    self.is_readable = false;
                    return Ok(Turn::Goes);
                }
                Err(error) => return Err(error),
            }
            if let Some(request) = guard.request(head) {
                let rest = head.get(request.length..).unwrap_or_default().to_vec();
                return self.answer(request.route, rest, download);
            }
        }
    }

    fn answer(
        &mut self,
        route: Route,
        rest: Vec<u8>,
        download: &dyn Fn(&str) -> Option<Download>,
    ) -> io::Result<Turn> {
        let mut refusal = None;
        let response = match route {
            Route::Socket(key) => return self.upgrade(&key, rest),
            Route::Page => response(200, assets::PAGE.kind, "", assets::PAGE.text.as_bytes()),
            Route::File(path) => match assets::find(&path) {
                Some(file) => response(200, file.kind, "", file.text.as_bytes()),
                None => response(404, "text/plain", "", b"there is no such file\n"),
            },
            Route::Download(name) => match download(&name) {
                Some(file) => {
                    let disposition = format!(
                        "Content-Disposition: attachment; filename=\"{}\"\r\n",
                        file.name
                    );
                    response(200, "application/octet-stream", &disposition, &file.bytes)
                }
                None => response(404, "text/plain", "", b"the file is no longer there\n"),
            },
            Route::Refused(status, why) => {
                refusal = Some(why);
                response(status, "text/plain", "", format!("{why}\n").as_bytes())
            }
        };
        self.state = State::Response(response, refusal);
        Ok(self.respond())
    }

    fn respond(&mut self) -> Turn {
        let (Some(stream), State::Response(rest, refusal)) = (&mut self.stream, &mut self.state)
        else {
            return Turn::Ended(None);
        };
        self.is_readable = false;
        while !rest.is_empty() {
            match stream.write(rest) {
                Ok(length) if length > 0 => drop(rest.drain(..length)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Turn::Goes,
                Ok(_) | Err(_) => break,
            }
        }
        let _ = stream.shutdown(std::net::Shutdown::Write);
        Turn::Ended(refusal.map(Reason::Refused))
    }

    fn upgrade(&mut self, key: &str, rest: Vec<u8>) -> io::Result<Turn> {
        let Some(mut stream) = self.stream.take() else {
            return Ok(Turn::Ended(None));
        };
        let accept = derive_accept_key(key.as_bytes());
        let head = format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Accept: {accept}\r\n\r\n"
        );
        // It fits into the empty buffer of a new connection.
        stream.write_all(head.as_bytes())?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(MESSAGE_BYTES))
            .max_frame_size(Some(MESSAGE_BYTES))
            .write_buffer_size(0)
            .max_write_buffer_size(UNSENT_BYTES);
        let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
        self.state = State::Socket(Box::new(socket));
        Ok(Turn::Joined)
    }

    fn read_socket(&mut self, receive: &mut dyn FnMut(&str)) -> Turn {
        let State::Socket(socket) = &mut self.state else {
            return Turn::Ended(None);
        };
        for _ in 0..TURN_MESSAGES {
            let why = match socket.read() {
                Ok(tungstenite::Message::Text(text)) => {
                    receive(text.as_str());
                    continue;
                }
                Ok(tungstenite::Message::Binary(_)) => "a binary message".to_owned(),
                Ok(_) => continue,
                Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => {
                    self.is_readable = false;
                    return Turn::Goes;
                }
                Err(Error::ConnectionClosed | Error::AlreadyClosed | Error::Io(_)) => {
                    return Turn::Ended(None);
                }
                Err(Error::Protocol(
                    tungstenite::error::ProtocolError::ResetWithoutClosingHandshake,
                )) => return Turn::Ended(None),
                Err(error) => error.to_string(),
            };
            self.close(CloseCode::Policy, &why);
            return Turn::Ended(Some(Reason::Closed(why)));
        }
        Turn::Goes
    }

    /// Closes a page with a reason that it shows.
    pub fn close(&mut self, code: CloseCode, why: &str) {
        if let State::Socket(socket) = &mut self.state {
            let reason: String = why.chars().take(100).collect();
            // The page may be gone, or not read.
            let _ = socket.close(Some(CloseFrame {
                code,
                reason: reason.into(),
            }));
            let _ = socket.flush();
        }
    }

    /// Sends a text to a page; returns whether it takes it.
    pub fn send_text(&mut self, text: &str) -> bool {
        self.send(tungstenite::Message::text(text))
    }

    /// Sends samples to a page; what it does not take is counted.
    pub fn send_samples(&mut self, number: u64, bytes: &Bytes) {
        if !self.send(tungstenite::Message::Binary(bytes.clone())) {
            self.lost_samples += number;
        }
    }

    fn send(&mut self, message: tungstenite::Message) -> bool {
        let State::Socket(socket) = &mut self.state else {
            return true;
        };
        match socket.write(message) {
            Ok(()) => {}
            Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => {}
            Err(Error::WriteBufferFull(_)) => {
                self.has_unsent = true;
                return false;
            }
            // The next read returns the error.
            Err(_) => self.is_readable = true,
        }
        self.flush();
        true
    }

    /// Sends what waits; returns whether everything is sent.
    pub fn flush(&mut self) -> bool {
        let State::Socket(socket) = &mut self.state else {
            return true;
        };
        self.has_unsent = match socket.flush() {
            Ok(()) => false,
            Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => true,
            Err(_) => {
                self.is_readable = true;
                false
            }
        };
        !self.has_unsent
    }
}
