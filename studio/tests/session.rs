//! Two pages at simulated actuators, over the WebSocket.

mod page;

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::Instant;

use page::{PATIENCE, Page};
use serde_json::json;
use studio::{NativeBus, Options, Studio};

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

/// What the first actuator does.
trait Actuator {
    fn state(&self) -> &str;
    fn enable(&mut self);
    fn angle_mdeg(&mut self) -> i64;
}

impl Actuator for Page {
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
    let mut page = Page::at(&running.url);
    page.enable();
    page.ask("move", json!({ "node": 1, "deg": 20.0 }))
        .expect("it moves");
    let end = Instant::now() + PATIENCE;
    while (page.angle_mdeg() - 20_000).abs() > 1_000 {
        assert!(Instant::now() < end, "the shaft does not arrive");
    }
    assert!(page.rows > 0, "telemetry comes beside the requests");

    let mut other = Page::at(&running.url);
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
    let mut page = Page::at(&running.url);
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
    let mut watcher = Page::at(&running.url);
    // The first run closes the page, the second one its connection.
    for is_closed in [true, false] {
        let mut page = Page::at(&running.url);
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
    let mut page = Page::at(&running.url);
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
    let mut page = Page::at(&running.url);
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
