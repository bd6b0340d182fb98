//! The page of the downloads: which file is for whom.

use std::{fs, path::Path};

use crate::{
    checksums,
    error::{Error, at},
};

const NAME: &str = "index.html";

/// Files, as a name or the ends of names in a folder; for whom they are; how to begin.
const ROWS: [(&str, &str, &str); 16] = [
    (
        "actuator",
        "Linux on x86-64 with glibc 2.17 or later: everything on the command line, and Studio in the browser",
        "chmod +x actuator && ./actuator demo",
    ),
    (
        "actuator-static",
        "any other Linux on x86-64, as Alpine or a container without libraries; the same program, somewhat slower",
        "chmod +x actuator-static && ./actuator-static demo",
    ),
    (
        "actuator-aarch64",
        "any Linux on 64-bit ARM, as a Raspberry Pi",
        "chmod +x actuator-aarch64 && ./actuator-aarch64 demo",
    ),
    (
        "actuator.exe",
        "Windows on x86-64; the same program",
        "actuator.exe demo",
    ),
    (
        "*.whl",
        "Python from 3.9 on Linux on x86-64 with glibc; contains the plugin of MuJoCo",
        "pip install smart_actuator-*.whl",
    ),
    (
        "mujoco/*.so",
        "MuJoCo on Linux on x86-64 without Python, as its program simulate",
        "copy it into the folder mujoco_plugin beside the program",
    ),
    (
        "wheels/*2_17_aarch64.whl",
        "Python from 3.9 on Linux on 64-bit ARM with glibc, as a Raspberry Pi",
        "pip install wheels/*2_17_aarch64.whl",
    ),
    (
        "wheels/*1_2_x86_64.whl",
        "Python from 3.9 on Linux on x86-64 with musl, as Alpine; without the plugin of MuJoCo",
        "pip install wheels/*1_2_x86_64.whl",
    ),
    (
        "wheels/*1_2_aarch64.whl",
        "the same on 64-bit ARM",
        "pip install wheels/*1_2_aarch64.whl",
    ),
    (
        "fmi2/*.fmu",
        "Simulink, Dymola, OpenModelica and other tools with FMI 2.0",
        "import the file; board.fmu is the whole actuator",
    ),
    ("fmi3/*.fmu", "tools with FMI 3.0", "import the file"),
    (
        "c/*",
        "C and C++: header, static and shared library, pkg-config, CMake",
        "copy the folder below a prefix",
    ),
    (
        "boards/*",
        "owners of a board: programs to flash, signed images (.img) for updates over CAN, and the same programs as ELF; without a board, <code>actuator serve --boards boards</code> emulates them",
        "actuator update actuator-board.img --bus can0",
    ),
    (
        "smart-actuator.eds",
        "CANopen masters",
        "import the file; object-dictionary.md explains it",
    ),
    (
        "pages/*",
        "readers: the simulated figures of the paper, and the script for other pages",
        "open actuator-report.html",
    ),
    (
        "components.cdx.json",
        "auditors: all components with their licences (CycloneDX)",
        "SHA256SUMS has all checksums: sha256sum --check SHA256SUMS",
    ),
];

const HEAD: &str = "<!DOCTYPE html>
<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">
<title>smart-actuator: downloads</title>
<style>:root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem}
td,th{text-align:left;vertical-align:top;padding:.4rem .8rem .4rem 0;border-bottom:1px solid #8888}code{overflow-wrap:anywhere}.sum{font-size:.75em;opacity:.75}</style></head><body>
<h1>smart-actuator VERSION</h1>
<p>No file needs Rust. To see it move: the program for your system, then the command beside it.</p>
<table><thead><tr><th>File</th><th>For</th><th>Begin with</th></tr></thead><tbody>
";

/// Writes the page with the files that are there.
pub fn write(folder: &Path) -> Result<(), Error> {
    let place = folder.join(NAME);
    let files = checksums::files(folder)?;
    let mut page = HEAD.replace("VERSION", env!("CARGO_PKG_VERSION"));
    for (pattern, whom, begin) in ROWS {
        let mut names = String::new();
        for path in &files {
            let name = path.strip_prefix(folder).unwrap_or(path);
            let name = name.to_string_lossy().replace('\\', "/");
            if !is_named(&name, pattern) {
                continue;
            }
            let kilobytes = fs::metadata(path).map_err(at(path))?.len().div_ceil(1000);
            let sum = checksums::sum(path)?;
            names += &format!(
                "<div><a href=\"{name}\">{name}</a>, {kilobytes} kB<br><code class=\"sum\">{sum}</code></div>"
            );
        }
        if !names.is_empty() {
            page +=
                &format!("<tr><td>{names}</td><td>{whom}</td><td><code>{begin}</code></td></tr>\n");
        }
    }
    page += "</tbody></table>\n<p>The lines below the names are SHA-256. \
             <a href=\"RELEASE-NOTES.md\">Changes</a>, licences: MIT or Apache-2.0.</p>\n</body></html>\n";
    fs::write(&place, page).map_err(at(&place))
}

/// Whether a file has this name, or is in the folder with the end of its name before and behind
/// `*`.
fn is_named(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((folder, end)) => {
            let rest = name.strip_prefix(folder);
            rest.is_some_and(|rest| {
                rest.ends_with(end) && (folder.ends_with('/') || !rest.contains('/'))
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_file_is_listed_once_with_its_sum_and_what_is_not_there_is_not() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["boards", "wheels"] {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        let names = [
            "actuator",
            "a.whl",
            "wheels/a_1_2_x86_64.whl",
            "boards/b.img",
        ];
        for name in names {
            fs::write(folder.path().join(name), "abc").unwrap();
        }
        for _ in 0..2 {
            write(folder.path()).unwrap();
        }
        let page = fs::read_to_string(folder.path().join(NAME)).unwrap();
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(page.matches(sum).count(), names.len());
        for name in names {
            assert_eq!(page.matches(&format!(">{name}</a>")).count(), 1, "{name}");
        }
        assert!(!page.contains("actuator.exe</a>"));
    }
}
