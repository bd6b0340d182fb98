//! `actuator board --gdb`: a minimal client of GDB's remote protocol that stops the board and reads
//! its state.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    process::{Child, Command, Stdio},
    time::Duration,
};

use bootloader::{HEADER_SIZE, layout::STM32F427};
use cross_build::board_elf;

/// Vector of the interrupt of the control step, DMA2 stream 0 (RM0090, table 62: position 56), in
/// the program of the slot.
fn control_vector() -> u32 {
    STM32F427.slot.start() + HEADER_SIZE + 4 * (16 + 56)
}

/// A debugger at the program's port.
struct Debugger {
    stream: BufReader<TcpStream>,
}

impl Debugger {
    /// Sends a packet and returns the response.
    fn request(&mut self, packet: &str) -> String {
        let sum = packet.bytes().fold(0u8, u8::wrapping_add);
        let sent = format!("${packet}#{sum:02x}");
        let stream = self.stream.get_mut();
        stream.write_all(sent.as_bytes()).expect("it listens");
        let (mut skipped, mut answer, mut sum) = (vec![], vec![], [0; 2]);
        let stream = &mut self.stream;
        stream.read_until(b'$', &mut skipped).expect("an answer");
        stream.read_until(b'#', &mut answer).expect("its end");
        stream.read_exact(&mut sum).expect("its sum");
        stream.get_mut().write_all(b"+").expect("it listens");
        answer.pop();
        String::from_utf8(answer).expect("ASCII")
    }

    /// A word in the byte order of the target, little endian.
    fn word(hex: &str) -> u32 {
        u32::from_str_radix(hex, 16)
            .expect("hexadecimal")
            .swap_bytes()
    }
}

fn board(seconds: &str) -> (Child, BufReader<std::process::ChildStderr>, Debugger) {
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args(["board", "--pace", "max", "--format", "none", "--gdb", "0"])
        .args(["--for", seconds, "--elf"])
        .arg(board_elf())
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    let mut said = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut line = String::new();
    said.read_line(&mut line).expect("a line");
    let address = line.trim().strip_prefix("GDB: target remote ");
    let stream = TcpStream::connect(address.expect(&line)).expect("the port is open");
    let patience = Some(Duration::from_secs(60));
    stream.set_read_timeout(patience).expect("a timeout");
    let stream = BufReader::new(stream);
    (child, said, Debugger { stream })
}

#[test]
fn a_debugger_stops_the_board_in_its_control_step_reads_it_and_continues_it() {
    let (mut child, mut said, mut debugger) = board("0.1");
    assert!(debugger.request("?").starts_with(['S', 'T']));
    let vector = debugger.request(&format!("m{:x},4", control_vector()));
    // The lowest bit marks Thumb code.
    let handler = Debugger::word(&vector) & !1;
    assert_eq!(debugger.request(&format!("Z1,{handler:x},2")), "OK");
    for _ in 0..2 {
        assert!(debugger.request("c").starts_with(['S', 'T']));
        // Sixteen registers of eight digits; the last is the program counter.
        let registers = debugger.request("g");
        let counter = registers.get(15 * 8..16 * 8).expect("16 registers");
        assert_eq!(Debugger::word(counter), handler);
    }
    assert_eq!(debugger.request(&format!("z1,{handler:x},2")), "OK");
    assert_eq!(debugger.request("D"), "OK");
    let mut rest = String::new();
    said.read_to_string(&mut rest).expect("its words");
    assert!(child.wait().expect("it ends").success(), "{rest}");
    assert!(rest.contains("0.1 s in"), "{rest}");
}
