use canopen::cia402::{Cia402State, Demand, Fault, Mode};
use proptest::prelude::*;

use crate::model::MODES;
use crate::{Bench, BenchOf, ENABLE, NEW};

fn mode() -> impl Strategy<Value = Mode> {
    prop::sample::select(&MODES)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn enabling_and_changes_of_mode_demand_the_actual_position_whatever_was_written_before(
        modes in prop::collection::vec(mode(), 1..6),
        angle in -200_000..200_000_i32, target: i32, velocity: i32, offset: i32,
        set_point in prop_oneof![Just(0_u16), Just(NEW & !ENABLE)],
    ) {
        let mut bench = Bench::new(modes[0]);
        let input = &mut bench.input;
        (input.position_actual, input.target_position) = (angle, target);
        (input.target_velocity, input.velocity_offset) = (velocity, offset);
        input.target_torque = target as i16;
        for word in [0, 6, 7] {
            bench.command(word);
        }
        bench.command(ENABLE | set_point);
        bench.writes(false);
        for mode in modes {
            bench.input.mode = mode;
            for _ in 0..10 {
                match bench.step().demand {
                    Demand::Off => prop_assert!(false, "powered"),
                    Demand::Position { position, velocity } => prop_assert_eq!((position, velocity), (angle, 0)),
                    Demand::Velocity(velocity) => prop_assert_eq!(velocity, 0),
                    Demand::Torque { torque, .. } => prop_assert!(false, "{}", torque),
                }
            }
        }
    }

    #[test]
    fn random_inputs_power_the_drive_in_three_states_only_and_keep_positions_in_range(
        steps in prop::collection::vec(
            (prop_oneof![Just(0x1F_u16), Just(0x0F), Just(0x07), Just(0x06), any::<u16>()], mode(),
             any::<i32>(), any::<i32>(), 0..60_u8), 1..300),
        period in prop_oneof![Just(2_usize), 0..4_usize],
    ) {
        let run = [
            keeps_its_ranges::<2>,
            keeps_its_ranges::<333>,
            keeps_its_ranges::<4_000>,
            keeps_its_ranges::<65_535>,
        ];
        run[period](steps)?;
    }
}

/// Controlword, mode, position, velocity, and a fault if below 2.
type Step = (u16, Mode, i32, i32, u8);

fn keeps_its_ranges<const PERIOD_US: u32>(steps: Vec<Step>) -> Result<(), TestCaseError> {
    let mut bench = BenchOf::<PERIOD_US>::new(Mode::None);
    bench.follows = false;
    for (word, mode, position, velocity, fault) in steps {
        bench.input.mode = mode;
        bench.input.target_position = position;
        bench.input.target_velocity = velocity;
        bench.input.velocity_offset = position;
        bench.input.position_actual = position / 50_000;
        bench.input.velocity_actual = velocity;
        bench.input.target_torque = position as i16;
        bench.input.fault = match fault {
            0 => Fault::Controlled,
            1 => Fault::Immediate,
            _ => Fault::None,
        };
        let output = bench.command(word);
        let powered = matches!(
            output.state,
            Cia402State::OperationEnabled
                | Cia402State::QuickStopActive
                | Cia402State::FaultReactionActive
        );
        prop_assert!(powered || output.demand == Demand::Off);
        if let Demand::Velocity(velocity) = output.demand
            && PERIOD_US == 4000
            && mode == Mode::CyclicVelocity
        {
            prop_assert!(velocity.unsigned_abs() <= 500_000);
        }
        if let Demand::Torque {
            torque,
            velocities: (slowest, fastest),
        } = output.demand
        {
            prop_assert!(torque.unsigned_abs() <= 1_000);
            prop_assert!((-500_000..=0).contains(&slowest) && (0..=500_000).contains(&fastest));
        }
    }
    Ok(())
}
