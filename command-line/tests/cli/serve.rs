//! The server with clients that misbehave.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread;
use std::time::Duration;

use crate::served::Served;

/// Most memory of the server, kB.
const MEMORY_KB: u64 = 64 * 1024;

/// Control period, us.
const PERIOD_US: u64 = 4000;

fn connect(served: &Served) -> TcpStream {
    let stream = TcpStream::connect(&served.bus).expect("a connection");
    // Nothing takes so long; a lost answer fails the test instead of stopping it.
    let timeout = Some(Duration::from_secs(10));
    stream.set_read_timeout(timeout).expect("a timeout");
    stream
}

/// Whether the server answers on this connection.
fn is_served(mut stream: &TcpStream) -> bool {
    let mut answer = [0; 6];
    stream.write_all(b"V\r").is_ok()
        && stream.read_exact(&mut answer).is_ok()
        && answer == *b"V1013\r"
}

/// Sends the same text again and again, and reads what comes if `reads`.
fn flood(stream: TcpStream, text: &[u8], reads: bool, stop: &AtomicBool) {
    let mut reader = stream.try_clone().expect("a second handle");
    let mut writer = &stream;
    thread::scope(|scope| {
        if reads {
            scope.spawn(move || {
                let mut buffer = [0; 1 << 16];
                while reader.read(&mut buffer).is_ok_and(|length| length > 0) {}
            });
        }
        let timeout = Some(Duration::from_millis(100));
        stream.set_write_timeout(timeout).expect("a timeout");
        let texts = text.repeat(1000);
        while !stop.load(Relaxed) {
            // A full connection is no failure.
            let _ = writer.write(&texts);
        }
        // Ends the reader. The server may have closed it before.
        let _ = stream.shutdown(Shutdown::Both);
    });
}

/// Times of the process data 1 of a node for three seconds of the server's time, us.
fn times_us(lines: &mut impl BufRead, node: u8) -> Vec<u64> {
    let start = format!("t18{node}");
    let mut times: Vec<u64> = Vec::new();
    let mut line = Vec::new();
    while times.last().is_none_or(|last| last - times[0] < 3_000_000) {
        line.clear();
        lines.read_until(b'\r', &mut line).expect("a line");
        let text = String::from_utf8_lossy(&line);
        if let Some(rest) = text.trim_end().strip_prefix(&start) {
            let time = rest.get(rest.len() - 8..).expect("a time");
            times.push(u64::from_str_radix(time, 16).expect("a time"));
        }
    }
    times
}

/// Peak of the server's memory, kB.
fn memory_kb(served: &Served) -> u64 {
    let path = format!("/proc/{}/status", served.process.id());
    let status = std::fs::read_to_string(path).expect("a status");
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let words = line.expect("a peak").split_whitespace().nth(1);
    words.expect("a number").parse().expect("a number")
}

#[test]
fn eight_floods_at_once_delay_no_actuator_and_take_no_memory() {
    let served = Served::new(&["--nodes", "2"]);
    let sdo = b"t60184041600000000000\r";
    let nonsense = [b'x'; 100];
    // Frames without a receiver, requests that are answered, a command with an answer three times
    // as long, and a line without end: each by a client that reads and by one that does not.
    let texts: [&[u8]; 4] = [b"t70181122334455667788\r", sdo, b"V\r", &nonsense];
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        for (text, reads) in texts.iter().flat_map(|text| [(text, true), (text, false)]) {
            let mut stream = connect(&served);
            stream.write_all(b"O\r").expect("it is open");
            let stop = &stop;
            scope.spawn(move || flood(stream, text, reads, stop));
        }
        let mut client = connect(&served);
        // Times in microseconds, and all nodes operational.
        client.write_all(b"Z2\rO\rt00020100\r").expect("it is open");
        let mut lines = BufReader::new(client);
        let times = times_us(&mut lines, 1);
        stop.store(true, Relaxed);
        let periods = (times[times.len() - 1] - times[0]) as f64 / PERIOD_US as f64;
        let rate = (times.len() - 1) as f64 / periods;
        assert!((rate - 1.0).abs() < 0.02, "{rate} of 250 Hz");
    });
    let memory_kb = memory_kb(&served);
    assert!(memory_kb < MEMORY_KB, "{memory_kb} kB");
    let notices = served.cli.read("notices");
    for part in ["sends more frames than the bus carries", "does not read"] {
        assert!(notices.contains(part), "{notices}");
    }
    assert!(!notices.contains("late"), "{notices}");
}

#[test]
fn the_losses_of_a_client_that_does_not_read_are_reported_to_it() {
    let served = Served::new(&[]);
    let mut slow = connect(&served);
    slow.write_all(b"O\r").expect("it is open");
    let (mut quick, stop) = (connect(&served), AtomicBool::new(false));
    quick.write_all(b"O\r").expect("it is open");
    thread::scope(|scope| {
        scope.spawn(|| flood(quick, b"t70181122334455667788\r", true, &stop));
        while !served.cli.read("notices").contains("does not read") {
            thread::sleep(Duration::from_millis(10));
        }
        stop.store(true, Relaxed);
    });
    // The status comes after all that the server still has for the client.
    slow.write_all(b"F\r").expect("it is open");
    let mut lines = BufReader::new(slow);
    let status = loop {
        let mut line = Vec::new();
        lines.read_until(b'\r', &mut line).expect("a line");
        if line.starts_with(b"F") {
            break String::from_utf8(line).expect("UTF-8");
        }
    };
    assert_eq!(status, "F01\r", "received frames were lost");
    assert!(served.cli.read("notices").contains(" has lost "));
}

#[test]
fn running_out_of_descriptors_ends_no_connection_and_passes() {
    let program = assert_cmd::cargo::cargo_bin!("actuator");
    let mut command = Command::new("sh");
    let script = "ulimit -n 20; exec \"$0\" serve --listen 127.0.0.1:0";
    let served = Served::start(command.args(["-c", script]).arg(program));
    let first = connect(&served);
    assert!(is_served(&first));
    let others: Vec<_> = (0..32).map(|_| connect(&served)).collect();
    while !served
        .cli
        .read("notices")
        .contains("new clients have to wait")
    {
        thread::sleep(Duration::from_millis(10));
    }
    assert!(is_served(&first));
    drop(others);
    assert!(is_served(&connect(&served)));
}

#[test]
fn more_clients_than_are_accepted_are_refused_and_do_not_disturb_others() {
    let served = Served::new(&[]);
    let most = host_sim::can::server::CLIENTS_MAX;
    let clients: Vec<_> = (0..most).map(|_| connect(&served)).collect();
    assert!(clients.iter().all(is_served));
    assert!(!is_served(&connect(&served)));
    assert!(clients.iter().all(is_served));
    drop(clients);
    while !is_served(&connect(&served)) {
        thread::sleep(Duration::from_millis(10));
    }
    let notices = served.cli.read("notices");
    assert_eq!(notices.matches("are refused").count(), 1, "{notices}");
}

#[test]
fn what_a_client_sent_before_it_disconnects_is_carried_out() {
    let served = Served::new(&[]);
    let mut client = connect(&served);
    // More requests than wait for the bus, and the one that counts.
    let mut text = b"O\r".to_vec();
    text.extend(b"t60184041600000000000\r".repeat(2000));
    text.extend(b"t6018238160007B000000\r");
    client.write_all(&text).expect("it is open");
    client.shutdown(Shutdown::Write).expect("it is open");
    drop(client);
    // They take the shares of eight control periods or so.
    let is_done = (0..100).any(|_| served.text("get 6081") == "123 mdeg/s\n");
    assert!(is_done);
}
