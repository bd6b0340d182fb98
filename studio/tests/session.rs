//! Two pages at simulated actuators, over the WebSocket.

use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use studio::{NativeBus, Options, Studio};
use tungstenite::{Message, WebSocket, client::IntoClientRequest as _};

/// Time for anything, on a loaded computer.
const PATIENCE: Duration = Duration::from_secs(20);

/// A server with its actuators.
struct Running {
    url: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    bus: NativeBus,
}

impl Running {
    fn start() -> Self {
        let bus = NativeBus::start(2, |_| {}).expect("a bus");
        let options = Options {
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            bus: bus.address().to_string(),
            bus_name: "test".into(),
            kbit_s: 1000,
            encoder_switches: bus.encoder_switches(),
        };
        let studio = Studio::open(options, |_| {}).expect("a server");
        let (url, stop) = (studio.url(), Arc::new(AtomicBool::new(false)));
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            studio.run(&flag, &mut |_| {}).expect("it runs");
        });
        Self {
            url,
            stop,
            thread: Some(thread),
            bus,
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A page without a browser.
struct Page {
    socket: WebSocket<TcpStream>,
    next: u64,
    /// Whether it answers.
    is_alive: bool,
    nodes: Value,
    control: Value,
    number: Value,
    rows: u64,
}

impl Page {
    fn open(running: &Running) -> Self {
        Self::at(&running.url)
    }

    fn at(url: &str) -> Self {
        let address = url.trim_start_matches("http://");
        let (host, rest) = address.split_once('/').expect("a path");
        let token = rest.trim_start_matches("?token=");
        let mut request = format!("ws://{host}/socket?token={token}")
            .into_client_request()
            .expect("an address");
        let origin = format!("http://{host}").parse().expect("a value");
        request.headers_mut().insert("Origin", origin);
        let stream = TcpStream::connect(host).expect("a connection");
        stream
            .set_read_timeout(Some(Duration::from_millis(200)))
            .expect("a timeout");
        let socket = tungstenite::client(request, stream)
            .expect("it is accepted")
            .0;
        let mut page = Self {
            socket,
            next: 0,
            is_alive: true,
            nodes: json!([]),
            control: json!(null),
            number: json!(null),
            rows: 0,
        };
        page.until("hello", |page| page.number.is_u64());
        page
    }

    /// Takes a message, if one comes; returns it if it is an answer.
    fn take(&mut self) -> Option<Value> {
        match self.socket.read() {
            Ok(Message::Text(text)) => {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                match message["event"].as_str() {
                    Some("tick") if self.is_alive => self.send(&json!({ "do": "alive" })),
                    Some("hello") => self.number = message["page"].clone(),
                    Some("devices") => self.nodes = message["nodes"].clone(),
                    Some("control") => self.control = message["holder"].clone(),
                    Some(_) => {}
                    None => return Some(message),
                }
            }
            Ok(Message::Binary(_)) => self.rows += 1,
            _ => {}
        }
        None
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        self.socket.send(Message::text(text)).expect("it is open");
    }

    fn until(&mut self, what: &str, is_met: impl Fn(&Self) -> bool) {
        let end = Instant::now() + PATIENCE;
        while !is_met(self) {
            assert!(
                Instant::now() < end,
                "waited without success for {what}: {}",
                self.nodes
            );
            self.take();
        }
    }

    /// The answer to a request.
    fn ask(&mut self, what: &str, mut arguments: Value) -> Result<Value, String> {
        self.next += 1;
        arguments["id"] = self.next.into();
        arguments["do"] = what.into();
        self.send(&arguments);
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "no answer to {what}");
            let Some(answer) = self.take().filter(|answer| answer["id"] == self.next) else {
                continue;
            };
            return match answer["error"].as_str() {
                Some(error) => Err(error.to_owned()),
                None => Ok(answer["ok"].clone()),
            };
        }
    }

    fn state(&self) -> &str {
        self.nodes[0]["state"].as_str().unwrap_or_default()
    }

    /// Waits for both actuators and enables the first.
    fn enable(&mut self) {
        self.until("two actuators", |page| {
            (0..2).all(|node| page.nodes[node]["is_attached"] == true)
        });
        self.ask("enable", json!({ "node": 1 }))
            .expect("it is enabled");
        self.until("the enabled state", |page| {
            page.state() == "operation enabled"
        });
    }

    fn angle_mdeg(&mut self) -> i64 {
        let values = self.ask("read", json!({ "node": 1, "objects": ["6064"] }));
        values.expect("a value")["6064:0"]
            .as_i64()
            .expect("an angle")
    }
}

#[test]
fn a_page_moves_and_stops_an_actuator_and_another_one_must_request_control() {
    let running = Running::start();
    let mut page = Page::open(&running);
    page.enable();
    page.ask("move", json!({ "node": 1, "deg": 20.0 }))
        .expect("it moves");
    let end = Instant::now() + PATIENCE;
    while (page.angle_mdeg() - 20_000).abs() > 1_000 {
        assert!(Instant::now() < end, "the shaft does not arrive");
    }
    assert!(page.rows > 0, "telemetry comes beside the requests");

    let mut other = Page::open(&running);
    let refused = other.ask("move", json!({ "node": 1, "deg": 0.0 }));
    assert!(
        refused
            .unwrap_err()
            .contains("another page has the control")
    );
    other.ask("take_control", json!({})).expect("it may ask");
    page.ask("answer_control", json!({ "give": true }))
        .expect("it gives it");
    let number = other.number.clone();
    other.until("control", |other| other.control == number);
    // Every page may stop, also without control.
    page.ask("stop", json!({})).expect("it stops");
    other.until("the drive to be off", |other| {
        other.state() == "switch on disabled"
    });
    let refused = other.ask("move", json!({ "node": 1, "deg": 0.0 }));
    assert_eq!(refused, Err("the drive is not enabled".into()));
}

#[test]
fn a_torque_is_commanded_in_shares_of_the_rated_one() {
    let running = Running::start();
    let mut page = Page::open(&running);
    page.enable();
    let read = |page: &mut Page, object: &str| {
        let values = page.ask("read", json!({ "node": 1, "objects": [object] }));
        let value = values.expect("a value")[format!("{object}:0")].as_i64();
        value.expect("an integer")
    };
    let rated_nm = read(&mut page, "6076") as f64 * 1e-3;
    for permille in [-250_i64, 10] {
        let nm = rated_nm * permille as f64 * 1e-3;
        page.ask("press", json!({ "node": 1, "nm": nm }))
            .expect("it is commanded");
        assert_eq!(read(&mut page, "6071"), permille);
        assert_eq!(read(&mut page, "6061"), 4, "profile torque");
    }
    for (nm, why) in [
        (rated_nm * 33.0, "expected a torque that 6071h holds"),
        (1e300, "expected a torque"),
    ] {
        let refused = page.ask("press", json!({ "node": 1, "nm": nm }));
        let error = refused.expect_err("no object holds it");
        assert!(error.contains(why), "{error}");
        assert_eq!(read(&mut page, "6071"), 10, "the last one");
    }
}

#[test]
fn the_loss_of_a_page_stops_what_it_moves() {
    let running = Running::start();
    let mut watcher = Page::open(&running);
    // The first run closes the page, the second one its connection.
    for is_closed in [true, false] {
        let mut page = Page::open(&running);
        page.ask("take_control", json!({})).expect("it may ask");
        // Refused if the closed page held the control.
        let _ = watcher.ask("answer_control", json!({ "give": true }));
        let number = page.number.clone();
        page.until("control", |page| page.control == number);
        page.enable();
        let sine = json!({ "3": 7, "4": 10_000, "5": 1_000, "12": 100 });
        page.ask("excite", json!({ "node": 1, "settings": sine }))
            .expect("it runs");
        if is_closed {
            watcher.until("the enabled state", |watcher| {
                watcher.state() == "operation enabled"
            });
            drop(page);
            watcher.until("the drive to be off", |watcher| {
                watcher.state() == "switch on disabled"
            });
        } else {
            // It hangs: it reads, but does not answer.
            page.is_alive = false;
            page.until("the drive to be off", |page| {
                page.state() == "switch on disabled"
            });
        }
    }
}

#[test]
fn two_programs_with_one_node_id_do_not_move_actuators_at_once() {
    let running = Running::start();
    let mut page = Page::open(&running);
    page.enable();
    // Another Studio at the same bus.
    let address = running.bus.address().to_string();
    let options = Options {
        listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
        bus: address.clone(),
        bus_name: "test".into(),
        kbit_s: 1000,
        encoder_switches: Vec::new(),
    };
    let second = Studio::open(options, |_| {}).expect("a server");
    let url = second.url();
    let stop = Arc::<AtomicBool>::default();
    let stopped = Arc::clone(&stop);
    let thread = std::thread::spawn(move || second.run(&stopped, &mut |_| {}).expect("it runs"));
    let mut other = Page::at(&url);
    other.until("the actuator", |page| page.nodes[0]["is_attached"] == true);
    let refused = other.ask("enable", json!({ "node": 1 }));
    let error = refused.expect_err("the first program moves it");
    assert!(
        error.contains("uses the node-ID of this one, 127"),
        "{error}"
    );
    assert_eq!(page.state(), "operation enabled");
    stop.store(true, Relaxed);
    thread.join().expect("it has not failed");
}

#[test]
fn an_actuator_is_left_as_it_was_found() {
    let bus = NativeBus::start(1, |_| {}).expect("a bus");
    let address = bus.address().to_string();
    let read = || {
        let mut client = host_sim::can::client::Client::open(&address, 1000, 1).expect("a bus");
        [
            "1017", "1803:1", "1803:5", "1A03:0", "1A03:1", "1A02:0", "1016:1",
        ]
        .map(|object| client.integer(object).expect(object))
    };
    let before = read();
    let options = Options {
        listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
        bus: address.clone(),
        bus_name: "test".into(),
        kbit_s: 1000,
        encoder_switches: Vec::new(),
    };
    let studio = Studio::open(options, |_| {}).expect("a server");
    let mut running = Running {
        url: studio.url(),
        stop: Arc::default(),
        thread: None,
        bus,
    };
    let stop = Arc::clone(&running.stop);
    running.thread = Some(std::thread::spawn(move || {
        studio.run(&stop, &mut |_| {}).expect("it runs");
    }));
    let mut page = Page::open(&running);
    page.until("the actuator", |page| page.nodes[0]["is_attached"] == true);
    assert_ne!(read(), before, "it is set up");
    page.ask("enable", json!({ "node": 1 }))
        .expect("it is enabled");
    running.stop.store(true, Relaxed);
    running
        .thread
        .take()
        .expect("it runs")
        .join()
        .expect("it has not failed");
    assert_eq!(read(), before);
}
