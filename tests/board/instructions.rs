//! Instructions of a control period, counted between entry and return of its handlers.

use std::fs;

use board_tests::frames::{
    Frame, control, faults, is_operation_enabled, mode, responses, statuswords, velocity, write,
    write_real,
};
use board_tests::master::{ENABLED_TICK, Master, driven, to_and_fro};
use board_tests::program::{LOOP_PRIORITY, firmware, handlers, run_master, run_script};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Finished, Flow, Options, Script, Span, View};

/// Parts of the control step and of the comparison.
const STAGES: [&str; 2] = ["finish_sampling", "second_copy"];

/// The interrupt whose handler begins a control period.
const STEP: &str = "DMA2_STREAM0";

/// The interrupts of the handlers of the loop, which nothing delays.
fn of_the_loop() -> Vec<String> {
    let handlers = handlers().into_iter();
    let of_the_loop = handlers.filter(|handler| handler.priority == LOOP_PRIORITY);
    of_the_loop.map(|handler| handler.interrupt).collect()
}

/// The interrupts of the two copies of the control step, with the comparison.
fn copies() -> Vec<String> {
    let is_copy = |task: &str| ["control_step", "comparison"].contains(&task);
    let handlers = handlers().into_iter();
    let copies = handlers.filter(|handler| is_copy(&handler.task));
    let copies: Vec<String> = copies.map(|handler| handler.interrupt).collect();
    assert_eq!(copies.len(), 2);
    copies
}

/// The interrupts of all handlers.
fn all() -> Vec<String> {
    handlers()
        .into_iter()
        .map(|handler| handler.interrupt)
        .collect()
}

/// Functions of the control law, by parts of their mangled names.
const CONTROL_LAW: [&str; 2] = [
    "cascade.*CascadeState.*7observe",
    "cascade.*CascadeState.*5close",
];

/// The full name of the function whose name contains these parts.
fn function(pieces: &str) -> String {
    let has_all = |name: &&str| pieces.split(".*").all(|piece| name.contains(piece));
    let name = firmware().functions().find(has_all);
    name.unwrap_or_else(|| panic!("no {pieces}")).to_owned()
}

/// Least and most instructions.
fn range(spans: &[Span]) -> (u64, u64) {
    let counts = || spans.iter().map(|span| span.instructions);
    (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
}

/// Instructions of each control period, from a control step to the next one, in the handlers of
/// some interrupts.
fn periods<S>(
    finished: &Finished<S>,
    interrupts: &[String],
    is_counted: impl Fn(u64) -> bool,
) -> Vec<u64> {
    let begins: Vec<u64> = finished.spans[STEP].iter().map(|span| span.at_ns).collect();
    let mut sums = vec![0; begins.len()];
    for span in interrupts.iter().flat_map(|name| &finished.spans[name]) {
        let tick = begins.partition_point(|begin| *begin <= span.at_ns);
        if let Some(tick) = tick.checked_sub(1).filter(|_| is_counted(span.at_ns)) {
            sums[tick] += span.instructions;
        }
    }
    sums
}

/// Instructions in the worst control period, of the handlers of some interrupts.
fn worst_of<S>(
    finished: &Finished<S>,
    interrupts: &[String],
    is_counted: impl Fn(u64) -> bool,
) -> u64 {
    let sums = periods(finished, interrupts, is_counted);
    sums.into_iter().max().unwrap_or(0)
}

/// Instructions of the loop in the worst control period.
fn worst<S>(finished: &Finished<S>, is_counted: impl Fn(u64) -> bool) -> u64 {
    worst_of(finished, &of_the_loop(), is_counted)
}

/// Instructions of the loop in a control period, at most: both copies and the comparison, PWM edges
/// and sampling instants; 46 us of the 4 ms at 168 MHz.
const MOST_INSTRUCTIONS: u64 = 7_750;

/// Instructions of control step and comparison.
const MOST_IN_BOTH_COPIES: u64 = 7_350;

/// Mean of the instructions of all handlers in a control period.
const MEAN_INSTRUCTIONS: u64 = 14_900;

/// Reads the longest step as the board itself measures it.
struct OwnCount<F> {
    master: Master<F>,
    longest: u32,
}

impl<F: Fn(u64) -> Vec<Frame> + Send> Script for OwnCount<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let address = firmware().address("LONGEST_STEP").expect("a symbol");
        self.longest = view.word(address).expect("memory");
        self.master.at_edge(view)
    }
}

#[test]
fn the_instructions_of_a_control_period_stay_within_their_limits_over_a_minute() {
    let names = all().into_iter().chain(STAGES.map(str::to_owned));
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        probes: names.chain(CONTROL_LAW.map(function)).collect(),
        keeps_trace: false,
        ..Options::for_ms(60_000)
    };
    let script = OwnCount {
        master: Master::new(|tick| driven(tick, to_and_fro(tick))),
        longest: 0,
    };
    let finished = run_script(options, script);
    for (name, spans) in &finished.spans {
        let (least, most) = range(spans);
        let sum: u64 = spans.iter().map(|span| span.instructions).sum();
        let each = sum / (60_000 / firmware::timing::CONTROL_PERIOD_MS as u64);
        println!(
            "{name:18} {:6} runs, {least:5} to {most:5} instructions, {each:5} in a control period",
            spans.len()
        );
    }
    let periods_of = |interrupts: &[String]| periods(&finished, interrupts, |_| true);
    let both = periods_of(&copies()).into_iter().max().unwrap_or(0);
    let of_the_loop = worst(&finished, |_| true);
    let whole = periods_of(&all());
    let most = whole.iter().max().unwrap_or(&0);
    let mean = whole.iter().sum::<u64>() / whole.len() as u64;
    println!(
        "control step and comparison: {both}; the loop: {of_the_loop}; all handlers: {most} in the \
         worst control period, {mean} in the mean"
    );
    assert!(both <= MOST_IN_BOTH_COPIES, "{both}");
    assert!(of_the_loop <= MOST_INSTRUCTIONS, "{of_the_loop}");
    assert!(mean <= MEAN_INSTRUCTIONS, "{mean}");

    // DWT counts cycles of the core's clock, and an instruction takes one cycle on the emulator.
    // The board counts from the start of the sampling until the copies have been compared.
    let own = u64::from(finished.script.longest);
    let around = both.abs_diff(own);
    println!("longest control step by the board's own DWT: {own} cycles, {around} around it");
    // The sampling before it, and the messages behind it.
    assert!(around < 450, "{around}");
}

/// Narrow limits, as objects and values: position, deg; rate, deg/s; duty, %; its slew rate, %/s.
const NARROW: [(u16, u8, f32); 6] = [
    (0x2010, 5, -8.0),
    (0x2010, 6, 8.0),
    (0x60FB, 2, 30.0),
    (0x60FB, 3, 30.0),
    (0x60F9, 6, 40.0),
    (0x60F9, 7, 2_000.0),
];

/// Alternating targets, with narrow limits or the default ones.
fn limited(narrow: bool, tick: u64) -> Vec<Frame> {
    match tick {
        10 if narrow => NARROW
            .map(|(index, sub, value)| write_real(index, sub, value))
            .into(),
        _ => driven(tick, to_and_fro(tick)),
    }
}

#[test]
fn the_control_law_stays_below_300_instructions_with_any_active_limit() {
    for (limits, narrow) in [("wide", false), ("narrow", true)] {
        let options = Options {
            plant: BoardPlantOptions::realistic(3),
            probes: CONTROL_LAW.map(function).into(),
            ..Options::for_ms(10_000)
        };
        let finished = run_master(options, move |tick| limited(narrow, tick));
        let [(_, observe), (_, regulate)] =
            CONTROL_LAW.map(|part| range(&finished.spans[&function(part)]));
        let law = observe + regulate;
        println!("{limits} limits: {observe} + {regulate} = {law} instructions at most");
        assert!(observe > 0 && regulate > 0 && law < 300, "{law}");
        let furthest = finished.trace.rows.iter().map(|row| row.angle_deg);
        let furthest_deg = furthest.fold(0.0, f64::max);
        assert_eq!(narrow, furthest_deg < 9.0, "{furthest_deg} deg");
    }
}

/// Each excitation of the board for half a second, around a constant target.
fn excitations(tick: u64) -> Vec<Frame> {
    let since = tick.saturating_sub(100);
    match (tick, since % 125) {
        // The longest shift register takes the longest; a multisine has the maximum number of lines
        // by default.
        (10, _) => vec![write(0x2020, 10, 16, 4)],
        (100.., 0) => vec![write(0x2020, 3, (since / 125) as u32, 4), control(0x0f, 0)],
        (100.., 3) => vec![write(0x2020, 1, 1, 1)],
        (ENABLED_TICK.., _) if tick.is_multiple_of(5) => vec![control(0x0f, 0)],
        _ => driven(tick, 0),
    }
}

#[test]
fn with_any_excitation_of_the_board_the_loop_stays_within_its_limit() {
    let options = Options {
        probes: of_the_loop(),
        ..Options::for_ms(4 * (100 + 10 * 125))
    };
    let finished = run_master(options, excitations);
    let (_, last) = *statuswords(&finished).last().expect("the board reports");
    assert!(is_operation_enabled(last), "{last:04x}");
    assert_eq!(faults(&finished), []);
    // From the start of the excitation until the next one is configured.
    let from_ns = |shape: u64| (100 + shape * 125) * 4_000_000;
    for shape in 0..10 {
        let running = from_ns(shape) + 60_000_000..from_ns(shape + 1) - 20_000_000;
        let tick = worst(&finished, |at_ns| running.contains(&at_ns));
        println!("excitation {shape}: {tick} instructions at most");
        assert!(tick > 2_000, "the excitation runs");
    }
    let tick = worst(&finished, |_| true);
    println!("with those in which one is set and started: {tick}");
    // Both copies take the new parameters, which are checked as a whole.
    assert!(tick < MOST_INSTRUCTIONS + 3_000, "{tick}");
}

/// Modes of operation.
const MODES: [u8; 7] = [1, 3, 4, 7, 8, 9, 10];

/// Instructions of control step and comparison in a control period in which a mode decelerates:
/// the velocity from which the axis still stops at a target or before a limit takes a root and
/// divisions of 64 bits.
const WITH_A_STOP: u64 = 8_050;

/// The same with everything on.
const WITH_EVERYTHING: u64 = 9_000;

/// Index, sub-index, value and bytes of an object.
type Object = (u16, u8, u32, u8);

/// Objects that are 0 by default: feed-forward of velocity and model, the dead band, the observer
/// of the rate, the correction of the encoder, offsets of velocity and torque, polarity, jerk-limited
/// profiles. The model of 2010h:2 runs outside the loop.
const EVERYTHING: [Object; 9] = [
    (0x2013, 1, 1_000, 2),
    (0x2013, 2, 1_000, 2),
    (0x2013, 3, 132, 2),
    (0x2013, 4, 1, 1),
    (0x2014, 1, 500, 2),
    (0x60B1, 0, 5_000, 4),
    (0x60B2, 0, 10, 2),
    (0x607E, 0, 0xC0, 1),
    (0x6086, 0, 3, 2),
];

/// Each mode of operation for a second: set-points and points to and fro, velocities and torques
/// into both position limits, and changes of mode while the shaft turns. These objects are written
/// before.
fn modes(tick: u64, objects: &[Object]) -> Vec<Frame> {
    let since = tick.saturating_sub(100);
    let code = MODES[(since / 250) as usize % MODES.len()];
    let sign = if (since / 100).is_multiple_of(2) {
        1
    } else {
        -1
    };
    // A new set-point in profile position mode, in the other modes no bit of theirs.
    let word = match code {
        1 if tick.is_multiple_of(10) => 0x3f,
        7 => 0x1f,
        _ => 0x0f,
    };
    let torque = (sign as i16 * 200) as u16;
    match tick {
        8..=16 => {
            let object = objects.get(tick as usize - 8);
            let frame = |&(index, sub, value, size)| write(index, sub, value, size);
            object.map(frame).into_iter().collect()
        }
        100.. if tick % 10 == 2 => vec![write(0x6071, 0, torque.into(), 2)],
        100.. if tick % 10 == 7 => vec![write(0x60C1, 1, (sign * 40_000) as u32, 4)],
        100.. if tick.is_multiple_of(5) => vec![
            mode(word, code as i8),
            velocity(word, sign * 250_000),
            control(word, sign * 40_000),
        ],
        100.. => Vec::new(),
        _ => driven(tick, 0),
    }
}

/// Most instructions of control step and comparison, and of the loop, in each mode.
fn most_in_modes(objects: &'static [Object]) -> Vec<(u8, u64, u64)> {
    let options = Options {
        probes: of_the_loop(),
        ..Options::for_ms(4 * (100 + MODES.len() as u64 * 250))
    };
    let finished = run_master(options, move |tick| modes(tick, objects));
    let (_, last) = *statuswords(&finished).last().expect("the board reports");
    assert!(is_operation_enabled(last), "{last:04x}");
    assert_eq!(faults(&finished), []);
    let aborts = responses(&finished).into_iter().filter(|it| it[0] == 0x80);
    assert_eq!(aborts.count(), 0);
    let most = |(mode, from): (u8, u64)| {
        // The control period in which the mode changes belongs to the one before.
        let running = (from + 1) * 4_000_000..(from + 251) * 4_000_000;
        let is_counted = |at_ns| running.contains(&at_ns);
        let both = worst_of(&finished, &copies(), is_counted);
        (mode, both, worst(&finished, is_counted))
    };
    MODES
        .into_iter()
        .zip((100..).step_by(250))
        .map(most)
        .collect()
}

#[test]
fn no_mode_of_operation_takes_the_loop_beyond_its_limit() {
    let mut wrong = false;
    for (objects, limit) in [(&[][..], WITH_A_STOP), (&EVERYTHING, WITH_EVERYTHING)] {
        for (mode, both, of_the_loop) in most_in_modes(objects) {
            println!(
                "mode {mode}, {} options: control step and comparison {both}, loop {of_the_loop}",
                objects.len()
            );
            wrong |= !(2_000..limit).contains(&both);
            wrong |= of_the_loop - both > MOST_INSTRUCTIONS - MOST_IN_BOTH_COPIES;
        }
    }
    assert!(!wrong);
}

/// Instructions that an option alone adds to control step and comparison, at most: those of an
/// offset of the torque in cyclic position mode.
const MOST_OF_AN_OPTION: u64 = 650;

/// The counts that are published.
const PUBLISHED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../golden/options.csv");

#[test]
fn each_option_of_the_loop_alone_takes_the_published_instructions() {
    let without = most_in_modes(&[]);
    let mut counts =
        String::from("option,most instructions added to control step and comparison\n");
    for option in EVERYTHING.chunks(1) {
        let added = most_in_modes(option).into_iter().zip(&without);
        let added: Vec<u64> = added
            .map(|(with, without)| with.1.saturating_sub(without.1))
            .collect();
        let most = added.iter().copied().max().unwrap_or(0);
        println!(
            "{:04X}h:{}: {most} at most, by mode {added:?}",
            option[0].0, option[0].1
        );
        assert!(most < MOST_OF_AN_OPTION, "{most}");
        counts += &format!("{:04X}h:{},{most}\n", option[0].0, option[0].1);
    }
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(PUBLISHED, &counts).expect("a file");
    }
    let published = fs::read_to_string(PUBLISHED).expect("a file");
    assert_eq!(published, counts, "if that is intended: UPDATE_GOLDEN=1");
}

#[test]
fn the_samples_are_taken_at_their_instants() {
    let options = Options {
        probes: vec!["TIM1_CC".into(), "TIM1_UP_TIM10".into()],
        ..Options::for_ms(1000)
    };
    let finished = run_master(options, |tick| driven(tick, to_and_fro(tick)));
    let edges_ns: Vec<u64> = finished.trace.rows.iter().map(|row| row.at_ns).collect();
    let within_us = |span: &Span| {
        let edge = edges_ns.partition_point(|edge_ns| *edge_ns <= span.at_ns + 20);
        let edge_ns = edge
            .checked_sub(1)
            .map_or(edges_ns[0] - 1_000_000, |i| edges_ns[i]);
        (span.at_ns as f64 - edge_ns as f64) / 1e3
    };
    // Entry into the interrupt takes less than a microsecond; the resolution of an edge is a count,
    // 18 ns.
    let near = |at_us: f64, instant_us: f64| (-0.02..1.0).contains(&(at_us - instant_us));
    let instants: Vec<f64> = finished.spans["TIM1_CC"].iter().map(within_us).collect();
    for tick @ [current, window, back_emf] in instants.as_chunks::<3>().0 {
        assert!(
            *current <= 501.0,
            "the current in the middle of the on time: {tick:?}"
        );
        assert!(near(*window, 800.0), "the window opens: {tick:?}");
        assert!(near(*back_emf, 975.0), "the back-EMF is sampled: {tick:?}");
    }
    let edges = finished.spans["TIM1_UP_TIM10"].iter().map(within_us);
    assert!(edges.skip(1).all(|at_us| near(at_us, 0.0)));
}
