//! An actuator on the bus, whose time goes on while its client waits, and that moves to and fro.

use std::io;
use std::time::Duration;

use canopen::{CanFrame, NodeId};
use host_sim::can::client::{Client, ClientError};
use host_sim::can::link::Link;
use host_sim::can::native_node::NativeNode;
use model_core::plant::board::BoardPlantOptions;
use model_core::time::CONTROL_PERIOD_US;

/// A bus of one node.
struct Bus(NativeNode<'static>);

impl Bus {
    fn step(&mut self) {
        self.0.step(self.0.next_us());
    }
}

impl Link for Bus {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.0.receive(frame);
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end_us = self.0.next_us() + timeout.as_micros() as u64;
        loop {
            let frame = self.0.transmit();
            if frame.is_some() || self.0.next_us() > end_us {
                return Ok(frame);
            }
            self.step();
        }
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        for _ in 0..time.as_micros() / u128::from(CONTROL_PERIOD_US) {
            self.step();
            while self.0.transmit().is_some() {}
        }
        Ok(())
    }
}

/// A client of an actuator on this plant, which has been at rest with the bridge off for 0.4 s.
///
/// # Errors
/// [`ClientError::Link`].
///
/// # Panics
/// If the options are out of their ranges.
pub fn client(options: &BoardPlantOptions) -> Result<Client, ClientError> {
    // Nothing is captured.
    let node = NativeNode::new(1, NodeId::new(1), options, &mut []).expect("in range");
    let mut client = Client::new(Box::new(Bus(node)), 1);
    client.pause(Duration::from_millis(400))?;
    Ok(client)
}

/// Enables it in profile position mode.
///
/// # Errors
/// Those of the client.
pub fn enable(client: &mut Client) -> Result<(), ClientError> {
    client.write("6060", "1")?;
    [0x06, 0x07, 0x0F]
        .into_iter()
        .try_for_each(|word| client.control(word))
}

/// A motion, of even number to 50 deg and of odd number to -50 deg, and the rest of a second.
///
/// # Errors
/// Those of the client.
pub fn turn(client: &mut Client, number: u32) -> Result<(), ClientError> {
    let target_mdeg = if number.is_multiple_of(2) {
        50_000
    } else {
        -50_000
    };
    client.write("607A", &target_mdeg.to_string())?;
    // A set-point is taken at the rise of its bit.
    client.control(0x2F)?;
    client.control(0x3F)?;
    client.pause(Duration::from_secs(1))
}
