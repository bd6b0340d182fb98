//! What a tick costs, counted between entry and return.

use board_tests::runs::{run_schedule, to_and_fro};
use virtual_board::rig::RigOptions;
use virtual_board::run::{Options, Span};

/// Interrupts of a tick, and how often each runs in it.
const INTERRUPTS: [(&str, u64); 3] = [("DMA2_STREAM0", 1), ("TIM1_UP_TIM10", 4), ("TIM1_CC", 3)];
const STAGES: [&str; 2] = ["gather", "application_step"];

/// Least and most instructions.
fn ends(spans: &[Span]) -> (u64, u64) {
    let counts = || spans.iter().map(|span| span.instructions);
    (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
}

#[test]
fn the_whole_tick_stays_below_3000_instructions_over_a_minute() {
    let names = INTERRUPTS.iter().map(|(name, _)| *name).chain(STAGES);
    let options = Options {
        rig: RigOptions::realistic(3),
        probes: names.map(str::to_owned).collect(),
        keeps_trace: false,
        ..Options::for_ms(60_000)
    };
    let finished = run_schedule(options, to_and_fro);
    for (name, spans) in &finished.spans {
        let (least, most) = ends(spans);
        println!(
            "{name:18} {:6} calls, {least:5} to {most:5} instructions",
            spans.len()
        );
        assert!(spans.len() > 14_000, "{name}");
    }
    let tick: u64 = (INTERRUPTS.iter())
        .map(|(name, times)| times * ends(&finished.spans[*name]).1)
        .sum();
    println!("a tick of the worst of each: {tick} instructions");
    assert!(tick < 3_000, "{tick}");
}

#[test]
fn the_samples_are_taken_at_their_instants() {
    let options = Options {
        probes: vec!["TIM1_CC".into(), "TIM1_UP_TIM10".into()],
        ..Options::for_ms(1000)
    };
    let finished = run_schedule(options, to_and_fro);
    let edges_ns: Vec<u64> = finished.trace.rows.iter().map(|row| row.at_ns).collect();
    let within_us = |span: &Span| {
        let edge = edges_ns.partition_point(|edge_ns| *edge_ns <= span.at_ns + 20);
        let edge_ns = edge
            .checked_sub(1)
            .map_or(edges_ns[0] - 1_000_000, |i| edges_ns[i]);
        (span.at_ns as f64 - edge_ns as f64) / 1e3
    };
    // Entry into the interrupt takes below a microsecond; an edge is known to a count, 18 ns.
    let near = |at_us: f64, instant_us: f64| (-0.02..1.0).contains(&(at_us - instant_us));
    let instants: Vec<f64> = finished.spans["TIM1_CC"].iter().map(within_us).collect();
    for tick @ [current, window, back_emf] in instants.as_chunks::<3>().0 {
        assert!(
            *current <= 501.0,
            "the current in the middle of the on time: {tick:?}"
        );
        assert!(near(*window, 900.0), "the window opens: {tick:?}");
        assert!(near(*back_emf, 975.0), "the back-EMF is sampled: {tick:?}");
    }
    let edges = finished.spans["TIM1_UP_TIM10"].iter().map(within_us);
    assert!(edges.skip(1).all(|at_us| near(at_us, 0.0)));
}
