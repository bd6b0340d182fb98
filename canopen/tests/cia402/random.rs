use canopen::cia402::{Cia402State, Demand, Fault, Mode};
use proptest::prelude::*;

use crate::Bench;

fn mode() -> impl Strategy<Value = Mode> {
    prop::sample::select(vec![
        Mode::None,
        Mode::ProfilePosition,
        Mode::ProfileVelocity,
        Mode::CyclicPosition,
        Mode::CyclicVelocity,
    ])
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_inputs_power_the_drive_in_three_states_only_and_keep_positions_in_range(
        steps in prop::collection::vec(
            (prop_oneof![Just(0x1F_u16), Just(0x0F), Just(0x07), Just(0x06), any::<u16>()], mode(),
             any::<i32>(), any::<i32>(), 0..60_u8), 1..300),
        period_us in prop_oneof![Just(4000_u32), any::<u32>()],
    ) {
        let mut bench = Bench::new(Mode::None);
        bench.parameters.period_us = period_us;
        bench.follows = false;
        for (word, mode, position, velocity, fault) in steps {
            bench.input.mode = mode;
            bench.input.target_position = position;
            bench.input.target_velocity = velocity;
            bench.input.velocity_offset = position;
            bench.input.position_actual = position / 50_000;
            bench.input.velocity_actual = velocity;
            bench.input.fault = match fault { 0 => Fault::Controlled, 1 => Fault::Immediate, _ => Fault::None };
            let output = bench.command(word);
            let powered = matches!(
                output.state,
                Cia402State::OperationEnabled | Cia402State::QuickStopActive | Cia402State::FaultReactionActive
            );
            prop_assert!(powered || output.demand == Demand::Off);
            if let Demand::Velocity(velocity) = output.demand
                && period_us == 4000 && mode == Mode::CyclicVelocity
            {
                prop_assert!(velocity.unsigned_abs() <= 500_000);
            }
        }
    }
}
