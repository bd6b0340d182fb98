//! Objects of an actuator that a client changes for a while, such as what its PDOs contain, and
//! writes back.

use super::client::{Client, ClientError};
use super::names;

/// Bit of a COB-ID: the PDO does not exist.
const INVALID: i64 = 1 << 31;

/// Values of objects before their change, the last one first, with index and sub-index.
pub type Originals = Vec<((u16, u8), Vec<u8>)>;

/// The word of a PDO mapping for an object.
///
/// # Errors
/// [`ClientError::Request`] for an object that is not in the dictionary.
///
/// ```
/// assert_eq!(host_sim::can::mapped::mapping("6062").unwrap(), 0x6062_0020);
/// ```
pub fn mapping(object: &str) -> Result<u32, ClientError> {
    let row = names::find(object)?;
    let bytes = names::layout(row.kind).map_or(4, |(bytes, _)| bytes as u32);
    Ok(u32::from(row.index) << 16 | u32::from(row.sub_index()) << 8 | (8 * bytes))
}

/// Changes of objects, with the values before them.
pub struct Changes<'c> {
    /// The actuator.
    pub client: &'c mut Client,
    /// What [`restore`] writes back.
    pub original: Originals,
}

impl<'c> Changes<'c> {
    /// None so far.
    pub fn new(client: &'c mut Client) -> Self {
        Self {
            client,
            original: Vec::new(),
        }
    }

    /// Writes a value.
    ///
    /// # Errors
    /// Those of the transfers.
    pub fn write(&mut self, object: &str, value: &str) -> Result<(), ClientError> {
        let row = names::find(object)?;
        let before = self.client.get(row)?;
        let before = names::encode(row, &before.to_string())?;
        // Written back in the opposite order.
        self.original.insert(0, (row.address(), before));
        self.client.write(object, value)
    }

    /// Maps objects into a TPDO behind those that it `keeps`, and makes it valid.
    ///
    /// # Errors
    /// Those of the transfers.
    pub fn map(&mut self, number: u8, keeps: u8, objects: &[&str]) -> Result<(), ClientError> {
        let cob_id = format!("{:04X}:1", 0x1800 + u16::from(number) - 1);
        let map = 0x1A00 + u16::from(number) - 1;
        let id = self.client.integer(&cob_id)?;
        self.write(&cob_id, &(id | INVALID).to_string())?;
        self.write(&format!("{map:04X}:0"), "0")?;
        for (sub, object) in (keeps + 1..).zip(objects) {
            self.write(&format!("{map:04X}:{sub}"), &mapping(object)?.to_string())?;
        }
        let count = usize::from(keeps) + objects.len();
        self.client
            .write(&format!("{map:04X}:0"), &count.to_string())?;
        self.client.write(&cob_id, &(id & !INVALID).to_string())
    }

    /// Whether a TPDO is valid: the actuator sends it.
    ///
    /// # Errors
    /// Those of the transfers.
    pub fn is_valid(&mut self, number: u8) -> Result<bool, ClientError> {
        let cob_id = format!("{:04X}:1", 0x1800 + u16::from(number) - 1);
        Ok(self.client.integer(&cob_id)? & INVALID == 0)
    }
}

/// Writes back what has been changed.
///
/// # Errors
/// Those of the transfers.
pub fn restore(client: &mut Client, original: &[((u16, u8), Vec<u8>)]) -> Result<(), ClientError> {
    for ((index, sub), bytes) in original {
        // A PDO is invalid and its mapping empty while its entries change.
        if index & 0xFF00 == 0x1A00 && *sub > 0 {
            let cob_id = format!("{:04X}:1", index - 0x200);
            let id = client.integer(&cob_id)?;
            client.write(&cob_id, &(id | INVALID).to_string())?;
            client.write(&format!("{index:04X}:0"), "0")?;
        }
        client.set(names::find(&format!("{index:04X}:{sub}"))?, bytes)?;
    }
    Ok(())
}
