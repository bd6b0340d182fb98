//! `actuator completions`: what a shell needs to complete the command line.

use clap::Args;
use clap_complete::{Shell, generate};

use crate::error::Error;
use crate::output::print;

/// Prints the completions of a shell
///
/// For bash: `actuator completions bash > ~/.local/share/bash-completion/completions/actuator`
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints them.
    ///
    /// # Errors
    /// That of standard output.
    pub fn run(self) -> Result<(), Error> {
        let mut text = Vec::new();
        generate(self.shell, &mut crate::command(), "actuator", &mut text);
        print(&String::from_utf8_lossy(&text))
    }
}
