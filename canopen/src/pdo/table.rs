//! The parameters of all PDOs of a node.

use super::{Direction, PdoParameters};

/// Communication and mapping parameters of `R` RPDOs and `T` TPDOs: 1400h, 1600h, 1800h and 1A00h
/// with the indices that follow.
#[derive(Debug)]
pub struct PdoTable<const R: usize, const T: usize> {
    receive: [PdoParameters; R],
    transmit: [PdoParameters; T],
}

/// Which parameters of a PDO an index addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PdoObject {
    /// 14xxh and 18xxh.
    Communication,
    /// 16xxh and 1Axxh.
    Mapping,
}

/// Index of the communication parameters of the first RPDO and TPDO, and the offset from there to
/// the mapping parameters.
const RPDO: u16 = 0x1400;
const TPDO: u16 = 0x1800;
const MAPPING: u16 = 0x0200;

/// Offset of an index from `base`; out of any range if the index is below it.
fn offset_from(index: u16, base: u16) -> usize {
    usize::from(index.wrapping_sub(base))
}

/// Number from 0 of the RPDO whose communication parameters an index addresses, if there is one.
pub(crate) fn rpdo_of(index: u16) -> usize {
    offset_from(index, RPDO)
}

/// The same of a TPDO.
pub(crate) fn tpdo_of(index: u16) -> usize {
    offset_from(index, TPDO)
}

impl<const R: usize, const T: usize> PdoTable<R, T> {
    /// Initial state; [`PdoTable::reset`] must follow.
    pub(crate) const NEW: Self = Self {
        receive: [PdoParameters::NEW; R],
        transmit: [PdoParameters::NEW; T],
    };

    /// Sets the defaults of PDOs without dictionary entries.
    pub(crate) fn reset(&mut self) {
        for parameters in &mut self.receive {
            parameters.reset(Direction::Receive);
        }
        for parameters in &mut self.transmit {
            parameters.reset(Direction::Transmit);
        }
    }

    /// The parameters of the RPDOs.
    pub(crate) const fn receive(&self) -> &[PdoParameters; R] {
        &self.receive
    }

    /// The parameters of the TPDOs.
    pub(crate) const fn transmit(&self) -> &[PdoParameters; T] {
        &self.transmit
    }

    /// The parameters of all PDOs.
    pub(crate) fn all_mut(&mut self) -> impl Iterator<Item = &mut PdoParameters> {
        self.receive.iter_mut().chain(&mut self.transmit)
    }

    /// The PDO with these parameters at `index`.
    pub(crate) fn find(&self, index: u16, object: PdoObject) -> Option<&PdoParameters> {
        let index = communication_index(index, object);
        let receive = self.receive.get(rpdo_of(index));
        receive.or(self.transmit.get(tpdo_of(index)))
    }

    /// As [`PdoTable::find`].
    pub(crate) fn find_mut(&mut self, index: u16, object: PdoObject) -> Option<&mut PdoParameters> {
        let index = communication_index(index, object);
        let receive = self.receive.get_mut(rpdo_of(index));
        receive.or(self.transmit.get_mut(tpdo_of(index)))
    }
}

/// The index of the communication parameters of the same PDO.
const fn communication_index(index: u16, object: PdoObject) -> u16 {
    match object {
        PdoObject::Communication => index,
        PdoObject::Mapping => index.wrapping_sub(MAPPING),
    }
}
