//! What is counted.

use std::{hint::black_box, io::Write as _, path::Path};

use canopen::{CanFrame, NodeId};
use host_sim::{
    can::native_node::{NativeNode, PERIOD_US},
    scenario::{Scenario, Setting},
    settings::{ModelKind, PlantKind},
    simulate::{Simulation, extremes::campaign},
};
use identification::{
    Experiment, Options, Problem, Quiet,
    data::Import,
    fit, models,
    synthetic::{noisy, simulated},
};
use model_core::control::{
    cascade::{CascadeState, Coefficients},
    encoder_word::{EncoderCount, EncoderWord, Magnet},
    units::angle,
};

/// Time-critical code.
#[derive(Debug)]
pub struct Workload {
    /// Its name in the golden file.
    pub name: &'static str,
    /// Its equal parts: steps, control periods, lines.
    pub parts: u64,
    /// Prepares it, and runs it in [`counted_work`].
    pub run: fn(),
}

const STEPS: u64 = 10_000;
const PERIODS_OF_60_S: u64 = 15_000;
/// A simulated second each: 60 s would take valgrind minutes.
const BATCH: u64 = 1_000;
const PERIODS_OF_1_S: u64 = 250;
/// Two groups of benches that are computed side by side.
const BENCHES: u64 = 64;
const READS: u64 = 100;
/// A tenth of a million: in valgrind a million takes half a minute, and the lines are alike.
const LINES: u64 = 100_000;

/// All of them. `valgrind` has no AVX-512, so that processors with and without it count alike.
pub static WORKLOADS: [Workload; 12] = [
    Workload {
        name: "control-step",
        parts: STEPS,
        run: control_step,
    },
    Workload {
        name: "board-loop-60-s-at-50-us",
        parts: PERIODS_OF_60_S,
        run: || board_loop(1),
    },
    Workload {
        name: "board-loop-60-s-at-1-ms",
        parts: PERIODS_OF_60_S,
        run: || board_loop(20),
    },
    Workload {
        name: "batch-of-1000-at-50-us",
        parts: BATCH * PERIODS_OF_1_S,
        run: || batch(1),
    },
    Workload {
        name: "batch-of-1000-at-1-ms",
        parts: BATCH * PERIODS_OF_1_S,
        run: || batch(20),
    },
    Workload {
        name: "bench-plant-1-s",
        parts: PERIODS_OF_1_S,
        run: bench_plant,
    },
    Workload {
        name: "campaign-of-64-benches-1-s",
        parts: BENCHES * PERIODS_OF_1_S,
        run: benches,
    },
    Workload {
        name: "fit-black-box-1",
        parts: 1,
        run: || fitted("black-box-1"),
    },
    Workload {
        name: "fit-black-box-2",
        parts: 1,
        run: || fitted("black-box-2"),
    },
    Workload {
        name: "fit-grey-box",
        parts: 1,
        run: || fitted("grey-box"),
    },
    Workload {
        name: "sdo-read",
        parts: READS,
        run: sdo_read,
    },
    Workload {
        name: "parse-100000-lines",
        parts: LINES,
        run: parse,
    },
];

/// The only function whose instructions count, with all that it calls.
#[inline(never)]
fn counted_work(work: &mut dyn FnMut()) {
    work();
}

/// From the word of the encoder to the duty.
fn control_step() {
    let gains = Coefficients::try_new(&Default::default()).expect("the defaults");
    let mut state = CascadeState::default();
    let words: Vec<_> = (0..STEPS as u16)
        .map(|k| EncoderWord::of(EncoderCount::new(k.wrapping_mul(7) >> 3), Magnet::Steady))
        .collect();
    let gains = black_box(gains);
    counted_work(&mut || {
        for word in &words {
            let count = word.read().ok().map(|reading| reading.count);
            state.observe(&gains, count);
            black_box(state.regulate(&gains, angle(60.0)).duty);
        }
    });
}

fn simulation(duration_s: f64, every: u64, plant: PlantKind, gain: f64) -> Simulation {
    let mut set = vec![Setting::new("input.dwell_s", duration_s / 15.0)];
    if plant == PlantKind::FirstOrder {
        set.push(Setting::new("motor_gain_up", gain));
    }
    let scenario = Scenario {
        model: Some(ModelKind::Board),
        plant: Some(plant),
        input: Some("variable-step".into()),
        duration_s: Some(duration_s),
        every: Some(every),
        set,
        ..Default::default()
    };
    scenario.resolve().expect("a scenario")
}

fn board_loop(every: u64) {
    let simulation = simulation(60.0, every, PlantKind::FirstOrder, 2.836);
    counted_work(&mut || {
        black_box(simulation.extremes().expect("a run"));
    });
}

fn batch(every: u64) {
    let simulations: Vec<_> = (0..BATCH)
        .map(|k| simulation(1.0, every, PlantKind::FirstOrder, 2.5 + k as f64 * 5e-4))
        .collect();
    on_this_thread(|| {
        counted_work(&mut || {
            black_box(campaign(&simulations));
        });
    });
}

fn bench_plant() {
    let simulation = simulation(1.0, 1, PlantKind::Drivetrain, 0.0);
    counted_work(&mut || {
        black_box(simulation.extremes().expect("a run"));
    });
}

/// Benches that differ in friction.
fn benches() {
    let bench = |k: u64| {
        let mut bench = simulation(1.0, 1, PlantKind::Drivetrain, 0.0);
        bench.settings.drivetrain.friction.coulomb_friction_nm += k as f64 * 1e-4;
        bench
    };
    let simulations: Vec<_> = (0..BENCHES).map(bench).collect();
    on_this_thread(|| {
        counted_work(&mut || {
            black_box(campaign(&simulations));
        });
    });
}

/// A fit of a model to its own noisy pulse at 250 Hz: 1,250 samples, eight starts.
fn fitted(name: &str) {
    let model = models::named(name).expect("a model");
    let kind = match name {
        "black-box-1" => ModelKind::BlackBox1,
        "black-box-2" => ModelKind::BlackBox2,
        _ => ModelKind::GreyBox,
    };
    let recording = noisy(simulated(kind, "pulse", 80, &[]).expect("a run"), 1);
    let run = Experiment::try_new(recording).expect("a recording");
    let problem = Problem::try_new(model, vec![run]).expect("a problem");
    on_this_thread(|| {
        counted_work(&mut || {
            black_box(fit(&problem, &Options::default(), &Quiet).expect("a fit"));
        });
    });
}

/// Reads of the statusword, from the request to the answer.
fn sdo_read() {
    let mut buffer = vec![0; host_sim::can::native_node::CAPTURE_VALUES];
    let id = NodeId::new(1).expect("a node-ID");
    let mut node = NativeNode::new(1, Some(id), &Default::default(), &mut buffer).expect("a node");
    let mut now_us = 0;
    for _ in 0..250 {
        now_us += PERIOD_US;
        node.step(now_us);
        while node.transmit().is_some() {}
    }
    let request = CanFrame::raw(0x601, false, false, 8, [0x40, 0x41, 0x60, 0, 0, 0, 0, 0]);
    let request = request.expect("a frame");
    counted_work(&mut || {
        for _ in 0..READS {
            node.receive(&request);
            let answer = node.transmit();
            assert!(answer.is_some(), "the server answers at once");
            black_box(answer);
        }
    });
}

/// A recording with a time, a command and an angle in each line.
fn parse() {
    let mut file = tempfile::Builder::new()
        .suffix(".csv")
        .tempfile()
        .expect("a file");
    let mut text = String::from("time_s,command_deg,angle_deg\n");
    for k in 0..LINES {
        let time_s = k as f64 * 0.004;
        let wave = (time_s * 3.0).sin();
        text += &format!(
            "{time_s:.3},{:.1},{:.9}\n",
            30.0 * wave.signum(),
            20.0 * wave
        );
    }
    file.write_all(text.as_bytes()).expect("room for the file");
    let path: &Path = file.path();
    counted_work(&mut || {
        black_box(
            Import::default()
                .read(path, &mut |_, _| {})
                .expect("a recording"),
        );
    });
}

/// Runs parallel work on the calling thread, which is the one that is counted.
fn on_this_thread(work: impl FnOnce() + Send) {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    pool.build().expect("a pool of this thread").install(work);
}
