//! `actuator board`: the ELF on the emulated board, as somebody at a terminal sees it.

use std::path::Path;

use super::Desk;

#[path = "../../../tests/src/board_elf.rs"]
#[allow(dead_code, reason = "the other program is not needed here")]
mod board_elf;

/// What is typed, and what the run prints, row by row.
fn csv(desk: &Desk, arguments: &str, typed: &str) -> Vec<Vec<f64>> {
    let elf = board_elf::board_elf();
    let mut command = desk.actuator("board --format csv --pace max --elf");
    let output = command
        .arg(elf)
        .args(arguments.split_whitespace())
        .write_stdin(typed)
        .assert()
        .success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8");
    let (header, rows) = text.split_once('\n').expect("a header");
    let columns = "time_s,angle_deg,rate_deg_s,current_a,supply_v,state,fault";
    assert_eq!(header, columns);
    let number = |cell: &str| cell.parse().expect("a number");
    rows.lines()
        .map(|row| row.split(',').map(number).collect())
        .collect()
}

#[test]
fn every_pwm_period_is_a_row_and_the_shaft_goes_where_it_is_told() {
    let rows = csv(&Desk::new(), "--for 2", "enable\n12.5\n");
    // The first period begins when the program has set the timer up.
    assert!((1990..=2000).contains(&rows.len()), "{}", rows.len());
    for pair in rows.windows(2) {
        assert!((pair[1][0] - pair[0][0] - 1e-3).abs() < 1e-9, "{pair:?}");
    }
    let last = rows.last().expect("a row");
    assert!((last[1] - 12.5).abs() < 0.1, "{last:?}");
    // Enabled, no fault, from 6 V.
    assert_eq!(last[4..], [6.0, 2.0, 0.0]);
}

#[test]
fn a_plan_of_faults_breaks_the_board_at_its_time() {
    let desk = Desk::new();
    desk.write(
        "plan.toml",
        "[[fault]]\nat_ms = 1500\nwhat = { supply = { volts = 3.8 } }\n",
    );
    let rows = csv(&desk, "--for 2 --faults plan.toml", "enable\n5\n");
    let told = rows.iter().find(|row| row[6] != 0.0).expect("a fault");
    // Under-voltage, within 20 ms and the frame that tells.
    assert_eq!(told[6], 11.0);
    assert!((1.5..1.53).contains(&told[0]), "{told:?}");
}

#[test]
fn a_plan_that_makes_no_sense_is_refused_by_file_and_line() {
    let desk = Desk::new();
    desk.write("plan.toml", "\n[[fault]]\nwhat = \"jam\"\n");
    let elf = board_elf::board_elf();
    let output = desk
        .actuator("board --for 1 --faults plan.toml --elf")
        .arg(elf)
        .assert()
        .failure();
    let message = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(
        message.contains("plan.toml:2: expected exactly one of"),
        "{message}"
    );
    let no_elf = desk.actuator("board --elf none.elf").assert().failure();
    let message = String::from_utf8_lossy(&no_elf.get_output().stderr).into_owned();
    assert!(message.contains("none.elf"), "{message}");
    assert!(!Path::new("none.elf").exists());
}
