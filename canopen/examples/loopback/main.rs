//! Serves one node as slcan over TCP on the loopback interface, for clients on the same computer:
//!
//! ```text
//! cargo run -p canopen-device --example loopback -- 29536 5
//! ```
//!
//! listens on port 29536 (0: any) with node-ID 5 (255: none, for LSS) and prints one line when it
//! is ready. The node is a CiA 402 drive. A write to 2007h raises the error of that code, which is
//! a fault of the drive; 0 clears it.

mod device;
mod dictionary;
mod drive;

use std::error::Error;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use canopen::slcan::{Adapter, Bus};
use canopen::{CanFrame, Emergency, ErrorCode, Node, NodeId, register};
use device::Device;
use drive::Drive;

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

    /// Serves one client until it disconnects.
    fn serve(&mut self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(Duration::from_millis(1)))?;
        let mut buffer = [0; 4096];
        let mut adapter = Adapter::new(*b"0001");
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
            let mut answer = Vec::new();
            for byte in &buffer[..length] {
                if let Some(text) = adapter.receive(*byte, self) {
                    answer.extend_from_slice(text.as_bytes());
                    self.frames(&adapter, &mut answer);
                }
            }
            self.step();
            self.frames(&adapter, &mut answer);
            stream.write_all(&answer)?;
        }
    }

    fn frames(&mut self, adapter: &Adapter, answer: &mut Vec<u8>) {
        let now_us = self.now_us();
        while let Some(frame) = self.node.transmit::<CanFrame>(&mut self.device) {
            if let Some(text) = adapter.frame(&frame, now_us) {
                answer.extend_from_slice(text.as_bytes());
            }
        }
    }
}

impl Bus for Bench {
    fn open(&mut self, _: Option<u16>, _: bool) -> bool {
        true
    }

    fn close(&mut self) {}

    fn send(&mut self, frame: &CanFrame) -> bool {
        let now_us = self.now_us();
        self.node.receive(frame, now_us, &mut self.device);
        true
    }

    fn flags(&mut self) -> u8 {
        0
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
            eprintln!("client disconnected: {error}");
        }
    }
    Ok(())
}
