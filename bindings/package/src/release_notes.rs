//! The release notes: what has changed, what is not verified, and the checksums of what is flashed.

use std::{fs, path::Path};

use sha2::{Digest, Sha256};

use crate::error::{Error, at};

const NAME: &str = "RELEASE-NOTES.md";

/// Types of the files that are the same bytes for the same source, toolchain and key. ELF files
/// name folders.
const REPRODUCIBLE: [&str; 2] = ["bin", "img"];

/// Begin of the list of stale experiments.
const UNVERIFIED: &str = "
## Unverified

These experiments of `assurance/evidence.toml` have not run with the sources of this release:

";

/// Begin of the list of checksums.
const SUMS: &str = "
## SHA-256 of the boards' programs

The same source, toolchain and key give the same bytes.

| file | SHA-256 |
|---|---|
";

/// Writes the notes of this version from the list of all changes. They have the stale experiments,
/// if there are any, and the checksums of the boards' programs in this folder, if there is one.
pub fn write(
    changes: &str,
    boards: Option<&Path>,
    stale: Option<&str>,
    out: &Path,
) -> Result<(), Error> {
    let version = env!("CARGO_PKG_VERSION");
    let section = section(changes, version).ok_or(Error::NoChanges(version))?;
    let mut text = format!("# {section}\n");
    if let Some(stale) = stale {
        text += &format!("{UNVERIFIED}```text\n{stale}\n```\n");
    }
    if let Some(folder) = boards {
        text += SUMS;
        text += &sums(folder)?;
    }
    let place = out.join(NAME);
    fs::write(&place, text).map_err(at(&place))
}

/// The section of a version in a list of changes, without the marks of its heading.
fn section<'a>(changes: &'a str, version: &str) -> Option<&'a str> {
    let mut sections = changes.split("\n## ").skip(1);
    let of_version = sections.find(|text| text.split_whitespace().next() == Some(version));
    of_version.map(str::trim_end)
}

/// Rows of a table with the names and checksums of the files in a folder.
fn sums(folder: &Path) -> Result<String, Error> {
    let mut rows = Vec::new();
    for entry in fs::read_dir(folder).map_err(at(folder))? {
        let path = entry.map_err(at(folder))?.path();
        let kind = path.extension().unwrap_or_default();
        if REPRODUCIBLE.iter().any(|other| kind == *other) {
            let bytes = fs::read(&path).map_err(at(&path))?;
            let name = path.strip_prefix(folder).unwrap_or(&path).display();
            rows.push(format!("| `{name}` | `{:x}` |\n", Sha256::digest(&bytes)));
        }
    }
    rows.sort();
    Ok(rows.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_notes_are_the_changes_of_this_version_and_the_sums_of_what_is_flashed() {
        let folder = tempfile::tempdir().expect("a folder");
        let version = env!("CARGO_PKG_VERSION");
        let changes = format!(
            "# Changes\n\n## 99.0.0\n\nLater.\n\n## {version}\n\nThis.\n\n## 0.0.1\n\nOld.\n"
        );
        let notes = |boards| {
            write(&changes, boards, None, folder.path()).expect("the notes");
            fs::read_to_string(folder.path().join(NAME)).expect("the file")
        };
        assert_eq!(notes(None), format!("# {version}\n\nThis.\n"));
        let boards = folder.path().join("boards");
        fs::create_dir(&boards).expect("a folder in it");
        for name in ["b.img", "a.bin", "a.elf"] {
            fs::write(boards.join(name), "abc").expect("a file");
        }
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let rows = format!("|---|---|\n| `a.bin` | `{sum}` |\n| `b.img` | `{sum}` |\n");
        assert!(notes(Some(&boards)).ends_with(&rows));
        let stale = Some("stale  campaign: no flip is silent");
        write(&changes, Some(&boards), stale, folder.path()).expect("the notes");
        let text = fs::read_to_string(folder.path().join(NAME)).expect("the file");
        assert!(text.contains("\n## Unverified\n") && text.contains("\nstale  campaign: "));
        assert!(text.ends_with(&rows));
    }

    #[test]
    fn a_version_without_changes_and_a_folder_that_is_missing_are_errors() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("boards");
        let write = |changes, boards| write(changes, boards, None, folder.path());
        assert!(matches!(
            write("# Changes\n", None),
            Err(Error::NoChanges(_))
        ));
        let changes = format!("\n## {}\n", env!("CARGO_PKG_VERSION"));
        assert!(matches!(
            write(&changes, Some(&missing)),
            Err(Error::File { .. })
        ));
    }
}
