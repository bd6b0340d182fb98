//! The server, tested by browsers and by invalid clients.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::Mutex;
use std::thread;

use tungstenite::client::IntoClientRequest as _;

use super::*;

type Client = tungstenite::WebSocket<TcpStream>;

/// Takes every JSON object, and notes what happens.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Notes {
    fn note(&self, text: String) {
        self.0.lock().expect("nobody has failed").push(text);
    }

    fn has(&self, text: &str) -> bool {
        let notes = self.0.lock().expect("nobody has failed");
        notes.iter().any(|note| note.starts_with(text))
    }

    fn wait_for(&self, text: &str) {
        let end = Instant::now() + Duration::from_secs(10);
        while !self.has(text) {
            assert!(
                Instant::now() < end,
                "waited without success for `{text}`: {:?}",
                self.0
            );
            thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Application for Notes {
    fn joined(&self, page: PageId) {
        self.note(format!("joined {page}"));
    }

    fn left(&self, page: PageId) {
        self.note(format!("left {page}"));
    }

    fn message(&self, _: PageId, text: &str) {
        self.note(format!("message {text}"));
    }

    fn download(&self, _: &str) -> Option<Download> {
        None
    }
}

/// Runs a server during a test, which gets its address, its token and the way to its pages.
fn with_server(test: impl FnOnce(SocketAddr, &str, &Pages, &Notes, &Mutex<Vec<Notice>>)) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let token = Token::random().expect("random numbers");
    let mut server = Server::new(listener, token.clone()).expect("a server");
    let (address, pages) = (server.address(), server.pages());
    let (notes, stop) = (Notes::default(), AtomicBool::new(false));
    let notices = Mutex::new(Vec::<Notice>::new());
    thread::scope(|scope| {
        scope.spawn(|| {
            let mut notify = |notice: &Notice| {
                notices
                    .lock()
                    .expect("nobody has failed")
                    .push(notice.clone());
            };
            server.run(&notes, &stop, &mut notify).expect("it runs");
        });
        let tested = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            test(address, token.text(), &pages, &notes, &notices);
        }));
        stop.store(true, Relaxed);
        if let Err(failure) = tested {
            std::panic::resume_unwind(failure);
        }
    });
}

fn open(address: SocketAddr, token: &str) -> Client {
    let mut request = format!("ws://{address}/socket?token={token}")
        .into_client_request()
        .expect("an address");
    let origin = format!("http://{address}").parse().expect("a value");
    request.headers_mut().insert("Origin", origin);
    let stream = TcpStream::connect(address).expect("a connection");
    let opened = tungstenite::client(request, stream);
    opened.expect("the server accepts it").0
}

#[test]
fn a_page_is_served_to_those_who_know_the_token() {
    with_server(|address, token, pages, notes, _| {
        let mut stream = TcpStream::connect(address).expect("a connection");
        write!(
            stream,
            "GET /?token={token} HTTP/1.1\r\nHost: {address}\r\n\r\n"
        )
        .expect("sent");
        let mut response = String::new();
        stream.read_to_string(&mut response).expect("a response");
        assert!(response.starts_with("HTTP/1.1 200 OK\r\n"));
        assert!(response.contains("default-src 'none'") && response.contains("<!DOCTYPE html>"));
        let mut page = open(address, token);
        notes.wait_for("joined");
        pages.tell_all(&json!({ "event": "x" }));
        let message = page.read().expect("an event");
        assert_eq!(message.to_text().expect("a text"), r#"{"event":"x"}"#);
        drop(page);
        notes.wait_for("left");
    });
}

#[test]
fn binary_messages_and_those_that_are_too_long_close_their_page_alone() {
    with_server(|address, token, _, notes, notices| {
        let mut good = open(address, token);
        for message in [
            tungstenite::Message::binary(vec![1]),
            tungstenite::Message::text("1".repeat(connection::MESSAGE_BYTES + 1)),
        ] {
            let mut bad = open(address, token);
            // The server may close it before all is sent.
            let _ = bad.send(message);
            let end = loop {
                match bad.read() {
                    Ok(tungstenite::Message::Close(_)) | Err(_) => break true,
                    Ok(_) => {}
                }
            };
            assert!(end);
        }
        good.send(tungstenite::Message::text(r#"{"id":1}"#))
            .expect("sent");
        notes.wait_for(r#"message {"id":1}"#);
        let closed = notices.lock().expect("nobody has failed");
        let closed = closed.iter().filter(|n| matches!(n, Notice::Closed { .. }));
        assert_eq!(closed.count(), 2);
    });
}

#[test]
fn a_thousand_silent_connections_keep_no_page_out() {
    with_server(|address, token, _, notes, _| {
        let mut first = open(address, token);
        let silent: Vec<_> = (0..1000).map(|_| TcpStream::connect(address)).collect();
        let mut second = open(address, token);
        for (page, text) in [(&mut first, r#"{"id":1}"#), (&mut second, r#"{"id":2}"#)] {
            page.send(tungstenite::Message::text(text)).expect("sent");
            notes.wait_for(&format!("message {text}"));
        }
        drop(silent);
    });
}

#[test]
fn requests_among_a_thousand_silent_connections_are_all_answered() {
    with_server(|address, token, _, _, _| {
        thread::scope(|scope| {
            let flood = || -> Vec<_> { (0..250).map(|_| TcpStream::connect(address)).collect() };
            let floods = [(); 4].map(|()| scope.spawn(flood));
            for _ in 0..20 {
                let mut stream = TcpStream::connect(address).expect("a connection");
                // Longer than the turn in which the server accepts it.
                thread::sleep(Duration::from_millis(5));
                write!(
                    stream,
                    "GET /?token={token} HTTP/1.1\r\nHost: {address}\r\n\r\n"
                )
                .expect("sent");
                let mut response = String::new();
                stream.read_to_string(&mut response).expect("a response");
                assert!(response.starts_with("HTTP/1.1 200 OK\r\n"));
            }
            drop(floods.map(|flood| flood.join().expect("it has connected")));
        });
    });
}

#[test]
fn a_page_that_does_not_read_loses_samples_and_gets_their_number() {
    with_server(|address, token, pages, notes, _| {
        let mut slow = open(address, token);
        notes.wait_for("joined");
        // More than its buffers and those of the system hold.
        for _ in 0..400 {
            pages.samples(1, vec![0; 1 << 16]);
            thread::sleep(Duration::from_millis(1));
        }
        let (mut samples, mut dropped) = (0, 0);
        while dropped == 0 {
            match slow.read().expect("it is open") {
                tungstenite::Message::Binary(_) => samples += 1,
                tungstenite::Message::Text(text) => {
                    let event: serde_json::Value = serde_json::from_str(&text).expect("an event");
                    dropped = event["samples"].as_u64().expect("a number");
                }
                _ => {}
            }
        }
        assert_eq!(samples + dropped, 400);
    });
}

#[test]
fn a_page_that_does_not_read_its_answers_is_closed() {
    with_server(|address, token, pages, notes, _| {
        let _slow = open(address, token);
        notes.wait_for("joined");
        let long = "x".repeat(1 << 16);
        for _ in 0..400 {
            pages.tell_all(&json!({ "event": long }));
            thread::sleep(Duration::from_millis(1));
        }
        notes.wait_for("left");
    });
}
