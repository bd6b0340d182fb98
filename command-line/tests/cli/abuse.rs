//! Abuses of the command line by seed: each is refused with a reason, without output, files or a
//! panic.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    io::Read,
    process::Stdio,
    time::{Duration, Instant},
};

use super::Cli;

/// Number of abuses.
const ABUSES: u64 = 400;

/// The longest that a refusal may take.
const LONGEST: Duration = Duration::from_secs(5);

/// A command with the options that it takes and those that it refuses.
#[derive(Default)]
struct Abused<'a> {
    command: Vec<&'a str>,
    taken: Vec<Vec<&'a str>>,
    refused: Vec<Vec<&'a str>>,
}

/// The commands of `abuses.txt`.
fn commands(text: &str) -> Vec<Abused<'_>> {
    let mut commands: Vec<Abused<'_>> = Vec::new();
    for line in text
        .lines()
        .filter(|l| !l.is_empty() && !l.starts_with('#'))
    {
        let mut words = line.split(' ');
        let (kind, rest): (_, Vec<&str>) = (words.next(), words.collect());
        let last = commands.last_mut();
        match (kind, last) {
            (Some("command"), _) => commands.push(Abused {
                command: rest,
                ..Abused::default()
            }),
            (Some("ok"), Some(last)) => last.taken.push(rest),
            (Some("flag"), Some(last)) => last.refused.push(vec![value(rest[0])]),
            (Some("bad"), Some(last)) => {
                let values = rest.iter().skip(1);
                let refused = values.map(|text| vec![rest[0], value(text)]);
                last.refused.extend(refused);
            }
            other => panic!("{line}: {:?}", other.0),
        }
    }
    commands
}

fn value(text: &str) -> &str {
    match text {
        "''" => "",
        text => text,
    }
}

/// SplitMix64 (Steele, Lea and Flood, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[(self.next() % of.len() as u64) as usize]
    }
}

/// The files with their content.
fn files(cli: &Cli) -> BTreeMap<OsString, Vec<u8>> {
    let folder = std::fs::read_dir(cli.path(".")).expect("the folder");
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("an entry");
        // A folder has no content.
        let content = std::fs::read(entry.path()).unwrap_or_default();
        (entry.file_name(), content)
    };
    folder.map(file).collect()
}

#[test]
fn each_abuse_is_refused_with_a_reason_and_leaves_nothing() {
    let cli = Cli::new();
    let header = "time_s,command_deg,angle_deg,load_torque_nm\n";
    cli.write("empty.csv", "");
    cli.write("header.csv", header);
    cli.write("letters.csv", format!("{header}0,a,b,c\n1,a,b,c\n"));
    cli.write(
        "backwards.csv",
        format!("{header}1,0,0,0\n0,0,0,0\n0.5,1,1,1\n"),
    );
    cli.write("short.csv", format!("{header}0,0,0,0\n1,1,0.5,0\n"));
    cli.write("command.csv", format!("{header}0,0,0,0\n0.1,5,0,0.1\n"));
    let mut random = Random(15);
    let garbage: Vec<u8> = (0..3000).map(|_| random.next() as u8).collect();
    cli.write("garbage.bin", garbage);
    cli.text("simulate black-box-1 --every 400 --csv good.csv");
    let before = files(&cli);
    let commands = commands(include_str!("abuses.txt"));
    let all: Vec<_> = commands
        .iter()
        .flat_map(|of| of.refused.iter().map(move |refused| (of, refused)))
        .collect();
    for seed in 0..ABUSES {
        let mut random = Random(seed);
        let (of, refused) = random.pick(&all);
        let mut arguments = of.command.clone();
        arguments.extend(refused.iter());
        let option = refused[0];
        if !of.taken.is_empty() && random.next().is_multiple_of(2) {
            let taken = random.pick(&of.taken);
            // The last of two values would apply.
            if taken[0] != option {
                arguments.extend(taken);
            }
        }
        let mut run = cli.actuator("");
        // An abuse that is not refused may serve or simulate without end.
        run.timeout(LONGEST);
        let output = run.args(&arguments).output().expect("it runs");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let context = format!("{arguments:?}\n{error}");
        assert!(matches!(output.status.code(), Some(1 | 2)), "{context}");
        assert!(
            error.lines().any(|line| line.starts_with("error: ")),
            "{context}"
        );
        assert!(!error.contains("panicked"), "{context}");
        assert!(output.stdout.is_empty(), "{context}");
        let value = refused[refused.len() - 1];
        let words = option.trim_start_matches('-').replace('-', " ");
        let names = [option, &words, value, "expected", "a value is required for"];
        let is_named = |name: &&str| !name.is_empty() && error.contains(*name);
        assert!(names.iter().any(is_named), "{context}");
        assert_eq!(files(&cli), before, "{context}");
    }
}

/// The commands whose output is closed before its end, and how many lines are read of it.
const CLOSED: [(&str, usize); 7] = [
    ("simulate board --duration 1e5 --csv -", 1),
    ("simulate board --list-parameters", 0),
    ("simulate board --list-parameters --json", 0),
    ("tune --json", 0),
    (
        "identify good.csv --model black-box-1 --starts 1 --json -",
        1,
    ),
    ("mujoco", 1),
    ("completions bash", 1),
];

#[test]
fn a_reader_that_closes_the_output_ends_the_program_without_a_message() {
    let cli = Cli::new();
    cli.text("simulate black-box-1 --every 400 --csv good.csv");
    for (arguments, lines) in CLOSED {
        let began = Instant::now();
        let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
            .args(arguments.split(' '))
            .current_dir(cli.path("."))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut output = std::io::BufReader::new(run.stdout.take().expect("its output"));
        for _ in 0..lines {
            let mut line = String::new();
            std::io::BufRead::read_line(&mut output, &mut line).expect("a line");
            assert!(!line.is_empty(), "{arguments}");
        }
        drop(output);
        let status = run.wait().expect("it ends");
        let mut error = String::new();
        let mut stderr = run.stderr.take().expect("its messages");
        stderr.read_to_string(&mut error).expect("text");
        // It may have written everything before.
        assert!(
            matches!(status.code(), Some(0 | 1)),
            "{arguments}: {status}\n{error}"
        );
        assert!(
            !error.contains("error: ") && !error.contains("panicked"),
            "{arguments}\n{error}"
        );
        assert!(began.elapsed() < LONGEST, "{arguments}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_no_part_of_a_unit_and_keeps_the_old_one() {
    // No file of the program may be longer than 8 KiB.
    let cli = Cli::new();
    cli.write("old.fmu", "old");
    let program = assert_cmd::cargo::cargo_bin!("actuator");
    let run = format!(
        "ulimit -f 8; trap '' XFSZ; exec {} fmu --out old.fmu",
        program.display()
    );
    let output = std::process::Command::new("bash")
        .args(["-c", &run])
        .current_dir(cli.path("."))
        .output()
        .expect("it runs");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("cannot write old.fmu: "), "{error}");
    assert_eq!(cli.read("old.fmu"), "old");
    assert_eq!(files(&cli).len(), 1);
}
