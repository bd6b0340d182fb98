//! `actuator serve --protocol`: servos on a serial bus.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use crate::Cli;
use crate::served::Served;

/// What a client of the bus gets as the answer to these bytes.
fn exchange(stream: &mut TcpStream, bytes: &[u8], answer: usize) -> Vec<u8> {
    stream.write_all(bytes).expect("it is sent");
    let mut answered = vec![0; answer];
    stream.read_exact(&mut answered).expect("an answer");
    answered
}

fn connect(served: &Served) -> TcpStream {
    let stream = TcpStream::connect(&served.bus).expect("it accepts");
    let timeout = Some(Duration::from_secs(10));
    stream.set_read_timeout(timeout).expect("a time");
    stream
}

#[test]
fn the_clients_of_a_port_share_the_servos() {
    let served = Served::new(&["--protocol", "sts3215", "--nodes", "2"]);
    let [mut one, mut other] = [connect(&served), connect(&served)];
    // The manual's ping, and one of the second servo.
    let ping = [0xFF, 0xFF, 1, 2, 1, 0xFB];
    assert_eq!(exchange(&mut one, &ping, 6), [0xFF, 0xFF, 1, 2, 0, 0xFC]);
    let ping = [0xFF, 0xFF, 2, 2, 1, 0xFA];
    assert_eq!(exchange(&mut other, &ping, 6), [0xFF, 0xFF, 2, 2, 0, 0xFB]);
    // What one writes, the other reads: P of the first servo.
    exchange(&mut one, &[0xFF, 0xFF, 1, 4, 3, 0x15, 16, 0xD2], 6);
    let read = [0xFF, 0xFF, 1, 4, 2, 0x15, 1, 0xE2];
    assert_eq!(exchange(&mut other, &read, 7)[5], 16);
    drop(one);
    assert_eq!(exchange(&mut other, &read, 7)[5], 16);
}

#[test]
fn a_part_of_a_packet_is_forgotten_after_a_pause() {
    let served = Served::new(&["--protocol", "xl330-m288"]);
    let mut stream = connect(&served);
    // The begin of a packet of 255 bytes more.
    stream
        .write_all(&[0xFF, 0xFF, 0xFD, 0, 1, 0xFF, 0])
        .expect("it is sent");
    std::thread::sleep(Duration::from_millis(200));
    let ping = [0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E];
    let answer = exchange(&mut stream, &ping, 14);
    assert_eq!(answer[9..12], [0xB0, 4, 46]);
}

#[test]
fn options_that_cannot_be_are_refused() {
    let cli = Cli::new();
    std::fs::write(cli.path("file"), "a file").expect("a file");
    for (options, status, message) in [
        (
            "--protocol sts3216",
            2,
            "sts3215, sts3250, xl330-m288, xm430-w350",
        ),
        (
            "--protocol sts3215 --supply-ohm=-1",
            2,
            "--supply-ohm is -1, expected 0 to 100 ohm",
        ),
        ("--supply-ohm 1", 2, "--protocol <MODEL>"),
        ("--protocol sts3215 --seed 1", 2, "cannot be used with"),
        #[cfg(unix)]
        (
            "--protocol sts3215 --pty --link file",
            1,
            "cannot serve at file: File exists",
        ),
    ] {
        cli.assert_error(&format!("serve {options}"), status, message);
    }
    let kept = std::fs::read_to_string(cli.path("file")).expect("a file");
    assert_eq!(kept, "a file");
}
