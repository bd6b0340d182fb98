//! The page of the figures.

use std::process::Command;

use model_core::time::CONTROL_RATE_HZ;

use super::bench::Bench;
use super::{SETUPS, fitted, margin, rows, rows_of};

/// The commit of the sources.
fn commit() -> std::io::Result<String> {
    let output = Command::new("git")
        .args(["rev-parse", "--short", "HEAD"])
        .output()?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// A figure, if there is one.
fn cell(value: f64) -> String {
    if value.is_nan() {
        "none".to_owned()
    } else {
        format!("{value:.2}")
    }
}

/// The page with its table.
pub fn page() -> std::io::Result<String> {
    let commit = commit()?;
    let [paper, with, observed] = SETUPS.map(|setup| setup.name);
    let expected = margin::expected();
    let mut page = format!(
        "# {TITLE}\n\nWritten by `{COMMAND}` at commit {commit}.\n\n{TEXT}\n\
         The linear model of the paper's loop, with the delay of the encoder, has margins of {:.1} deg \
         and {:.1} dB.\n\n{RATES}\n\
         | | {paper} | {with} | {observed} |\n|---|---|---|---|\n",
        expected.phase_deg, expected.gain_db
    );
    for (name, [paper, with, observed]) in rows() {
        let [paper, with, observed] = [paper, with, observed].map(cell);
        page += &format!("| {name} | {paper} | {with} | {observed} |\n");
    }
    if IS_PAPERS {
        page += &other_benches();
    }
    page += &format!("\n![Targets at 50 Hz]({NAME}.svg)\n");
    Ok(page)
}

/// The table of other benches, in each cell the three loops.
fn other_benches() -> String {
    let benches = [Bench::at(5.0), Bench::at(7.4), Bench::FITTED];
    let [low, high, fitted] = benches.map(rows_of);
    let mut table = format!(
        "\nThe three loops at other voltages of the source, and with the fitted motor:\n\n\
         | | 5.0 V | 7.4 V | {} |\n|---|---|---|---|\n",
        fitted::NAME
    );
    for ((row, high), fitted) in low.into_iter().zip(high).zip(fitted) {
        let cells = [row.1, high.1, fitted.1].map(|loops| loops.map(cell).join(" / "));
        table += &format!("| {} | {} |\n", row.0, cells.join(" | "));
    }
    table
}

/// Whether the rates are those of the paper.
pub const IS_PAPERS: bool = CONTROL_RATE_HZ == 250;

/// Name of the page.
pub const NAME: &str = if IS_PAPERS {
    "tracking"
} else {
    "tracking-1-khz"
};

const TITLE: &str = if IS_PAPERS {
    "Tracking"
} else {
    "Tracking with a loop at 1 kHz"
};

const COMMAND: &str = if IS_PAPERS {
    "cargo run --release -p tracking"
} else {
    "ACTUATOR_RATES_1_KHZ=1 cargo run --release -p tracking --target-dir target/rates"
};

/// What the page says of its rates.
const RATES: &str = if IS_PAPERS {
    "\
The control step runs at 250 Hz and the PWM at 1 kHz; [here](tracking-1-khz.md) at 1 kHz and 20 kHz.
"
} else {
    "\
This is the second set of rates: the control step runs at 1 kHz and the PWM at 20 kHz, with the gains and
the time constant of the rate filter of the first set. The current no longer pulses, so
that less copper loss makes the same torque. With feed-forward the shaft is ahead of the demand by the
delays of the loop. At 250 Hz that compensates part of the interval of targets at 50 Hz, at 1 kHz it does
not: see the line with the command of 20 ms before.
"
};

/// What the page says of loops, drives and motions, once for both.
const TEXT: &str = if IS_PAPERS {
    "\
Object 2013h adds to the loop of the paper, in shares of 0.1 %:

- 1: the velocity of the demand to the rate of the position loop;
- 2: the voltage that the motor of 2011h needs for the demand, at the present supply, to the duty;
- 3: a dead band (mdeg) within which an unloaded shaft at rest gets no duty;
- 4: 1 for an observer of the rate: it changes with the back-EMF, which shows 0.1 deg/s without a lag where a
  count in a control period is 22 deg/s, and follows the encoder with 80 ms. In periods without a back-EMF
  it is the filtered difference of the encoder.

Object 2014h subtracts the error of the encoder once and twice a turn, here that of the plant.

All are 0 by default; 2011h has to describe the motor. `tests/golden/options.csv` has the instructions of
each. The third column has 4, and twice the gains: 60FBh:1 of 16/s, 60F9h:1 x 2 and 60F9h:2 x 4, with
less noise of the duty than the paper's loop. Here 1 and 2 are 1000 and 3 is 132: half a count of quantisation,
and a count of noise. Cyclic targets need 60C2h:1 at their interval. The margins are those of the loop that
runs: a sine is added to the duty, so that the paths by encoder and back-EMF both count, up to 93 Hz.

Means of 10 drives with noise, friction, magnet and supply of their seeds, natively, of motions and steps
the greatest; the error is that of the shaft against the command at the same time, where nothing else is
said in moves by half a cosine of up to 157 deg/s. Inertia and friction of the fitted motor are
those of two recordings (`host_sim::servo_bus`): 2011h has it, and 60F9h:1 and 2 are in proportion to the duty
of a rate. In a line with a difference the plant has it, and 2011h
does not. With 1 deg of play the error is hardly larger: a compensation of the play would not reduce it.
"
} else {
    "\
Loops, drives and motions are those of the [first set of rates](tracking.md).
"
};
