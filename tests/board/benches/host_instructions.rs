//! Instructions of this computer for a control period of the emulated board in closed loop, counted
//! by `valgrind --tool=callgrind` and compared with a golden count.
//!
//!     cargo bench -p board-tests --bench host_instructions --profile dev --ignore-rust-version
//!
//! The profile is that of the tests, so that nothing is built for it alone.
//!
//! The program runs itself in valgrind. What it counts begins at [`begin_counting`]; the
//! translation of the board's program is counted apart, since each part of it is translated once.

use std::{fs, process::Command};

use board_tests::master::{Master, PERIODS, driven, to_and_fro};
use board_tests::program::{firmware, run_script};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Flow, Options, Script, View};

/// Virtual time, ms: by the first the drive moves and the program has been translated.
const BEGIN_MS: u64 = 500;
const END_MS: u64 = 1_000;

/// Control periods that are counted.
const COUNTED: u64 = (END_MS - BEGIN_MS) / PERIODS;

/// Relative difference from the golden count that is accepted: which blocks of the program are
/// translated a second time, for speed, depends on how often each has run.
const TOLERANCE: f64 = 0.05;

const GOLDEN: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../golden/emulated-instructions.txt"
);

/// End of the name of the emulator's function that translates.
const TRANSLATES: &str = "armv7m::translate::translate";

/// The argument with which the program runs itself.
const WORK: &str = "work";

/// Seed of the plant's noise.
const SEED: u64 = 1;

/// Valgrind counts from its call on.
#[inline(never)]
fn begin_counting() {
    std::hint::black_box(());
}

struct Counted<F> {
    master: Master<F>,
    period: u64,
}

impl<F: Fn(u64) -> Vec<board_tests::frames::Frame> + Send> Script for Counted<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if self.period == BEGIN_MS {
            begin_counting();
        }
        self.period += 1;
        self.master.at_edge(view)
    }
}

fn work() {
    let options = Options {
        plant: BoardPlantOptions::realistic(SEED),
        keeps_trace: false,
        ..Options::for_ms(END_MS)
    };
    let script = Counted {
        master: Master::new(|tick| driven(tick, to_and_fro(tick))),
        period: 0,
    };
    run_script(options, script);
}

/// Counts all instructions from [`begin_counting`] on, and those of the translation among them.
fn count() -> (u64, u64) {
    let out = std::env::temp_dir().join(format!("host-instructions-{}", std::process::id()));
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--zero-before=*begin_counting*"])
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(std::env::current_exe().expect("the path of this program"))
        .arg(WORK)
        .output()
        .expect("valgrind is installed");
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{log}");
    let profile = fs::read_to_string(&out).expect("valgrind wrote its counts");
    fs::remove_file(&out).expect("the file is there");
    let total = profile
        .lines()
        .find_map(|line| line.strip_prefix("totals: "));
    let total = total.and_then(|count| count.trim().parse().ok());
    (total.expect("a total"), inclusive(&profile, TRANSLATES))
}

/// Instructions of the calls of a function, with all that it calls: a line `cfn=(number) name`,
/// with the name at the first only, a line `calls=`, and a line with place and count.
fn inclusive(profile: &str, name: &str) -> u64 {
    let mut own = None;
    let mut sum = 0;
    let mut called = None;
    let mut lines = profile.lines();
    while let Some(line) = lines.next() {
        let function = line.strip_prefix("cfn=").or(line.strip_prefix("fn="));
        if let Some((number, text)) =
            function.map(|text| text.split_once(' ').unwrap_or((text, "")))
        {
            own = own.or(text.ends_with(name).then_some(number));
            called = Some(number);
        } else if line.starts_with("calls=") {
            let count = lines.next().and_then(|cost| cost.split_once(' '));
            let count = count.and_then(|(_, count)| count.parse::<u64>().ok());
            if own.is_some() && called == own {
                sum += count.unwrap_or(0);
            }
        }
    }
    sum
}

fn main() {
    firmware();
    if std::env::args().any(|argument| argument == WORK) {
        return work();
    }
    let (total, translation) = count();
    assert_ne!(
        translation, 0,
        "no calls of {TRANSLATES} are in the profile"
    );
    let counted = (total - translation) / COUNTED;
    println!(
        "{counted} instructions in a control period of the emulated board, and {} of translation",
        translation / COUNTED
    );
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(GOLDEN, format!("{counted}\n")).expect("the golden file is written");
        return;
    }
    let golden: f64 = fs::read_to_string(GOLDEN)
        .expect("a golden count")
        .trim()
        .parse()
        .expect("a number");
    let change = counted as f64 / golden - 1.0;
    assert!(change.abs() <= TOLERANCE, "{:+.1} %", 100.0 * change);
}
