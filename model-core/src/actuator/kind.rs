//! Models and plants by name.

use crate::named::named;

named! {
    /// Model of the actuator.
    ModelKind {
        /// First-order lag with rate and position limits.
        BlackBox1 = "black-box-1",
        /// Second-order lag with rate and position limits.
        BlackBox2 = "black-box-2",
        /// Motor, PI rate loop and P position loop in continuous time.
        GreyBox = "grey-box",
        /// The board's own fixed-point control step around a motor.
        Board = "board",
    }
}

named! {
    /// Plant of the board: motor, gear train and load.
    PlantKind {
        /// The paper's first-order motor, solved exactly.
        FirstOrder = "first-order",
        /// Detailed motor, gear train, friction and load.
        Drivetrain = "bench",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named::Named;

    #[test]
    fn every_value_is_found_by_its_name() {
        for kind in ModelKind::ALL {
            assert_eq!(ModelKind::named(kind.name()), Some(*kind));
        }
        assert_eq!(ModelKind::named("bord"), None);
    }
}
