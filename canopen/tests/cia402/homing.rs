//! The mode homing: what each method finds, and what interrupts it.

use canopen::cia402::{
    Axis, Cia402State, Demand, Direction, Fault, HomingMethod, HomingParameters, Input, Mode,
    Output, StopOption, controlword, statusword,
};

use crate::{Bench, ENABLE};

const START: u16 = ENABLE | controlword::START_HOMING;

/// Bits 10, 12 and 13 of the statusword: reached, attained, error.
const IN_PROGRESS: u16 = 0;
const INTERRUPTED: u16 = statusword::TARGET_REACHED;
const ATTAINED: u16 = statusword::TARGET_REACHED | statusword::MODE_12;
const FAILED: u16 = statusword::TARGET_REACHED | statusword::HOMING_ERROR;

fn bits(output: &Output) -> u16 {
    output.statusword & (ATTAINED | statusword::HOMING_ERROR)
}

/// A motor between two hard stops of the encoder's coordinates, which follows the demand with a
/// current of 50 and pulls with 300 at a stop; or with no current, if it is not connected.
struct Homed {
    bench: Bench,
    stops: (i32, i32),
    pulls: bool,
}

impl Homed {
    fn new(method: HomingMethod, at: i32) -> Self {
        let mut bench = Bench::new(Mode::Homing);
        bench.follows = false;
        bench.input.position_actual = at;
        bench.parameters.homing = HomingParameters {
            method,
            offset: 1_000,
            ..HomingParameters::default()
        };
        for word in [0, 0x06, 0x07, ENABLE] {
            bench.command(word);
        }
        Self {
            bench,
            stops: (-70_000, 80_000),
            pulls: true,
        }
    }

    fn command(&mut self, word: u16) -> Output {
        self.bench.input.controlword = word;
        self.step()
    }

    fn step(&mut self) -> Output {
        let output = self.bench.step();
        let input = &mut self.bench.input;
        let before = input.position_actual;
        if let Demand::Position { position, .. } = output.demand {
            let (low, high) = self.stops;
            let demand = position - output.origin;
            input.position_actual = demand.clamp(low, high);
            let pulls = self.pulls && input.position_actual != demand;
            input.current_actual = if pulls { 300 } else { 50 };
        }
        input.velocity_actual = (input.position_actual - before) * 250;
        output
    }

    /// Until bit 10 is set, for 20 s at most.
    fn ends(&mut self) -> Output {
        let steps = (0..5_000).map(|_| self.step());
        let mut steps = steps.skip_while(|output| bits(output) & statusword::TARGET_REACHED == 0);
        steps.next().expect("an end")
    }

    /// The position by the encoder that has become the home offset.
    fn home(&self, output: &Output) -> i32 {
        self.bench.parameters.homing.offset - output.origin
    }
}

#[test]
fn each_method_finds_its_home_position() {
    use Direction::{Negative, Positive};
    use HomingMethod::{Here, Index, IndexBehindStop, Stop};
    for (method, home) in [
        (Here, 30_000),
        (HomingMethod::None, 1_000),
        (Index(Negative), 0),
        (Stop(Negative), -70_000),
        (Stop(Positive), 80_000),
        (IndexBehindStop(Negative), 0),
        (IndexBehindStop(Positive), 0),
    ] {
        let mut homed = Homed::new(method, 30_000);
        let first = homed.command(START);
        let finds_at_once = matches!(method, Here | HomingMethod::None);
        assert_eq!(bits(&first) == IN_PROGRESS, !finds_at_once, "{method:?}");
        let output = homed.ends();
        assert_eq!(bits(&output), ATTAINED, "{method:?}");
        assert_eq!(homed.home(&output), home, "{method:?}");
        // At rest, where the search has ended.
        let at = homed.bench.input.position_actual;
        (0..100).for_each(|_| _ = homed.step());
        assert_eq!(homed.bench.input.position_actual, at, "{method:?}");
        // A set-point counts from the home position.
        homed.bench.input.mode = Mode::ProfilePosition;
        homed.bench.input.target_position = 5_000;
        homed.command(ENABLE);
        homed.command(START);
        (0..500).for_each(|_| _ = homed.step());
        let (low, high) = homed.stops;
        let expected = (5_000 - homed.step().origin).clamp(low, high);
        assert_eq!(homed.bench.input.position_actual, expected, "{method:?}");
    }
}

#[test]
fn an_index_upward_is_the_next_one_and_one_that_is_here_needs_no_motion() {
    for (at, direction, home) in [
        (-30_000, Direction::Positive, 0),
        (0, Direction::Positive, 0),
        (0, Direction::Negative, 0),
    ] {
        let mut homed = Homed::new(HomingMethod::Index(direction), at);
        homed.command(START);
        let output = homed.ends();
        assert_eq!((bits(&output), homed.home(&output)), (ATTAINED, home));
    }
}

#[test]
fn homing_fails_before_an_index_behind_a_stop_and_where_nothing_draws_current() {
    // The next index upward is at 360,000.
    let mut homed = Homed::new(HomingMethod::Index(Direction::Positive), 30_000);
    homed.command(START);
    let output = homed.ends();
    assert_eq!((bits(&output), output.origin), (FAILED, 0));
    let mut homed = Homed::new(HomingMethod::Stop(Direction::Positive), 30_000);
    homed.pulls = false;
    homed.command(START);
    let output = homed.ends();
    assert_eq!((bits(&output), output.origin), (FAILED, 0));
    assert_eq!(output.following_error, 0, "the demand returns to the motor");
    // It may be started again.
    homed.pulls = true;
    homed.command(ENABLE);
    assert_eq!(bits(&homed.command(START)), IN_PROGRESS);
    assert_eq!(bits(&homed.ends()), ATTAINED);
}

#[test]
fn the_falling_edge_a_halt_a_stop_a_fault_and_another_mode_interrupt_and_leave_the_origin() {
    type Change = fn(&mut Homed);
    let changes: [(Change, bool); 6] = [
        (|homed| homed.bench.input.controlword = ENABLE, true),
        (
            |homed| homed.bench.input.controlword = START | controlword::HALT,
            true,
        ),
        (|homed| homed.bench.input.controlword = 0x0B, false),
        (|homed| homed.bench.input.controlword = 0, false),
        (|homed| homed.bench.input.fault = Fault::Controlled, false),
        (
            |homed| homed.bench.input.mode = Mode::ProfilePosition,
            false,
        ),
    ];
    for (at, (change, stays)) in changes.into_iter().enumerate() {
        let mut homed = Homed::new(HomingMethod::Stop(Direction::Positive), 0);
        homed.command(START);
        (0..50).for_each(|_| _ = homed.step());
        assert!(homed.bench.input.position_actual > 1_000);
        change(&mut homed);
        (0..100).for_each(|_| _ = homed.step());
        let stopped = homed.bench.input.position_actual;
        let output = homed.step();
        assert_eq!(output.origin, 0, "{at}");
        if stays {
            assert_eq!(bits(&output), INTERRUPTED, "{at}");
        }
        // Without an edge nothing goes on.
        homed.bench.input.mode = Mode::Homing;
        homed.bench.input.fault = Fault::None;
        let word = if stays { START } else { ENABLE };
        for word in [0x80, 0x06, 0x07, word] {
            homed.command(word);
        }
        (0..50).for_each(|_| _ = homed.step());
        let way = homed.bench.input.position_actual.abs_diff(stopped);
        assert!(way <= 1_000 || at == 0, "{at}: {way}");
    }
}

#[test]
fn homing_starts_in_operation_enabled_only() {
    for (words, fault) in [
        ([0, 0, 0], Fault::None),
        ([0, 0x06, 0x06], Fault::None),
        ([0x06, 0x07, 0x07], Fault::None),
        ([0x06, 0x0F, 0x0B], Fault::None),
        ([0x06, 0x0F, 0x0F], Fault::Immediate),
    ] {
        let mut bench = Bench::new(Mode::Homing);
        bench.parameters.homing.method = HomingMethod::Here;
        bench.parameters.options.quick_stop.remains_active = true;
        bench.parameters.options.quick_stop.stop = StopOption::Disable;
        bench.input.position_actual = 5_000;
        bench.command(0);
        for word in words {
            bench.command(word);
        }
        bench.input.fault = fault;
        let output = bench.command(words[2] | controlword::START_HOMING);
        assert_ne!(output.state, Cia402State::OperationEnabled);
        assert_eq!(
            (output.origin, bits(&output)),
            (0, IN_PROGRESS),
            "{words:x?}"
        );
    }
}

#[test]
fn a_halt_that_is_released_with_bit_4_starts_in_a_mode_that_was_selected_meanwhile() {
    for method in [HomingMethod::None, HomingMethod::Here] {
        let mut homed = Homed::new(method, 5_000);
        homed.bench.input.mode = Mode::CyclicPosition;
        homed.command(ENABLE);
        homed.command(ENABLE | controlword::HALT);
        homed.bench.input.mode = Mode::Homing;
        for _ in 0..10 {
            let output = homed.command(ENABLE | controlword::HALT);
            assert_ne!(bits(&output), ATTAINED, "{method:?}");
        }
        assert_eq!(bits(&homed.command(START)), ATTAINED, "{method:?}");
    }
    // One that was set before is none.
    let mut homed = Homed::new(HomingMethod::Here, 5_000);
    homed.bench.input.mode = Mode::CyclicPosition;
    homed.command(START);
    homed.bench.input.mode = Mode::Homing;
    assert_ne!(bits(&homed.command(START)), ATTAINED);
}

#[test]
fn what_is_attained_remains_so_until_the_next_start_and_in_other_modes() {
    let mut homed = Homed::new(HomingMethod::Here, 30_000);
    homed.command(START);
    homed.bench.input.mode = Mode::CyclicPosition;
    homed.command(ENABLE);
    homed.bench.input.mode = Mode::Homing;
    for word in [ENABLE, 0, 0] {
        assert_eq!(bits(&homed.command(word)), ATTAINED, "{word:x}");
    }
    homed.bench.parameters.homing.method = HomingMethod::Stop(Direction::Negative);
    for word in [0x06, 0x07, ENABLE] {
        homed.command(word);
    }
    assert_eq!(bits(&homed.command(START)), IN_PROGRESS);
}

#[test]
fn an_axis_may_start_with_an_origin() {
    let mut axis = Axis::<4000>::starting_from(-4_000);
    axis.reset_demand(10_000, 0);
    let parameters = crate::parameters();
    let input = Input {
        mode: Mode::ProfilePosition,
        position_actual: 10_000,
        ..Input::default()
    };
    let mut output = axis.step(input, &parameters);
    for controlword in [0x06, 0x07, ENABLE] {
        output = axis.step(
            Input {
                controlword,
                ..input
            },
            &parameters,
        );
    }
    let demand = Demand::Position {
        position: 6_000,
        velocity: 0,
    };
    assert_eq!((output.demand, output.following_error), (demand, 0));
}
