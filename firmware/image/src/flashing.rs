//! Flashes a program that the bootloader starts: bootloader, signed image, then the log of the
//! program.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use bootloader::layout::STM32F427;
use bootloader::{ACTUATOR_BOARD, HEADER_SIZE, Version};

use crate::signed::{Description, SignError, development_key, public_path, read_key, sign_elf};
use crate::{ImageError, loaded, read};

/// The environment variable with the file of the private key that signs; without it the key of
/// development does.
pub const KEY: &str = "ACTUATOR_KEY";

/// The environment variable with the file of the public key, for the build of the bootloader.
pub const PUBLIC_KEY: &str = "ACTUATOR_PUBLIC_KEY";

/// Whether the program of an ELF file is linked for the slot.
///
/// # Errors
/// The file cannot be read, or is not a program of a board.
pub fn is_in_slot(elf: &Path) -> Result<bool, ImageError> {
    let (start, _) = loaded(elf)?;
    Ok(start == u64::from(STM32F427.slot.start() + HEADER_SIZE))
}

/// The arguments of cargo that build the bootloader for this private key, and the public key for
/// its environment; without a key the one of development, which a bootloader takes only with this
/// feature.
pub fn boot_build(key: Option<&Path>) -> (Vec<&'static str>, Option<PathBuf>) {
    let build = vec!["build-boot"];
    match key {
        Some(key) => (build, Some(public_path(key))),
        None => {
            let development = ["--features", "development-key"];
            ([build, development.to_vec()].concat(), None)
        }
    }
}

/// The ELF file of the bootloader, beside that of a program of the board.
pub fn boot_elf(elf: &Path) -> PathBuf {
    elf.with_file_name("actuator-boot")
}

/// Signs the program of an ELF file; the image is written beside it. Its version is that of this
/// workspace.
///
/// # Errors
/// The program or the key cannot be used, or the image cannot be written.
pub fn write_image(elf: &Path, key: Option<&Path>) -> Result<PathBuf, SignError> {
    let key = key.map_or_else(|| Ok(development_key()), read_key)?;
    let text = env!("CARGO_PKG_VERSION");
    let version = Version::parse(text).ok_or_else(|| SignError::Version(text.into()))?;
    let description = Description {
        hardware: ACTUATOR_BOARD,
        version,
        replaces: None,
    };
    let image = sign_elf(elf, read(elf)?, &description, &key)?;
    let path = elf.with_extension("img");
    std::fs::write(&path, image).map_err(|source| SignError::File {
        path: path.clone(),
        source,
    })?;
    Ok(path)
}

/// The command lines that flash bootloader and image and then show the log of the program, made of
/// the one that would run the program alone: `probe-rs run --chip CHIP`.
pub fn commands(run: &[OsString], elf: &Path, image: &Path) -> Vec<Vec<OsString>> {
    let [probe, rest @ ..] = run else {
        return Vec::new();
    };
    let options = rest.strip_prefix(&["run".into()]).unwrap_or(rest);
    let command = |name: &str, last: &[&str], file: Option<&Path>| {
        let mut words = vec![probe.clone(), name.into()];
        words.extend(options.iter().cloned());
        words.extend(last.iter().map(OsString::from));
        words.extend(file.map(|file| file.as_os_str().to_owned()));
        words
    };
    let address = format!("{:#x}", STM32F427.slot.start());
    let raw = ["--binary-format", "bin", "--base-address", &address];
    vec![
        command("download", &[], Some(&boot_elf(elf))),
        command("download", &raw, Some(image)),
        command("reset", &[], None),
        command("attach", &[], Some(elf)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bootloader_and_image_are_flashed_before_the_program_is_attached() {
        let run = ["probe-rs", "run", "--chip", "STM32F427ZITx"].map(OsString::from);
        let lines = commands(&run, Path::new("b/actuator-board"), Path::new("b/a.img"));
        let lines: Vec<String> = lines
            .iter()
            .map(|words| {
                words
                    .join(&OsString::from(" "))
                    .into_string()
                    .expect("ASCII")
            })
            .collect();
        let expected = [
            "probe-rs download --chip STM32F427ZITx b/actuator-boot",
            "probe-rs download --chip STM32F427ZITx --binary-format bin --base-address 0x8008000 b/a.img",
            "probe-rs reset --chip STM32F427ZITx",
            "probe-rs attach --chip STM32F427ZITx b/actuator-board",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn the_development_key_needs_a_bootloader_of_development() {
        let (build, public) = boot_build(None);
        assert!(build.contains(&"development-key") && public.is_none());
        let (build, public) = boot_build(Some(Path::new("release")));
        assert!(!build.contains(&"development-key"));
        assert_eq!(public, Some("release.pub".into()));
    }
}
