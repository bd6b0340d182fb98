//! The FMU as a file.

use std::env;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use model_core::actuator::Settings;
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, DateTime};

use crate::{description, documentation, identity};

/// The shared library of this crate for one platform.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Library {
    /// The platform name of the standard, and the suffix of its libraries.
    platform: (&'static str, &'static str),
    bytes: Vec<u8>,
}

const LINUX: (&str, &str) = ("linux64", "so");
const WINDOWS: (&str, &str) = ("win64", "dll");

/// The version of the standard that an FMU follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

impl Version {
    fn description(self, settings: &Settings) -> String {
        match self {
            Self::Fmi2 => description::xml(settings),
            Self::Fmi3 => description::xml_3(settings),
        }
    }

    /// The folder of a platform, by its name in FMI 2.0.
    fn folder(self, platform: &'static str) -> &'static str {
        match (self, platform) {
            (Self::Fmi3, "linux64") => "x86_64-linux",
            (Self::Fmi3, "win64") => "x86_64-windows",
            (_, platform) => platform,
        }
    }
}

/// Why an FMU cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The shared library is not found.
    #[error("there is no {}, expected the library there or named", name.display())]
    NoLibrary {
        /// Its file name.
        name: PathBuf,
    },
    /// A file is not a shared library of this crate.
    #[error("{} is not {expected}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The content that is expected.
        expected: &'static str,
    },
    /// Two libraries are for one platform.
    #[error("two libraries are for {0}, expected one a platform")]
    Twice(&'static str),
}

impl Library {
    /// A library that has been read from this file: for Linux or Windows, and for x86-64.
    ///
    /// # Errors
    /// [`Error::Foreign`] for any other file.
    pub fn of(path: &Path, bytes: Vec<u8>) -> Result<Self, Error> {
        let foreign = |expected| Error::Foreign {
            path: path.into(),
            expected,
        };
        let platform = platform(&bytes)
            .ok_or_else(|| foreign("a shared library for Linux or Windows on x86-64"))?;
        let entry = b"fmi2Instantiate";
        if !bytes.windows(entry.len()).any(|window| window == entry) {
            return Err(foreign(
                "the library of actuator-fmu: it has no fmi2Instantiate",
            ));
        }
        Ok(Self { platform, bytes })
    }
}

/// Finds the library that was built along with the running program: cargo puts it into the folder
/// `deps` next to the program, an installer next to the program itself.
///
/// # Errors
/// [`Error::NoLibrary`].
pub fn beside_program() -> Result<PathBuf, Error> {
    let name = format!(
        "{}actuator_fmu{}",
        env::consts::DLL_PREFIX,
        env::consts::DLL_SUFFIX
    );
    let program = env::current_exe().unwrap_or_default();
    let folder = program.parent().unwrap_or(Path::new(""));
    let places = [folder.join("deps").join(&name), folder.join(&name)];
    let found = places.into_iter().find(|place| place.is_file());
    found.ok_or_else(|| Error::NoLibrary {
        name: folder.join(name),
    })
}

/// The platform of a library, from the head of the file.
fn platform(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    // ELF: class 2 is 64 bit, type 3 is a shared object, machine 62 is x86-64.
    if bytes.starts_with(b"\x7fELF\x02\x01") && bytes.get(16..20) == Some(&[3, 0, 62, 0]) {
        return Some(LINUX);
    }
    // PE: the word at 60 leads to the signature, machine 0x8664 is x86-64.
    let at = bytes.get(60..64)?.try_into().ok()?;
    let at = usize::try_from(u32::from_le_bytes(at)).ok()?;
    let signature = bytes.get(at..at.checked_add(6)?)?;
    (bytes.starts_with(b"MZ") && signature == b"PE\0\0\x64\x86").then_some(WINDOWS)
}

/// Checks that libraries can be in one FMU.
///
/// # Errors
/// [`Error::Twice`].
pub fn check(libraries: &[Library]) -> Result<(), Error> {
    for (i, library) in libraries.iter().enumerate() {
        let others = &libraries[..i];
        if others
            .iter()
            .any(|other| other.platform == library.platform)
        {
            return Err(Error::Twice(library.platform.0));
        }
    }
    Ok(())
}

/// Writes the FMU of these settings. The same settings and libraries give the same bytes.
///
/// # Errors
/// The error of the operating system.
pub fn write(
    settings: &Settings,
    version: Version,
    libraries: &[Library],
    out: impl Write + Seek,
) -> io::Result<()> {
    let mut zip = ZipWriter::new(out);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let mut add = |name: &str, permissions: u32, bytes: &[u8]| -> io::Result<()> {
        zip.start_file(name, options.unix_permissions(permissions))?;
        zip.write_all(bytes)
    };
    let texts = [
        ("modelDescription.xml", version.description(settings)),
        ("documentation/index.html", documentation::html(settings)),
        ("resources/settings.txt", identity::to_text(settings)),
    ];
    for (name, text) in texts {
        add(name, 0o644, text.as_bytes())?;
    }
    let identifier = description::model_identifier(settings);
    for Library { platform, bytes } in libraries {
        let (platform, ending) = platform;
        let folder = version.folder(platform);
        add(
            &format!("binaries/{folder}/{identifier}.{ending}"),
            0o755,
            bytes,
        )?;
    }
    zip.finish()?.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Read};

    fn elf() -> Vec<u8> {
        let mut bytes = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0\x3e\0".to_vec();
        bytes.extend(b"fmi2Instantiate");
        bytes
    }

    fn pe() -> Vec<u8> {
        let mut bytes = b"MZ".to_vec();
        bytes.resize(60, 0);
        bytes.extend(64_u32.to_le_bytes());
        bytes.extend(b"PE\0\0\x64\x86fmi2Instantiate");
        bytes
    }

    fn library(bytes: &[u8]) -> Result<Library, Error> {
        Library::of(Path::new("library"), bytes.to_vec())
    }

    #[test]
    fn each_library_goes_to_the_folder_of_its_platform() {
        let settings = model_core::scenario::choices().last().unwrap();
        let libraries = [library(&elf()).unwrap(), library(&pe()).unwrap()];
        let mut out = Cursor::new(Vec::new());
        write(&settings, Version::Fmi2, &libraries, &mut out).unwrap();
        let mut zip = zip::ZipArchive::new(out).unwrap();
        for (name, expected) in [
            ("binaries/linux64/actuator_board_bench.so", elf()),
            ("binaries/win64/actuator_board_bench.dll", pe()),
            (
                "modelDescription.xml",
                description::xml(&settings).into_bytes(),
            ),
            (
                "resources/settings.txt",
                identity::to_text(&settings).into_bytes(),
            ),
        ] {
            let mut bytes = Vec::new();
            let mut file = zip.by_name(name).unwrap();
            file.read_to_end(&mut bytes).unwrap();
            assert_eq!(bytes, expected, "{name}");
        }
    }

    #[test]
    fn what_is_no_library_of_ours_is_refused() {
        let mut other_machine = elf();
        other_machine[18] = 0xb7;
        let no_entry = elf()[..20].to_vec();
        let far_signature = [b"MZ".as_slice(), &[0xff; 80]].concat();
        for bytes in [other_machine, no_entry, far_signature, Vec::new()] {
            assert!(matches!(library(&bytes), Err(Error::Foreign { .. })));
        }
        let two = [library(&elf()).unwrap(), library(&elf()).unwrap()];
        assert!(matches!(check(&two), Err(Error::Twice("linux64"))));
    }
}
