//! From a line on the communication board's serial port to the motor of an actuator board, and
//! back.

use board_tests::chain::{Chain, run_chain};
use board_tests::comm::Client;
use virtual_board::plant::{Bridge, PERIOD_CYCLES};
use virtual_board::run::{Flow, Options, View};
use virtual_board::trace::Row;

fn no_script() -> impl FnMut(&mut View<'_>) -> Flow + Send {
    |_: &mut View<'_>| Flow::Continue
}

/// The bus is opened at 1 Mbit/s, us.
const OPEN_US: u64 = 20_000;

/// Opens the bus, then sends these lines one after the other, `apart_us` apart.
fn client(apart_us: u64, lines: &[&str]) -> Client {
    let mut plan = vec![(OPEN_US, b"\rC\rS8\rO\r".to_vec())];
    let expected = (1..).zip(lines);
    plan.extend(expected.map(|(number, line)| {
        let at_us = OPEN_US + apart_us * number;
        (at_us, format!("{line}\r").into_bytes())
    }));
    Client::new(plan)
}

fn frames<S>(chain: &Chain<S, Client>, head: &str) -> Vec<String> {
    let lines = chain.comm.script.lines().into_iter();
    lines
        .filter_map(|(_, line)| line.starts_with(head).then_some(line))
        .collect()
}

#[test]
fn two_actuators_respond_through_the_chain_under_their_own_node_ids() {
    let lines = [
        // Identity and node-ID of each, by SDO.
        "t60184018100200000000",
        "t60284002210100000000",
        // Sets the proportional gain of the first, 60FBh:1, to 9.25, for which all parameters are
        // checked together.
        "t601823FB600100001441",
        // Both to OPERATIONAL.
        "t00020100",
    ];
    let chain = run_chain(
        &Options::for_ms(350),
        vec![no_script(), no_script()],
        client(50_000, &lines),
    );
    let answers = ["t58184318100241530000", "t581860FB600100000000"];
    assert_eq!(frames(&chain, "t581"), answers);
    assert_eq!(frames(&chain, "t582"), ["t58284302210102000000"]);
    let telemetry = |node| frames(&chain, &format!("t18{node}")).len();
    // From 220 ms to 350 ms, one per 4 ms.
    assert!((30..=33).contains(&telemetry(1)), "{}", telemetry(1));
    assert_eq!(telemetry(1), telemetry(2));
    assert!(chain.actuators.iter().all(|board| board.resets.is_empty()));
}

/// Instants at which the duty, in either direction, rises above one seventh, ns: PWM edges after a
/// period with less. The first control period of a jump has one fifth, as 60C2h spreads the jump
/// over 20 ms; a shaft at rest needs less than one seventh.
fn onsets(rows: &[Row]) -> Vec<u64> {
    let driven = rows.iter().filter_map(|row| match row.bridge {
        Bridge::Driven { on_cycles, .. } => Some((row.at_ns, on_cycles > PERIOD_CYCLES / 7)),
        Bridge::Brake => Some((row.at_ns, false)),
        Bridge::Coast => None,
    });
    let mut was_more = true;
    let mut onsets = Vec::new();
    for (at_ns, is_more) in driven {
        if is_more && !was_more {
            // A row is recorded at the end of its period.
            onsets.push(at_ns - 1_000_000);
        }
        was_more = is_more;
    }
    onsets
}

/// Jumps of 10 deg and back, a little more than 300 ms apart, so that they cover the phases of a
/// control period.
const JUMPS: u64 = 40;
const APART_US: u64 = 300_100;

/// Limits of `docs/chain.md` from the last byte of a command's line to the PWM edge with its duty,
/// us.
const LEAST_US: u64 = 3_000;
const MOST_US: u64 = 8_000;

#[test]
fn a_command_reaches_the_bridge_within_its_latency_limits_at_any_phase() {
    let mut plan = vec![(OPEN_US, b"\rC\rS8\rO\r".to_vec())];
    // To OPERATIONAL, cyclic synchronous position, no command timeout, as commands are rare in this
    // test, and the three controlwords up to enabled.
    let lines = [
        "t00020100",
        "t60182F60600008000000",
        "t4016060000000000",
        "t4016070000000000",
        "t40160F0000000000",
    ];
    for (number, line) in (1..).zip(lines) {
        plan.push((OPEN_US + 20_000 * number, format!("{line}\r").into()));
    }
    let mut jumps = Vec::new();
    // The first target is the present position.
    for number in 0..=JUMPS {
        let at_us = OPEN_US + 120_000 + APART_US * number;
        let target_mdeg: i32 = if number % 2 == 0 { 0 } else { 10_000 };
        let target = target_mdeg.to_le_bytes().map(|byte| format!("{byte:02X}"));
        let line = format!("t40160F00{}\r", target.concat());
        jumps.push(at_us * 1000 + 5_000 * line.len() as u64);
        // Repeated at 50 Hz until the next jump, as a master does.
        for again in 0..15 {
            plan.push((at_us + 20_000 * again, line.clone().into()));
        }
    }
    let options = Options::for_ms(450 + 301 * JUMPS);
    let chain = run_chain(&options, vec![no_script()], Client::new(plan));
    let onsets = onsets(&chain.actuators[0].trace.rows);
    let mut latencies = Vec::new();
    for jump_ns in &jumps[1..] {
        let onset = onsets
            .iter()
            .find(|onset| *onset > jump_ns)
            .expect("the shaft moves");
        latencies.push((onset - jump_ns) / 1000);
    }
    let (least, most) = (
        latencies.iter().min().expect("some"),
        latencies.iter().max().expect("some"),
    );
    let mean = latencies.iter().sum::<u64>() / JUMPS;
    println!(
        "from the last byte of a command to its duty: {least} us to {most} us, mean {mean} us, {JUMPS} commands"
    );
    assert!(
        (LEAST_US..=MOST_US).contains(least) && (LEAST_US..=MOST_US).contains(most),
        "{latencies:?}"
    );
}
