//! How long a client of the server waits for an object, alone and beside clients that send as much
//! as they can; and the part of a core that as many actuators as a bus can have take.

mod many;

use std::{
    io::{Read as _, Write as _},
    net::{SocketAddr, TcpListener, TcpStream},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
    thread,
    time::Instant,
};

use canopen::NodeId;
use host_sim::can::{
    bus::Bus,
    client::Client,
    names,
    native_node::{CAPTURE_VALUES, NativeNode},
    server::Server,
};

const READS: usize = 2000;
const FLOODS: usize = 8;

/// Reads of the statusword, which nothing but the bus delays.
fn reads(address: SocketAddr) -> Vec<f64> {
    let mut client = Client::open(&address.to_string(), 1000, 1).expect("a bus");
    let row = names::find("statusword").expect("an object");
    let read = |_| {
        let start = Instant::now();
        client.get(row).expect("a value");
        start.elapsed().as_secs_f64() * 1e6
    };
    (0..READS).map(read).collect()
}

fn print(title: &str, mut times_us: Vec<f64>) {
    times_us.sort_by(f64::total_cmp);
    for (name, part) in [("median", 0.5), ("99 %", 0.99)] {
        let time_us = times_us[(part * (times_us.len() - 1) as f64) as usize];
        println!("figure SDO read through the server, {title}: {name} = {time_us:.0} us");
    }
}

/// Sends frames and reads their answers, as fast as the server takes them.
fn flood(address: SocketAddr, stop: &AtomicBool) {
    let mut stream = TcpStream::connect(address).expect("a connection");
    let mut reader = stream.try_clone().expect("a second handle");
    thread::scope(|scope| {
        scope.spawn(move || {
            let mut buffer = [0; 1 << 16];
            while reader.read(&mut buffer).is_ok_and(|length| length > 0) {}
        });
        let lines = b"t70181122334455667788\r".repeat(1000);
        stream.write_all(b"O\r").expect("it is open");
        while !stop.load(Relaxed) {
            stream.write_all(&lines).expect("it is open");
        }
        // Ends the reader.
        let _ = stream.shutdown(std::net::Shutdown::Both);
    });
}

fn main() {
    many::print();
    let mut buffer = vec![0; CAPTURE_VALUES];
    let node = NativeNode::new(1, NodeId::new(1), &Default::default(), &mut buffer);
    let mut server = Server::new(Bus::new(vec![node.expect("a node")]));
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let (stop, stop_floods) = (AtomicBool::new(false), AtomicBool::new(false));
    thread::scope(|scope| {
        scope.spawn(|| {
            let run = server.run(Some(listener), &stop, &mut |notice| eprintln!("{notice}"));
            run.expect("the server runs");
        });
        print("alone", reads(address));
        thread::scope(|scope| {
            for _ in 0..FLOODS {
                scope.spawn(|| flood(address, &stop_floods));
            }
            print(&format!("beside {FLOODS} floods"), reads(address));
            stop_floods.store(true, Relaxed);
        });
        stop.store(true, Relaxed);
    });
}
