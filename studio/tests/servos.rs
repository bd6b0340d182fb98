//! Pages at simulated servos. What the servos do is judged by a client of its own.

mod page;

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use host_sim::servo_bus::client::{Client, Device};
use host_sim::servo_bus::{Bus, Fault, OfServo, Server, model};
use page::{PATIENCE, Page};
use serde_json::{Value, json};
use studio::{Options, Studio};

/// Time from a stop to a shaft at rest: some samples of the bus, the deceleration, and as much for
/// a computer that is busy.
const AT_REST: Duration = Duration::from_millis(800);

/// Time in which a page does not answer until it counts as silent.
const SILENCE: Duration = Duration::from_millis(700);

/// Speed of a motion that lasts longer than a test, steps/s.
const SLOW: i32 = 300;

/// A thread that ends with its flag.
struct Running {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    fn start(run: impl FnOnce(&AtomicBool) + Send + 'static) -> Self {
        let stop = Arc::<AtomicBool>::default();
        let flag = Arc::clone(&stop);
        let thread = Some(thread::spawn(move || run(&flag)));
        Self { stop, thread }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(thread::panicking() || ended.is_some_and(|it| it.is_ok()));
    }
}

/// A Studio, a client of its own, and the servos; they end in this order.
struct Bench {
    url: String,
    studio: Option<Running>,
    client: Client,
    faults: Sender<Fault>,
    _servos: Running,
    protocol: &'static str,
}

impl Bench {
    fn start(protocol: &'static str, name: &str, count: u8) -> Self {
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let listener = TcpListener::bind(any).expect("a port");
        listener.set_nonblocking(true).expect("it takes no time");
        let address = listener.local_addr().expect("an address");
        let bus = Bus::new(&model(name).expect("a model"), count, 0.0).expect("servos");
        let (faults, taken) = mpsc::channel();
        let servos = Running::start(move |stop| {
            let server = Server::new(bus, 1_000_000).expect("a server");
            server.run(Some(listener), &taken, stop).expect("it runs");
        });
        let bus = format!("{protocol}:{address}");
        let options = Options {
            listen: any,
            bus: bus.clone(),
            bus_name: bus.clone(),
            kbit_s: 1000,
            encoder_switches: Vec::new(),
        };
        let studio = Studio::open(options, |_| {}).expect("a server");
        let url = studio.url();
        let studio = Running::start(move |stop| studio.run(stop, &mut |_| {}).expect("it runs"));
        Self {
            url,
            studio: Some(studio),
            client: Client::open(&bus).expect("a bus"),
            faults,
            _servos: servos,
            protocol,
        }
    }

    fn device(&mut self, id: u8) -> Device {
        let table = self.client.table(id).expect("a table");
        Device { id, table }
    }

    fn read(&mut self, id: u8, name: &'static str) -> i32 {
        let device = self.device(id);
        device.read(&mut self.client, name).expect(name)
    }

    /// Waits until the shaft turns, without the page.
    fn turns(&mut self, id: u8, page: &mut Page) {
        let (end, from) = (Instant::now() + PATIENCE, self.read(id, "present_position"));
        while (self.read(id, "present_position") - from).abs() < 100 {
            assert!(Instant::now() < end, "servo {id} does not turn");
            page.take();
        }
    }

    /// The position in which the shaft has been at rest for a while, and the time until it was. A
    /// page does not answer meanwhile.
    fn rests(&mut self, id: u8) -> (i32, Duration) {
        const WHILE: Duration = Duration::from_millis(250);
        let start = Instant::now();
        let (mut position, mut since) = (self.read(id, "present_position"), start);
        while since.elapsed() < WHILE {
            assert!(start.elapsed() < PATIENCE, "servo {id} does not rest");
            let now = self.read(id, "present_position");
            if (now - position).abs() > 1 {
                (position, since) = (now, Instant::now());
            }
        }
        (position, since - start)
    }

    /// Checks that a motion has ended in time, and that the servo holds the angle.
    fn is_halted(&mut self, id: u8, what: &str, within: Duration) {
        let (position, after) = self.rests(id);
        assert!(after < within, "{what}: {after:?}");
        // A goal of where it was, and the deceleration: 1 deg.
        assert!((self.read(id, "goal_position") - position).abs() < 12);
        assert_eq!(self.read(id, "torque_enable"), 1, "an arm does not fall");
    }

    /// A page that knows this many servos.
    fn page(&self, count: usize) -> Page {
        let mut page = Page::at(&self.url);
        page.until("the servos", |page| {
            page.nodes
                .as_array()
                .is_some_and(|nodes| nodes.len() == count)
        });
        page
    }

    /// Enables a servo and begins a slow motion.
    fn begin(&mut self, id: u8, page: &mut Page) {
        let (speed, slow) = match self.protocol {
            "sts" => ("goal_velocity", SLOW),
            _ => ("profile_velocity", SLOW / 16),
        };
        let device = self.device(id);
        device.write(&mut self.client, speed, slow).expect(speed);
        // A page before it may not be gone yet.
        page.ask("take_control", json!({})).expect("it may ask");
        page.until("control", |page| page.control == page.number);
        page.ask("enable", json!({ "node": id }))
            .expect("it is enabled");
        let is_ahead = self.read(id, "present_position") > 2048;
        let deg = if is_ahead { -170.0 } else { 170.0 };
        page.ask("move", json!({ "node": id, "deg": deg }))
            .expect("it moves");
        self.turns(id, page);
    }
}

fn node(page: &Page, id: u8) -> &Value {
    let nodes = page.nodes.as_array().expect("a list");
    let found = nodes.iter().find(|node| node["node"] == id);
    found.expect("a node")
}

#[test]
fn six_servos_are_found_sampled_moved_and_stopped_by_any_page() {
    let mut bench = Bench::start("sts", "sts3215", 6);
    let mut page = bench.page(6);
    assert_eq!(node(&page, 6)["name"], "sts3215");
    page.until("samples", |page| page.samples.len() == 6);
    // After the scan.
    page.until("the end of the scan", |page| page.ended_task == Some(0));
    let (before, start) = (page.samples.clone(), Instant::now());
    while start.elapsed() < Duration::from_secs(2) {
        page.take();
    }
    let seconds = start.elapsed().as_secs_f64();
    for (id, (count, _)) in &page.samples {
        let rate_hz = (count - before[id].0) as f64 / seconds;
        assert!(rate_hz > 50.0, "servo {id}: {rate_hz} Hz");
    }
    let supply_v = page.last(1, "supply");
    assert!((supply_v - 7.4).abs() < 0.2, "{supply_v} V");

    let refused = page.ask("move", json!({ "node": 2, "deg": 20.0 }));
    assert_eq!(refused, Err("the servo is not enabled".into()));
    page.ask("enable", json!({ "node": 2 }))
        .expect("it is enabled");
    page.ask("move", json!({ "node": 2, "deg": 45.0 }))
        .expect("it moves");
    page.until("the goal", |page| {
        (page.last(2, "angle") - 45.0).abs() < 1.0 && page.last(2, "rate") == 0.0
    });
    assert!((bench.read(2, "present_position") - 2048 - 512).abs() < 12);
    let refused = page.ask("move", json!({ "node": 2, "deg": 181.0 }));
    assert_eq!(
        refused,
        Err("the goal is 181 deg, expected -180 to 179.91 deg".into())
    );

    bench.begin(2, &mut page);
    let mut other = bench.page(6);
    let refused = other.ask("move", json!({ "node": 2, "deg": 0.0 }));
    let error = refused.expect_err("another page has the control");
    assert!(error.contains("another page has the control"), "{error}");
    other.ask("stop", json!({})).expect("every page may");
    bench.is_halted(2, "a stop", AT_REST);
    assert_eq!(bench.read(1, "torque_enable"), 0, "it is off");
    let refused = page.ask("move", json!({ "node": 2, "deg": 20.0 }));
    assert_eq!(refused, Err("the servo is not enabled".into()));
    page.ask("disable", json!({ "node": 2 }))
        .expect("it is released");
    assert_eq!(bench.read(2, "torque_enable"), 0);
}

#[test]
fn the_loss_of_a_page_and_the_end_of_the_server_stop_what_was_moved() {
    for (protocol, name) in [("sts", "sts3215"), ("dxl", "xl330-m288")] {
        let mut bench = Bench::start(protocol, name, 2);
        // It hangs: it reads, but does not answer.
        let mut page = bench.page(2);
        bench.begin(2, &mut page);
        page.is_alive = false;
        bench.is_halted(2, "hangs", SILENCE + AT_REST);
        drop(page);
        let mut page = bench.page(2);
        bench.begin(2, &mut page);
        drop(page);
        bench.is_halted(2, "closed", AT_REST);
        let mut page = bench.page(2);
        bench.begin(2, &mut page);
        if protocol == "dxl" {
            assert_eq!(bench.read(2, "bus_watchdog"), 25, "of 20 ms");
        }
        bench.studio = None;
        bench.is_halted(2, "the server ends", AT_REST);
        if protocol == "dxl" {
            assert_eq!(bench.read(2, "bus_watchdog"), 0);
        }
    }
}

#[test]
fn a_servo_that_vanishes_is_missing_and_is_stopped_when_it_returns() {
    let mut bench = Bench::start("sts", "sts3215", 3);
    let mut page = bench.page(3);
    // A missing servo is probed behind it.
    page.until("the end of the scan", |page| page.ended_task == Some(0));
    bench.begin(3, &mut page);
    let fault = |bench: &Bench, is_absent| {
        let fault = Fault::Of(3, OfServo::Absent(is_absent));
        bench.faults.send(fault).expect("the servos run");
    };
    fault(&bench, true);
    page.until("its absence", |page| node(page, 3)["is_lost"] == true);
    let refused = page.ask("move", json!({ "node": 3, "deg": 0.0 }));
    assert_eq!(refused, Err("servo 3 does not answer".into()));
    let (count, _) = page.samples[&1];
    page.until("samples of the others", |page| {
        page.samples[&1].0 > count + 20
    });
    fault(&bench, false);
    page.until("its return", |page| node(page, 3)["is_lost"] == false);
    bench.is_halted(3, "a stop", AT_REST);
    page.until("the end of its motion", |page| {
        node(page, 3)["is_enabled"] == false
    });
}

#[test]
fn a_stop_ends_the_motion_of_another_program_and_of_a_servo_that_does_not_answer_writes() {
    for (protocol, name, level) in [
        ("sts", "sts3215", ("response_level", 0)),
        ("dxl", "xl330-m288", ("status_return_level", 1)),
    ] {
        let mut bench = Bench::start(protocol, name, 2);
        let mut page = bench.page(2);
        bench.begin(2, &mut page);
        let device = bench.device(2);
        let (silent, value) = level;
        // It is the answer that it does not give any more.
        let _ = device.write(&mut bench.client, silent, value);
        assert_eq!(bench.read(2, silent), value);
        page.ask("stop", json!({})).expect("every page may");
        bench.is_halted(2, "a stop", AT_REST);
        page.until("the end of the stop", |page| {
            node(page, 2)["is_enabled"] == false && node(page, 2)["is_stopping"] == false
        });
        let refused = page.ask("enable", json!({ "node": 2 }));
        let error = refused.expect_err("it does not acknowledge a stop");
        assert!(error.contains(silent), "{error}");
        // Of the other servo Studio does not know yet that its torque is on.
        let device = bench.device(1);
        let mut write = |name, value| device.write(&mut bench.client, name, value).expect(name);
        if protocol == "sts" {
            write("goal_velocity", SLOW);
            write("goal_position", 4000);
        } else {
            write("profile_velocity", SLOW / 16);
            write("torque_enable", 1);
            write("goal_position", 4000);
        }
        page.ask("stop", json!({})).expect("every page may");
        bench.is_halted(1, "a stop", AT_REST);
    }
}

#[test]
fn a_stop_refuses_what_was_requested_before_it() {
    let bench = Bench::start("sts", "sts3215", 1);
    // During the scan a request waits for the answer of an ID.
    let mut page = bench.page(1);
    for number in 0..5 {
        page.send(&json!({ "do": "enable", "node": 1, "id": 1000 + number }));
        page.ask("stop", json!({})).expect("every page may");
        let count = page.samples.get(&1).map_or(0, |(count, _)| *count);
        page.until("samples behind both", |page| {
            page.samples
                .get(&1)
                .is_some_and(|(now, _)| *now > count + 10)
        });
        page.until("the end of the stop", |page| {
            node(page, 1)["is_stopping"] == false
        });
        assert_eq!(node(&page, 1)["is_enabled"], false);
    }
}

#[test]
fn a_stop_does_not_drive_a_braked_servo() {
    let mut bench = Bench::start("sts", "sts3215", 1);
    let mut page = bench.page(1);
    let device = bench.device(1);
    let written = device.write(&mut bench.client, "torque_enable", 2);
    written.expect("it is taken");
    page.ask("stop", json!({})).expect("every page may");
    page.until("the end of the stop", |page| {
        node(page, 1)["is_stopping"] == false
    });
    assert_eq!(bench.read(1, "torque_enable"), 2);
}

#[test]
fn registers_are_written_by_name_and_refused_with_the_reason() {
    let mut bench = Bench::start("dxl", "xl330-m288", 2);
    let mut page = bench.page(2);
    let all = page.ask("read_all", json!({ "node": 1 })).expect("values");
    let registers = all["registers"].as_array().expect("a list").clone();
    let of = |name: &str| {
        registers
            .iter()
            .find(|it| it["name"] == name)
            .expect("a register")
            .clone()
    };
    assert_eq!(of("id")["value"], 1);
    assert_eq!(of("position_p_gain")["value"], 400);
    assert_eq!(
        of("present_input_voltage")["value"],
        bench.read(1, "present_input_voltage")
    );
    let mut write = |name: &str, value: &str| {
        page.ask(
            "write",
            json!({ "node": 1, "object": name, "value": value }),
        )
    };
    assert_eq!(
        write("position_p_gain", "800").expect("it is taken")["value"],
        800
    );
    assert_eq!(
        write("max_position_limit", "3000").expect("it is taken")["value"],
        3000
    );
    for (name, value, why) in [
        (
            "position_p_gain",
            "99999",
            "position_p_gain is 99999, expected 0 to 16383",
        ),
        ("present_position", "1", "present_position is read only"),
        ("goal_position", "2100", "the servo is not enabled"),
        ("id", "2", "there is a servo 2 already"),
        ("operating_mode", "2", "value out of range"),
    ] {
        let error = write(name, value).expect_err(name);
        assert!(error.contains(why), "{error}");
    }
    assert_eq!(bench.read(1, "max_position_limit"), 3000);
    page.until("its limit", |page| {
        node(page, 1)["limits_deg"][1]
            .as_f64()
            .is_some_and(|deg| (deg - 83.672).abs() < 0.01)
    });
    // A goal of before is not followed.
    let (device, before) = (bench.device(1), bench.read(1, "present_position"));
    let written = device.write(&mut bench.client, "goal_position", before + 500);
    written.expect("it is taken");
    page.ask("enable", json!({ "node": 1 }))
        .expect("it is enabled");
    assert!((bench.rests(1).0 - before).abs() < 10);
    let refused = page.ask(
        "write",
        json!({ "node": 1, "object": "operating_mode", "value": "4" }),
    );
    let error = refused.expect_err("it would move the shaft");
    assert_eq!(error, "operating_mode: the torque is on, turn it off first");
    let refused = page.ask(
        "write",
        json!({ "node": 1, "object": "bus_watchdog", "value": "0" }),
    );
    assert!(refused.is_err(), "it stops the servo without Studio");
    page.ask("disable", json!({ "node": 1 }))
        .expect("it is released");
    // A new ID.
    page.ask("write", json!({ "node": 1, "object": "id", "value": "9" }))
        .expect("it is taken");
    page.until("the new ID", |page| page.nodes[1]["node"] == 9);
    page.until("its samples", |page| page.samples.contains_key(&9));
    assert_eq!(bench.read(9, "id"), 9);
}
