//! Serves one node as slcan over TCP on the loopback, for clients on the same computer:
//!
//! ```text
//! cargo run -p canopen --example loopback -- 29536 5
//! ```
//!
//! listens on port 29536 (0: any) with node-ID 5 (255: none, for LSS) and prints one line when it
//! is ready. Behind it is a CiA 402 drive. A write to 2007h raises the error of that code, which is a fault of the
//! drive, and 0 clears it.

mod device;
mod dictionary;
mod drive;
mod frame;
mod slcan;

use std::error::Error;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use canopen::{Emergency, ErrorCode, Node, NodeId, register};
use device::Device;
use drive::Drive;
use frame::CanFrame;

struct Bench {
    node: Node<2, 2>,
    device: Device,
    drive: Drive,
    begun: Instant,
    error: u16,
}

impl Bench {
    fn now_us(&self) -> u64 {
        self.begun.elapsed().as_micros() as u64
    }

    fn step(&mut self) {
        let now_us = self.now_us();
        let wanted = self.device.number(0x2007, 0) as u16;
        if wanted != self.error {
            self.node.clear(ErrorCode(self.error), 0);
            if wanted != 0 {
                let error = Emergency::new(ErrorCode(wanted), register::PROFILE);
                self.node.raise(error, &mut self.device);
            }
            self.error = wanted;
        }
        self.drive.run(now_us, &mut self.device, &mut self.node);
        self.node.tick(now_us, &mut self.device);
    }

    fn line(&mut self, line: &str) -> String {
        if let Some(frame) = slcan::parse(line) {
            let now_us = self.now_us();
            self.node.receive(&frame, now_us, &mut self.device);
        }
        match line.chars().next() {
            Some('V') => "V1013\r".into(),
            Some('N') => "N0001\r".into(),
            Some('F') => "F00\r".into(),
            _ => "\r".into(),
        }
    }

    /// Serves one client until it leaves.
    fn serve(&mut self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(Duration::from_millis(1)))?;
        let mut buffer = [0; 4096];
        let mut line = String::new();
        loop {
            let length = match stream.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(length) => length,
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    0
                }
                Err(error) => return Err(error),
            };
            let mut answer = String::new();
            for byte in &buffer[..length] {
                if *byte == b'\r' {
                    answer += &self.line(&std::mem::take(&mut line));
                    answer += &self.frames();
                } else if line.len() < 64 {
                    line.push(char::from(*byte));
                }
            }
            self.step();
            answer += &self.frames();
            stream.write_all(answer.as_bytes())?;
        }
    }

    fn frames(&mut self) -> String {
        let mut text = String::new();
        while let Some(frame) = self.node.transmit::<CanFrame>(&mut self.device) {
            text += &slcan::print(&frame);
        }
        text
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let port: u16 = arguments.next().as_deref().unwrap_or("29536").parse()?;
    let node_id = NodeId::new(arguments.next().as_deref().unwrap_or("5").parse()?);
    let mut device = Device::new();
    let node = Node::new(&dictionary::DICTIONARY, node_id, &mut device, 0);
    let mut bench = Bench {
        node,
        device,
        drive: Drive::default(),
        begun: Instant::now(),
        error: 0,
    };
    let listener = TcpListener::bind(("127.0.0.1", port))?;
    println!("listening on {}", listener.local_addr()?);
    for stream in listener.incoming() {
        if let Err(error) = bench.serve(stream?) {
            eprintln!("client gone: {error}");
        }
    }
    Ok(())
}
