//! The documents refer to files, sections and tests that exist.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

/// The workspace's folder.
fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file below a folder whose name ends in one of `suffixes`, without templates and the
/// folders of builds and package managers.
fn files(folder: &Path, suffixes: &[&str], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder can be read") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_left_out = ["target", "node_modules", "templates"].contains(&&*name);
        if path.is_dir() && !name.starts_with('.') && !is_left_out {
            files(&path, suffixes, found);
        } else if suffixes.iter().any(|suffix| name.ends_with(suffix)) {
            found.push(path);
        }
    }
}

/// The targets of `[text](target)` in a text, without web addresses.
fn links(text: &str) -> Vec<String> {
    let targets = text.split("](").skip(1);
    let targets = targets.filter_map(|rest| rest.split([')', ' ']).next());
    let is_local = |target: &&str| !target.starts_with("http") && !target.is_empty();
    targets.filter(is_local).map(str::to_owned).collect()
}

/// The paths in backquotes that name a file or folder of the workspace: with a slash, and with an
/// extension or a slash at the end.
fn paths(text: &str) -> Vec<String> {
    let is_path = |word: &&str| {
        let is_name = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
        let last = word.rsplit('/').next().unwrap_or_default();
        word.contains('/')
            && word.chars().all(is_name)
            && !word.starts_with(['/', '.'])
            && !word.starts_with("target/")
            && (last.is_empty() || last.contains('.'))
    };
    text.split('`')
        .skip(1)
        .step_by(2)
        .filter(is_path)
        .map(str::to_owned)
        .collect()
}

/// The anchor of a heading, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    text.chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn has_anchor(document: &Path, expected: &str) -> bool {
    let text = fs::read_to_string(document).unwrap_or_default();
    let mut headings = text.lines().filter(|line| line.starts_with('#'));
    headings.any(|heading| anchor(heading) == expected)
}

#[test]
fn every_link_refers_to_an_existing_file_and_section() {
    let mut found = Vec::new();
    files(&workspace(), &[".md"], &mut found);
    let mut broken = Vec::new();
    for document in &found {
        let text = fs::read_to_string(document).expect("a document");
        let folder = document.parent().expect("a file is in a folder");
        for link in links(&text) {
            let (file, section) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => document.clone(),
                file => folder.join(file),
            };
            if !target.exists() || (!section.is_empty() && !has_anchor(&target, section)) {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(found.len() > 10, "{found:?}");
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_path_in_the_guides_exists() {
    let mut missing = Vec::new();
    for guide in ["README.md", "CONTRIBUTING.md", "docs/architecture.md"] {
        let text = fs::read_to_string(workspace().join(guide)).expect("a guide");
        let paths = paths(&text);
        let absent = paths.iter().filter(|path| !workspace().join(path).exists());
        missing.extend(absent.map(|path| format!("{guide}: {path}")));
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

/// The functions that a source in Rust, Python or JavaScript declares.
fn functions(source: &str) -> impl Iterator<Item = &str> {
    let after = ["fn ", "def ", "function "].map(|keyword| source.split(keyword).skip(1));
    let names = after.into_iter().flatten().map(|rest| rest.split_once('('));
    names.flatten().map(|(name, _)| name)
}

/// The names of tests in backquotes: three words or more, joined by underscores.
fn named_tests(text: &str) -> impl Iterator<Item = &str> {
    let is_name = |word: &&str| {
        word.split('_').count() > 2
            && !word.ends_with('_')
            && word.starts_with(|c: char| c.is_ascii_lowercase())
            && word
                .chars()
                .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    text.split('`').skip(1).step_by(2).filter(is_name)
}

/// The functions that the sources in these folders declare.
fn declared(folders: &[&str]) -> HashSet<String> {
    let mut sources = Vec::new();
    for folder in folders {
        files(
            &workspace().join(folder),
            &[".rs", ".py", ".js"],
            &mut sources,
        );
    }
    let text = |path| fs::read_to_string(path).expect("a source");
    let names = |path| {
        functions(&text(path))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    sources.iter().flat_map(names).collect()
}

/// Number of rows of the tables whose last column is "verified by": each of them, and the whole
/// document, names tests that exist.
fn verified_claims(document: &str, tests: &HashSet<String>) -> usize {
    let text = fs::read_to_string(workspace().join(document)).expect("a document");
    let missing: Vec<&str> = named_tests(&text)
        .filter(|name| !tests.contains(*name))
        .collect();
    assert!(missing.is_empty(), "{document}: {missing:#?}");
    let mut claims = Vec::new();
    let mut is_claim = false;
    for line in text.lines() {
        if line.ends_with("| verified by |") {
            is_claim = true;
        } else if !line.starts_with('|') {
            is_claim = false;
        } else if is_claim && !line.ends_with("---|") {
            claims.push(line);
        }
    }
    let is_unverified = |row: &&&str| {
        let cell = row.trim_end_matches('|').rsplit('|').next();
        cell.is_none_or(|cell| named_tests(cell).next().is_none())
    };
    let unverified: Vec<_> = claims.iter().filter(is_unverified).collect();
    assert!(unverified.is_empty(), "{document}: {unverified:#?}");
    claims.len()
}

#[test]
fn every_claim_of_conformance_names_a_test_that_exists() {
    let tests = declared(&["canopen", "firmware/src", "firmware/tests", "tests/board"]);
    let claims = verified_claims("docs/conformance.md", &tests);
    assert!(claims > 50, "{claims}");
}

#[test]
fn every_mechanism_against_a_hazard_names_a_test_that_exists() {
    let tests = declared(&[
        "assurance",
        "boot",
        "canopen",
        "firmware",
        "host-sim",
        "model-core",
        "tests",
    ]);
    let claims = verified_claims("docs/trust.md", &tests);
    assert!(claims > 10, "{claims}");
}

#[test]
fn links_paths_anchors_and_tests_are_recognised() {
    assert_eq!(
        links("[a](b.md#c), [d](https://e), [f](g)"),
        ["b.md#c", "g"]
    );
    assert_eq!(
        paths("`a/b.rs`, `c/`, `d`, `--e/f`, `cargo x`"),
        ["a/b.rs", "c/"]
    );
    assert_eq!(
        anchor("## What it carries, and not"),
        "what-it-carries-and-not"
    );
    assert_eq!(
        named_tests("`a_b_c`, `a::b_c`, `A_b_c`, a_b_d, `a_b`").collect::<Vec<_>>(),
        ["a_b_c"]
    );
    let declared: Vec<&str> = functions("fn a_b() {} def c_d(self): function e_f(g) {}").collect();
    assert_eq!(declared, ["a_b", "c_d", "e_f"]);
}
