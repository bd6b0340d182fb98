//! `actuator manual`: the manual pages.

use std::path::PathBuf;

use clap::Args;
use clap_mangen::Man;

use crate::error::Error;
use crate::output::write_error;
use host_sim::file;

/// Writes the manual pages of all commands into a folder
///
/// `man ./actuator-identify.1` shows one; in ~/.local/share/man/man1 `man` finds them by their
/// names.
#[derive(Debug, Args)]
pub struct Manual {
    /// The folder
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

impl Manual {
    /// Writes them.
    ///
    /// # Errors
    /// For a folder that cannot be written to.
    pub fn run(self) -> Result<(), Error> {
        let mut program = crate::command();
        program.build();
        let folder = &self.folder;
        file::create_folder("FOLDER", folder)?;
        self.write(&program)?;
        program
            .get_subcommands()
            .try_for_each(|command| self.write(command))
    }

    fn write(&self, command: &clap::Command) -> Result<(), Error> {
        let name = command.get_display_name().unwrap_or(command.get_name());
        let path = self.folder.join(format!("{name}.1"));
        let mut page = Vec::new();
        let rendered = Man::new(command.clone()).render(&mut page);
        rendered.map_err(|source| write_error(&path, source))?;
        Ok(file::write(&path, page)?)
    }
}
