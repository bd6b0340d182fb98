//! On what and when the figures were measured.

use std::{fs, process::Command};

/// Origin of the figures, for the page.
#[derive(Debug)]
pub struct Machine {
    /// Commit of the work tree; "modified" where it has uncommitted changes.
    pub commit: String,
    /// Date of the measurement, UTC.
    pub date: String,
    /// Name of the processor and number of its cores.
    pub processor: String,
    /// Load average over the last minute before the measurement.
    pub load: String,
    /// Version of the compiler.
    pub compiler: String,
}

/// Describes this machine; what cannot be found out is "unknown".
pub fn describe() -> Machine {
    let modified = !output("git", &["status", "--porcelain"]).is_empty();
    let commit = output("git", &["rev-parse", "--short", "HEAD"]);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Machine {
        commit: or_unknown(if modified {
            format!("{commit}, modified")
        } else {
            commit
        }),
        date: or_unknown(output("date", &["-u", "+%Y-%m-%d %H:%M UTC"])),
        processor: format!("{}, {cores} cores", or_unknown(processor())),
        load: or_unknown(first_word("/proc/loadavg")),
        compiler: or_unknown(output("rustc", &["--version"])),
    }
}

fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split(": ").nth(1));
    name.unwrap_or_default().to_owned()
}

fn first_word(path: &str) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    text.split(' ').next().unwrap_or_default().to_owned()
}

fn output(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output();
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    text.unwrap_or_default().trim().to_owned()
}

fn or_unknown(text: String) -> String {
    if text.is_empty() {
        "unknown".to_owned()
    } else {
        text
    }
}
