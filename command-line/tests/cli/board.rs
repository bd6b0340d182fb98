//! `actuator board`: the ELF on the emulated board, through its standard input and output.

use std::collections::BTreeSet;
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::Cli;
use super::served::Served;

/// A PWM period: values by the names of their columns; `None` for an empty cell.
type Row = HashMap<String, Option<f64>>;

/// The rows that the run prints for this input.
fn csv(cli: &Cli, arguments: &str, typed: &str) -> Vec<Row> {
    let elf = cross_build::board_elf();
    let mut command = cli.actuator("board --format csv --pace max --elf");
    let output = command
        .arg(elf)
        .args(arguments.split_whitespace())
        .write_stdin(typed)
        .assert()
        .success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8");
    let (header, rows) = text.split_once('\n').expect("a header");
    let number = |cell: &str| (!cell.is_empty()).then(|| cell.parse().expect("a number"));
    let row = |line: &str| {
        let cells = header.split(',').zip(line.split(','));
        cells
            .map(|(name, cell)| (name.to_owned(), number(cell)))
            .collect()
    };
    rows.lines().map(row).collect()
}

fn value(row: &Row, name: &str) -> f64 {
    row[name].unwrap_or(f64::NAN)
}

/// Whether the statusword is that of OPERATION ENABLED.
fn is_enabled(row: &Row) -> bool {
    value(row, "statusword") as u16 & 0x6f == 0x27
}

#[test]
fn every_pwm_period_is_a_row_and_the_shaft_goes_to_the_target() {
    let rows = csv(&Cli::new(), "--for 2", "enable\n12.5\n");
    // The first period begins when the program has configured the timer.
    assert!((1990..=2000).contains(&rows.len()), "{}", rows.len());
    for pair in rows.windows(2) {
        let step_s = value(&pair[1], "time_s") - value(&pair[0], "time_s");
        assert!((step_s - 1e-3).abs() < 1e-9, "{pair:?}");
    }
    let last = rows.last().expect("a row");
    // The magnet is off its axis, and the shaft may rest anywhere in its friction.
    assert!(
        (value(last, "angle_meas_deg") - 12.5).abs() < 0.1,
        "{last:?}"
    );
    assert!((value(last, "angle_deg") - 12.5).abs() < 0.6, "{last:?}");
    assert_eq!(value(last, "command_deg"), 12.5);
    assert!(is_enabled(last), "{last:?}");
    assert_eq!(value(last, "fault"), 0.0);
    // The ripple, and the resistance of the source at the current that holds the shaft.
    assert!((value(last, "supply_v") - 6.0).abs() < 0.1, "{last:?}");
}

#[test]
fn an_enabled_drive_stays_enabled_without_a_target() {
    let rows = csv(&Cli::new(), "--for 1", "enable\n");
    let last = rows.last().expect("a row");
    assert!(is_enabled(last), "{last:?}");
    assert_eq!(value(last, "fault"), 0.0);
}

#[test]
fn a_fault_plan_injects_its_faults_at_their_times() {
    let cli = Cli::new();
    cli.write(
        "plan.toml",
        "[[fault]]\nat_ms = 1500\nwhat = { supply = { volts = 3.8 } }\n",
    );
    let rows = csv(&cli, "--for 2 --faults plan.toml", "enable\n5\n");
    let has_fault = |row: &&Row| value(row, "fault") > 0.0;
    let row = rows.iter().find(has_fault).expect("a fault");
    // Under-voltage: 20 ms and the frame that reports it.
    assert_eq!(value(row, "fault"), 11.0);
    assert!((1.5..1.53).contains(&value(row, "time_s")), "{row:?}");
}

#[test]
fn the_error_of_an_invalid_fault_plan_names_file_and_line() {
    let cli = Cli::new();
    cli.write("plan.toml", "\n[[fault]]\nwhat = \"jam\"\n");
    let elf = cross_build::board_elf();
    let output = cli
        .actuator("board --for 1 --faults plan.toml --elf")
        .arg(elf)
        .assert()
        .failure();
    let message = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(
        message.contains("plan.toml:2: expected exactly one of"),
        "{message}"
    );
    let no_elf = cli.actuator("board --elf none.elf").assert().failure();
    let message = String::from_utf8_lossy(&no_elf.get_output().stderr).into_owned();
    assert!(message.contains("none.elf"), "{message}");
    assert!(!Path::new("none.elf").exists());
}

#[test]
fn the_capture_of_the_board_is_saved_in_a_file_that_can_be_identified() {
    let cli = Cli::new();
    let typed = "capture start\nenable\n20\ncapture stop\ncapture save run.csv\nend\n";
    csv(&cli, "--for 60", typed);
    let text = cli.read("run.csv");
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    assert!(header.starts_with("time_s,angle_mdeg,"), "{header}");
    let times: Vec<f64> = lines
        .map(|line| {
            let (time_s, _) = line.split_once(',').expect("columns");
            time_s.parse().expect("a number")
        })
        .collect();
    assert!(times.len() > 5, "{text}");
    assert!(
        times
            .iter()
            .enumerate()
            .all(|(row, time_s)| (time_s - 0.004 * row as f64).abs() < 1e-9)
    );
}

/// `actuator serve --elf`, until it is dropped.
struct Chain {
    process: Child,
    address: String,
}

impl Chain {
    fn new() -> Self {
        Self::with(cross_build::board_elf(), &[])
    }

    /// With these options besides.
    fn with(program: &Path, options: &[&str]) -> Self {
        let what = "1 emulated actuator with node-ID 1";
        Self::of_programs(&[program], options, what)
    }

    /// With a program of each actuator; the server reports that it has `what`.
    fn of_programs(programs: &[&Path], options: &[&str], what: &str) -> Self {
        let programs = programs
            .iter()
            .flat_map(|program| [Path::new("--elf"), *program]);
        let comm = [Path::new("--comm-elf"), cross_build::comm_board_elf()];
        Self::served(programs.chain(comm), options, what)
    }

    /// With these programs.
    fn served<'a>(programs: impl Iterator<Item = &'a Path>, options: &[&str], what: &str) -> Self {
        let mut process = Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
            .args(["serve", "--listen", "127.0.0.1:0"])
            .args(programs)
            .args(options)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut line = String::new();
        let mut out = BufReader::new(process.stdout.as_mut().expect("piped"));
        out.read_line(&mut line).expect("a line");
        let rest = line.strip_prefix("ready: slcan at ").expect("it is ready");
        let (address, is) = rest.split_once(", ").expect("an address");
        assert_eq!(is.trim_end(), what);
        Self {
            address: address.to_owned(),
            process,
        }
    }

    fn client(&self) -> TcpStream {
        let client = TcpStream::connect(&self.address).expect("it listens");
        let timeout = Some(Duration::from_secs(20));
        client.set_read_timeout(timeout).expect("a socket");
        client
    }
}

impl Drop for Chain {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Sends bytes and reads until this line; frames of the bus may precede it.
fn exchange(client: &mut TcpStream, bytes: &[u8], line: &str) {
    client.write_all(bytes).expect("it is there");
    let mut heard = String::new();
    while !heard.split('\r').rev().skip(1).any(|whole| whole == line) {
        let mut byte = [0];
        client.read_exact(&mut byte).expect("it answers");
        heard.push(char::from(byte[0]));
    }
}

#[test]
fn programs_of_both_chips_and_native_actuators_share_a_bus_and_take_faults_at_run_time() {
    let cli = Cli::new();
    // An emulated board takes no fault of the bus, and there is no ninth.
    cli.write("faults", "1 mute\n2 supply 5.2\n9 jam\n3 supply 4.8\n");
    let faults = cli.path("faults").display().to_string();
    let programs = [
        cross_build::board_elf(),
        cross_build::board_h743_elf(),
        Path::new("native"),
    ];
    let what = "4 emulated and native actuators with node-IDs 1 to 4";
    let options = ["--nodes", "4", "--node-faults", &faults];
    let chain = Chain::of_programs(&programs, &options, what);
    let value = |command: &str| {
        let command = format!("{command} --bus {}", chain.address);
        let limit = Duration::from_secs(60);
        let output = cli.actuator(&command).timeout(limit).assert().success();
        let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
        let word = text.split_whitespace().next().map(str::to_owned);
        word.unwrap_or_default()
    };
    let serial_numbers: BTreeSet<_> = (1..=4)
        .map(|node| value(&format!("get 1018:4 --node {node}")))
        .collect();
    assert_eq!(serial_numbers.len(), 4, "{serial_numbers:?}");
    for node in 1..=4 {
        value(&format!("move {} --node {node}", 5 * node));
    }
    // All hold their angles at once.
    for node in 1..=4 {
        let mdeg: i32 = value(&format!("get 6064 --node {node}"))
            .parse()
            .expect("a number");
        assert!(
            (mdeg - 5000 * node).abs() < 1000,
            "node {node} is at {mdeg} mdeg"
        );
    }
    for (node, expected_mv) in [(1, 6000), (2, 5200), (3, 4800), (4, 6000)] {
        let mv: i32 = value(&format!("get 6079 --node {node}"))
            .parse()
            .expect("a number");
        // Noise, and the drop of the current that holds.
        assert!((mv - expected_mv).abs() < 200, "node {node}: {mv} mV");
    }
}

/// The identity of the program that runs (1F56h).
fn identity(cli: &Cli, chain: &Chain) -> String {
    let output = cli
        .actuator(&format!("get 1F56:1 --bus {}", chain.address))
        .assert()
        .success();
    String::from_utf8_lossy(&output.get_output().stdout).into_owned()
}

#[test]
fn the_boards_of_a_release_are_updated_through_their_bootloader_and_keep_their_flash() {
    let cli = Cli::new();
    let (flash, boards) = (cli.path("flash.bin"), cli.path("boards"));
    std::fs::create_dir(&boards).expect("a folder");
    for (elf, name) in [
        (cross_build::board_elf(), "actuator-board.elf"),
        (cross_build::comm_board_elf(), "comm-board.elf"),
        (cross_build::boot_elf(), "actuator-boot.elf"),
    ] {
        std::fs::copy(elf, boards.join(name)).expect("a copy");
    }
    let flash_name = flash.display().to_string();
    let serve = || {
        let programs = [Path::new("--boards"), &boards].into_iter();
        let what = "1 emulated actuator with node-ID 1";
        Chain::served(programs, &["--flash", &flash_name], what)
    };
    let mut chain = serve();
    let before = identity(&cli, &chain);
    let program = cross_build::board_elf().display();
    cli.actuator(&format!(
        "image sign {program} --version 9.0.0 --out new.img"
    ))
    .assert()
    .success();
    let update = format!("update new.img --bus {}", chain.address);
    cli.actuator(&update)
        .timeout(Duration::from_secs(300))
        .assert()
        .success();
    let after = identity(&cli, &chain);
    assert_ne!(after, before);
    let pid = chain.process.id().to_string();
    let killed = Command::new("kill").args(["-INT", &pid]).status();
    assert!(killed.is_ok_and(|status| status.success()));
    assert_eq!(chain.process.wait().expect("it ends").code(), Some(0));
    let chain = serve();
    assert_eq!(identity(&cli, &chain), after);
    // An image of an earlier version is refused.
    cli.actuator(&format!(
        "image sign {program} --version 8.0.0 --out old.img"
    ))
    .assert()
    .success();
    cli.actuator(&format!("update old.img --bus {}", chain.address))
        .assert()
        .failure();
}

#[test]
fn a_program_of_another_board_is_refused_by_its_name() {
    let (board, comm) = (
        cross_build::board_elf().display(),
        cross_build::comm_board_elf().display(),
    );
    let actuator = cross_build::board_elf().display();
    for (arguments, expected) in [
        (
            format!("board --elf {comm}"),
            "is the program of: communication board, STM32F427; expected the program of an actuator board",
        ),
        (
            format!("serve --elf {comm} --comm-elf {comm}"),
            "expected the program of an actuator board",
        ),
        (
            format!("serve --elf {board} --comm-elf {actuator}"),
            "is the program of: actuator board, STM32F427; expected the program of the communication board",
        ),
    ] {
        let output = Cli::new().actuator(&arguments).assert().failure();
        let error = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn the_serial_line_of_the_chain_has_one_client_at_a_time() {
    let mut chain = Chain::new();
    let mut first = chain.client();
    // Version; then the bus, and the identity of node 1 by SDO.
    exchange(&mut first, b"V\r", "V1013");
    exchange(&mut first, b"S8\rO\rt60184018100200000000\r", "z");
    let mut second = chain.client();
    assert_eq!(second.read(&mut [0]).expect("it is refused"), 0);
    exchange(
        &mut first,
        b"t60184018100200000000\r",
        "t58184318100241530000",
    );
    drop(first);
    let mut third = chain.client();
    exchange(&mut third, b"C\rN\r", "N0001");
    chain.process.kill().expect("it runs");
    let mut log = String::new();
    let pipe = chain.process.stderr.as_mut().expect("piped");
    pipe.read_to_string(&mut log).expect("text");
    assert_eq!(
        log.matches("is refused: the serial line of the communication board")
            .count(),
        1,
        "{log}"
    );
}

#[test]
fn boards_of_both_chips_are_servos_on_one_line() {
    let programs = [cross_build::board_elf(), cross_build::board_h743_elf()];
    let programs = programs.map(|program| program.display().to_string());
    let [one, other] = &programs;
    let options = ["--protocol", "sts3215", "--elf", one, "--elf", other];
    let served = Served::new(&options);
    let mut line = TcpStream::connect(&served.bus).expect("it listens");
    // The emulator translates the program when it is first executed.
    let timeout = Some(Duration::from_secs(20));
    line.set_read_timeout(timeout).expect("a socket");
    let mut exchange = |bytes: &[u8], answer: usize| {
        line.write_all(bytes).expect("it is there");
        let mut answered = vec![0; answer];
        line.read_exact(&mut answered).expect("an answer");
        answered
    };
    // The manual's ping, and one of the second servo.
    let ping = [0xFF, 0xFF, 1, 2, 1, 0xFB];
    assert_eq!(exchange(&ping, 6), [0xFF, 0xFF, 1, 2, 0, 0xFC]);
    let ping = [0xFF, 0xFF, 2, 2, 1, 0xFA];
    assert_eq!(exchange(&ping, 6), [0xFF, 0xFF, 2, 2, 0, 0xFB]);
    // A sync read of the IDs: the first one answers behind the second, which it hears.
    let read = [0xFF, 0xFF, 0xFE, 6, 0x82, 5, 1, 2, 1, 0x70];
    let answers = [0xFF, 0xFF, 2, 3, 0, 2, 0xF8, 0xFF, 0xFF, 1, 3, 0, 1, 0xFA];
    assert_eq!(exchange(&read, answers.len()), answers);
}
