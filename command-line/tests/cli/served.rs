//! A running server.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use crate::Cli;

/// `actuator serve`, until it is dropped.
pub struct Served {
    pub process: Child,
    /// Its address.
    pub bus: String,
    pub cli: Cli,
}

impl Served {
    /// With these options.
    pub fn new(options: &[&str]) -> Self {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("actuator"));
        Self::start(
            command
                .args(["serve", "--listen", "127.0.0.1:0"])
                .args(options),
        )
    }

    /// By this command. What it writes to standard error is in the file `notices`.
    pub fn start(command: &mut Command) -> Self {
        let cli = Cli::new();
        let notices = std::fs::File::create(cli.path("notices")).expect("a file");
        let mut process = command
            .stdout(Stdio::piped())
            .stderr(notices)
            .spawn()
            .expect("it starts");
        let mut line = String::new();
        let mut out = BufReader::new(process.stdout.as_mut().expect("piped"));
        out.read_line(&mut line).expect("a line");
        let bus = line
            .split([' ', ','])
            .find(|word| word.contains(':') && word.contains("127.0.0.1"));
        let bus = bus.expect("the line contains the address").to_owned();
        Self { process, bus, cli }
    }

    pub fn command(&self, arguments: &str) -> assert_cmd::Command {
        self.cli
            .actuator(&format!("{arguments} --bus {}", self.bus))
    }

    pub fn text(&self, arguments: &str) -> String {
        let output = self.command(arguments).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8")
    }

    /// The error of a command that ends with this status.
    pub fn error(&self, arguments: &str, status: i32) -> String {
        let output = self.command(arguments).assert().code(status);
        String::from_utf8(output.get_output().stderr.clone()).expect("UTF-8")
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
