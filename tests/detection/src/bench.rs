//! An actuator on the bus, whose time goes on while its client waits, and that moves to and fro.

use std::time::Duration;

use canopen::NodeId;
use host_sim::can::client::{Client, ClientError};
use host_sim::can::native_link::NativeLink;
use host_sim::can::native_node::NativeNode;
use model_core::plant::board::BoardPlantOptions;

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
    let mut client = Client::new(Box::new(NativeLink::new(node, |_| {})), 1);
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
