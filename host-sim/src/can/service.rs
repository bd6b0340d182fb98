//! The service password of an actuator, object 2103h.

use canopen::Abort;

use super::client::{Client, ClientError};
use super::names;
use super::sdo::SdoError;

/// What 2103h:2 reads while a password is set that has not been given.
const LOCKED: i64 = 1;

/// Opens what the service password locks. A node without the object has no password: a waiting
/// bootloader, or an earlier program.
///
/// # Errors
/// [`ClientError::NotNow`] for a wrong password and during the back-off; those of the bus.
pub fn open(client: &mut Client, password: u32) -> Result<(), ClientError> {
    let node = client.node();
    let row = names::find("2103:1")?;
    match client.set(row, &password.to_le_bytes()) {
        Err(ClientError::Object { name, source }) => match abort_code(&source) {
            Some(code) if is(code, Abort::NoObject) => Ok(()),
            Some(code) if is(code, Abort::Value) => {
                let why = "the service password is wrong";
                Err(ClientError::NotNow { node, why })
            }
            Some(code) if is(code, Abort::DeviceState) => {
                let why = "after a wrong service password it takes none for a while; \
                           service-access/remaining-back-off is the remaining time";
                Err(ClientError::NotNow { node, why })
            }
            _ => Err(ClientError::Object { name, source }),
        },
        other => other,
    }
}

/// Locks it again.
///
/// # Errors
/// Those of the bus.
pub fn lock(client: &mut Client) -> Result<(), ClientError> {
    open(client, 0)
}

/// An error that says that the password is missing, if that is why the node refuses.
pub fn missing(client: &mut Client) -> Option<ClientError> {
    let node = client.node();
    let state = client.integer("2103:2").ok()?;
    let why = "the service password locks it; --password opens it";
    (state == LOCKED).then_some(ClientError::NotNow { node, why })
}

fn abort_code(error: &SdoError) -> Option<u32> {
    match error {
        SdoError::Abort { code, .. } => Some(*code),
        _ => None,
    }
}

fn is(code: u32, abort: Abort) -> bool {
    code == abort.code()
}
