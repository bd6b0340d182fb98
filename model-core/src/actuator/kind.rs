//! The models and plants by name.

use crate::named::named;

named! {
    /// What can stand for the actuator.
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
    /// What stands for the motor and what it moves, behind the board.
    PlantKind {
        /// The paper's first-order motor, solved exactly.
        FirstOrder = "first-order",
        /// Motor, gear train, friction and load in detail.
        Drivetrain = "bench",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named::Named;

    #[test]
    fn every_name_leads_back_to_its_value() {
        for kind in ModelKind::ALL {
            assert_eq!(ModelKind::named(kind.name()), Some(*kind));
        }
        assert_eq!(ModelKind::named("bord"), None);
    }
}
