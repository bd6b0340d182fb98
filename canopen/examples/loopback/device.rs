//! Example application: holds all written values and stores them with the delay of a flash.

use std::collections::HashMap;
use std::task::Poll;

use canopen::dictionary::{Address, Entry};
use canopen::{Abort, Application, BitRate, Event, NodeId, ParameterGroup, Reset};

/// Calls until a store is complete.
const SLOW: u32 = 3;
/// Maximum size of a DOMAIN.
const DOMAIN_MAX: usize = 1 << 16;

/// The application.
#[derive(Debug, Default)]
pub struct Device {
    /// Numeric values by address; 0 if absent.
    pub numbers: HashMap<Address, u64>,
    /// Strings by address.
    pub strings: HashMap<Address, Vec<u8>>,
    /// Object 2010h.
    pub domain: Vec<u8>,
    incoming: Vec<u8>,
    /// Whether the drive is enabled.
    pub enabled: bool,
    /// 607Ah was written since the last step of the axis.
    pub is_new_position: bool,
    /// 60FFh was written since the last step of the axis.
    pub is_new_velocity: bool,
    /// Reported events, in order.
    pub events: Vec<Event>,
    /// Stored communication parameters.
    pub stored: HashMap<Address, u32>,
    /// Stored numbers of the application.
    pub stored_numbers: HashMap<Address, u64>,
    /// Values stored by LSS.
    pub stored_lss: Option<(Option<NodeId>, Option<BitRate>)>,
    /// Bit rates set by LSS.
    pub bit_rates: Vec<BitRate>,
    /// Resets so far.
    pub resets: Vec<Reset>,
    /// Downloads to a DOMAIN that were cancelled.
    pub cancelled: u32,
    waited: u32,
}

impl Device {
    /// A device with non-zero software position limits.
    pub fn new() -> Self {
        let mut device = Self::default();
        device.power_on();
        device
    }

    fn power_on(&mut self) {
        self.numbers.clear();
        self.numbers
            .insert(Address::new(0x607D, 1), -60_000_i64 as u64);
        self.numbers.insert(Address::new(0x607D, 2), 60_000);
        self.numbers.extend(self.stored_numbers.clone());
    }

    /// The number at an address.
    pub fn number(&self, index: u16, sub: u8) -> u64 {
        self.numbers
            .get(&Address::new(index, sub))
            .copied()
            .unwrap_or(0)
    }

    /// Sets a number, as a control loop does.
    pub fn set(&mut self, index: u16, value: i64) {
        self.numbers.insert(Address::new(index, 0), value as u64);
    }

    fn wait(&mut self) -> bool {
        self.waited += 1;
        if self.waited > SLOW {
            self.waited = 0;
        }
        self.waited == 0
    }
}

impl Application for Device {
    fn read(&mut self, entry: &Entry) -> Result<u64, Abort> {
        let address = entry.address();
        Ok(self.number(address.index, address.sub))
    }

    fn write(&mut self, entry: &Entry, value: u64) -> Result<(), Abort> {
        let address = entry.address();
        self.is_new_position |= address.index == 0x607A;
        self.is_new_velocity |= address.index == 0x60FF;
        self.numbers.insert(address, value);
        Ok(())
    }

    fn guarded(&self) -> bool {
        self.enabled
    }

    fn read_bytes(&mut self, address: Address, buffer: &mut [u8]) -> Result<usize, Abort> {
        let text = self.strings.get(&address).map_or(&[][..], Vec::as_slice);
        buffer[..text.len()].copy_from_slice(text);
        Ok(text.len())
    }

    fn write_bytes(&mut self, address: Address, value: &[u8]) -> Result<(), Abort> {
        self.strings.insert(address, value.to_vec());
        Ok(())
    }

    fn domain_size(&mut self, address: Address) -> Result<u32, Abort> {
        match address.index {
            0x2010 if !self.domain.is_empty() => Ok(self.domain.len() as u32),
            _ => Err(Abort::NoData),
        }
    }

    fn domain_read(&mut self, _: Address, offset: u32, buffer: &mut [u8]) -> Result<(), Abort> {
        let offset = offset as usize;
        let data = self
            .domain
            .get(offset..offset + buffer.len())
            .ok_or(Abort::Hardware)?;
        buffer.copy_from_slice(data);
        Ok(())
    }

    fn domain_begin(&mut self, _: Address, size: Option<u32>) -> Result<(), Abort> {
        if size.is_some_and(|size| size as usize > DOMAIN_MAX) {
            return Err(Abort::OutOfMemory);
        }
        self.incoming.clear();
        Ok(())
    }

    fn domain_write(&mut self, _: Address, offset: u32, data: &[u8]) -> Result<(), Abort> {
        assert_eq!(
            offset as usize,
            self.incoming.len(),
            "in order, without gaps"
        );
        if self.incoming.len() + data.len() > DOMAIN_MAX {
            return Err(Abort::OutOfMemory);
        }
        self.incoming.extend_from_slice(data);
        Ok(())
    }

    fn domain_end(&mut self, _: Address, size: u32) -> Poll<Result<(), Abort>> {
        if !self.wait() {
            return Poll::Pending;
        }
        assert_eq!(size as usize, self.incoming.len());
        self.domain = std::mem::take(&mut self.incoming);
        Poll::Ready(Ok(()))
    }

    fn domain_cancel(&mut self, _: Address) {
        self.cancelled += 1;
        self.waited = 0;
        self.incoming.clear();
    }

    fn reset(&mut self, reset: Reset) {
        self.resets.push(reset);
        self.waited = 0;
        if reset == Reset::Node {
            self.power_on();
        }
    }

    fn stored(&mut self, address: Address) -> Option<u32> {
        self.stored.get(&address).copied()
    }

    fn store(
        &mut self,
        group: ParameterGroup,
        communication: &mut dyn Iterator<Item = (Address, u32)>,
    ) -> Poll<Result<(), Abort>> {
        if !self.wait() {
            return Poll::Pending;
        }
        if group.has_communication() {
            self.stored = communication.collect();
        }
        if matches!(group, ParameterGroup::All | ParameterGroup::Application) {
            self.stored_numbers = self.numbers.clone();
        }
        Poll::Ready(Ok(()))
    }

    fn restore(&mut self, group: ParameterGroup) -> Poll<Result<(), Abort>> {
        if group.has_communication() {
            self.stored.clear();
        }
        if matches!(group, ParameterGroup::All | ParameterGroup::Application) {
            self.stored_numbers.clear();
        }
        Poll::Ready(Ok(()))
    }

    fn event(&mut self, event: Event) {
        self.events.push(event);
    }

    fn supports_bit_rate(&self, bit_rate: BitRate) -> bool {
        bit_rate != BitRate::Automatic
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) {
        self.bit_rates.push(bit_rate);
    }

    fn store_lss(
        &mut self,
        node_id: Option<NodeId>,
        bit_rate: Option<BitRate>,
    ) -> Poll<Result<(), Abort>> {
        if !self.wait() {
            return Poll::Pending;
        }
        self.stored_lss = Some((node_id, bit_rate));
        Poll::Ready(Ok(()))
    }
}
