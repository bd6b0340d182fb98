//! Values that a master sets and the drive keeps, beyond the parameters of the board: profile, windows, options,
//! model, excitation and capture. Their defaults are those of the dictionary.

use canopen::dictionary::Address;

use crate::dictionary::DICTIONARY;

macro_rules! kept {
    ($($Slot:ident = $index:literal, $sub:literal;)+) => {
        /// Where a value is kept.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Slot {
            $(
                #[doc = concat!("Object ", stringify!($index), ", sub-index ", stringify!($sub), ".")]
                $Slot,
            )+
        }

        /// Index in the upper, sub-index in the lower part.
        const OBJECTS: [Address; COUNT] = [$(Address::new($index, $sub)),+];

        /// How many there are.
        pub(super) const COUNT: usize = [$(Slot::$Slot),+].len();
    };
}

kept! {
    Model = 0x2010, 2;
    Resistance = 0x2011, 1;
    TorqueConstant = 0x2011, 2;
    GearRatio = 0x2011, 3;
    Inertia = 0x2011, 4;
    Viscous = 0x2011, 5;
    Coulomb = 0x2011, 6;
    Correction = 0x2011, 7;
    // The rows of the excitation's settings, in their order.
    Shape = 0x2020, 3;
    Amplitude = 0x2020, 4;
    Start = 0x2020, 5;
    End = 0x2020, 6;
    Duration = 0x2020, 7;
    Unit = 0x2020, 8;
    RampRate = 0x2020, 9;
    Order = 0x2020, 10;
    Lines = 0x2020, 11;
    Repetitions = 0x2020, 12;
    Trigger = 0x2030, 3;
    Before = 0x2030, 4;
    Decimation = 0x2030, 5;
    Signal1 = 0x2031, 1;
    Signal2 = 0x2031, 2;
    Signal3 = 0x2031, 3;
    Signal4 = 0x2031, 4;
    Signal5 = 0x2031, 5;
    Signal6 = 0x2031, 6;
    Signal7 = 0x2031, 7;
    Signal8 = 0x2031, 8;
    Action = 0x2040, 2;
    Retreat = 0x2040, 3;
    QuickStopOption = 0x605A, 0;
    ShutdownOption = 0x605B, 0;
    DisableOption = 0x605C, 0;
    HaltOption = 0x605D, 0;
    FaultOption = 0x605E, 0;
    PositionWindow = 0x6067, 0;
    PositionWindowTime = 0x6068, 0;
    VelocityWindow = 0x606D, 0;
    VelocityWindowTime = 0x606E, 0;
    VelocityThreshold = 0x606F, 0;
    VelocityThresholdTime = 0x6070, 0;
    MinPosition = 0x607D, 1;
    MaxPosition = 0x607D, 2;
    MaxVelocity = 0x607F, 0;
    ProfileVelocity = 0x6081, 0;
    Acceleration = 0x6083, 0;
    Deceleration = 0x6084, 0;
    QuickStopDeceleration = 0x6085, 0;
    InterpolationTime = 0x60C2, 1;
    InterpolationIndex = 0x60C2, 2;
}

/// The values, as bits of their data types, signed ones extended to 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Kept([u32; COUNT]);

impl Kept {
    /// Those of the dictionary.
    pub fn defaults() -> Self {
        Self(OBJECTS.map(|address| {
            // Each of them has an entry: a test looks.
            let row = DICTIONARY.find(address);
            row.map_or(0, |row| row.default_value(0))
        }))
    }

    /// The value of a slot.
    pub fn get(&self, slot: Slot) -> u32 {
        self.0.get(slot as usize).copied().unwrap_or(0)
    }

    /// As a REAL32.
    pub fn real(&self, slot: Slot) -> f32 {
        f32::from_bits(self.get(slot))
    }

    /// Values from a slot on.
    pub fn from(&self, slot: Slot) -> impl Iterator<Item = u32> + '_ {
        self.0.iter().skip(slot as usize).copied()
    }

    /// The place of an object; `None` where its value is not kept here.
    pub fn place(&mut self, address: Address) -> Option<&mut u32> {
        let at = OBJECTS.iter().position(|object| *object == address)?;
        self.0.get_mut(at)
    }

    /// All words.
    pub fn words(&self) -> &[u32; COUNT] {
        &self.0
    }

    /// Of these words, whatever they are.
    pub fn of(words: &[u32; COUNT]) -> Self {
        Self(*words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kept_value_is_an_object_that_can_be_written() {
        use canopen::dictionary::Access;
        for address in OBJECTS {
            let entry = DICTIONARY.find(address).expect("an entry");
            assert_eq!(entry.access(), Access::ReadWrite, "{address:?}");
        }
        assert!(OBJECTS.is_sorted());
    }

    #[test]
    fn a_slot_is_where_its_object_is() {
        let mut kept = Kept::defaults();
        *kept.place(Address::new(0x6085, 0)).expect("kept") = 7;
        assert_eq!(kept.get(Slot::QuickStopDeceleration), 7);
        assert_eq!(kept.get(Slot::MinPosition) as i32, -60_000);
        assert_eq!(kept.real(Slot::GearRatio), 320.0);
        assert_eq!(kept.place(Address::new(0x6041, 0)), None);
    }
}
