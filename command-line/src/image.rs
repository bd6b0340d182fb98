//! `actuator image`: keys and signed images for the bootloader.

use std::path::{Path, PathBuf};

use bootloader::layout::STM32F427;
use bootloader::{ACTUATOR_BOARD, DEVELOPMENT_KEY, Header, Version};
use clap::{Args, Subcommand};
use program_image::signed::{
    self, Description, SignError, development_key, inspect, make_key, public_path, read_key,
    read_public_key, sign_elf,
};

use crate::bounded::{self, MOST_BUILD};
use crate::error::Error;
use crate::output::print;
use host_sim::file;

/// Signs, shows and verifies images for the update over the bus
#[derive(Debug, Args)]
pub struct Image {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Makes a key pair: FILE, which is secret, and FILE.pub for the bootloader
    Key {
        /// The file of the private key
        file: PathBuf,
    },
    /// Makes a signed image of a program that is linked for the slot
    Sign {
        /// The ELF file of the program
        elf: PathBuf,
        /// Where to write the image
        #[arg(long)]
        out: PathBuf,
        /// Version of the image, as in 1.2.3: a board takes no earlier one than it has confirmed
        #[arg(long, default_value = env!("CARGO_PKG_VERSION"))]
        version: String,
        /// Makes a recovery image, which a board takes in place of this later version
        #[arg(long, value_name = "VERSION")]
        replaces: Option<String>,
        /// File of the private key [default: the development key, which is public]
        #[arg(long)]
        key: Option<PathBuf>,
    },
    /// Shows what an image is, without a check of its signature
    Show {
        /// The image
        image: PathBuf,
    },
    /// Checks that an image is whole and signed by a key
    Verify {
        /// The image
        image: PathBuf,
        /// File of the public key [default: the development key]
        #[arg(long)]
        key: Option<PathBuf>,
    },
}

impl Image {
    /// Executes the action.
    ///
    /// # Errors
    /// For files that cannot be read or written, and images that are refused.
    pub fn run(self) -> Result<(), Error> {
        match self.action {
            Action::Key { file } => key(&file),
            Action::Sign {
                elf,
                out,
                version,
                replaces,
                key,
            } => sign(&elf, &out, &version, replaces.as_deref(), key.as_deref()),
            Action::Show { image } => show(&image),
            Action::Verify { image, key } => verify(&image, key.as_deref()),
        }
    }
}

fn key(file: &Path) -> Result<(), Error> {
    make_key(file)?;
    let public = public_path(file);
    print(&format!(
        "{} is the private key: keep it secret. Build the bootloader with\n  \
         ACTUATOR_PUBLIC_KEY={} cargo build-boot\n",
        file.display(),
        public.display(),
    ))
}

fn sign(
    elf: &Path,
    out: &Path,
    version: &str,
    replaces: Option<&str>,
    key: Option<&Path>,
) -> Result<(), Error> {
    let read = [Some(elf), key].into_iter().flatten().map(PathBuf::from);
    file::check(&[("--out", out)], &read.collect::<Vec<_>>())?;
    let key = key.map_or_else(|| Ok(development_key()), read_key)?;
    let description = Description {
        hardware: ACTUATOR_BOARD,
        version: parse(version)?,
        replaces: replaces.map(parse).transpose()?,
    };
    let image = sign_elf(elf, bounded::read(elf, MOST_BUILD)?, &description, &key)?;
    file::write(out, image)?;
    show(out)
}

fn parse(version: &str) -> Result<Version, SignError> {
    Version::parse(version).ok_or_else(|| SignError::Version(version.into()))
}

/// Reads an image, which is not longer than its slot.
///
/// # Errors
/// For a file that cannot be read or is longer.
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    bounded::read(path, STM32F427.slot.size().into())
}

fn show(path: &Path) -> Result<(), Error> {
    let header = inspect(&read(path)?, &STM32F427).map_err(|refusal| SignError::Refused {
        path: path.into(),
        refusal,
    })?;
    print(&text(&header))
}

fn verify(path: &Path, key: Option<&Path>) -> Result<(), Error> {
    let key = match key {
        Some(key) => read_public_key(key)?,
        None => development_key().verifying_key(),
    };
    let image = read(path)?;
    let refused = |refusal| SignError::Refused {
        path: path.into(),
        refusal,
    };
    let header = signed::verify(&image, &STM32F427, &key).map_err(refused)?;
    print(&format!("whole, and signed by this key\n{}", text(&header)))
}

fn text(header: &Header) -> String {
    let key = match header.key {
        key if key == DEVELOPMENT_KEY.number() => " (development key)",
        _ => "",
    };
    let replaces = match header.replaces {
        Version(0) => String::new(),
        version => format!("recovery of {version}\n"),
    };
    format!(
        "version     {}\n{replaces}hardware    {:#06x}\nprogram     {} bytes\nidentity    {:08x}\nkey         {:08x}{key}\n",
        header.version,
        header.hardware,
        header.length,
        header.identity(),
        header.key.swap_bytes(),
    )
}
