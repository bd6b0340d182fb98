//! Links and paths in the documents refer to existing files and sections.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// The workspace's folder.
fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every Markdown file below a folder, without templates and the folders of builds and package
/// managers.
fn documents(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder can be read") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_left_out = ["target", "node_modules", "templates"].contains(&&*name);
        if path.is_dir() && !name.starts_with('.') && !is_left_out {
            documents(&path, found);
        } else if name.ends_with(".md") {
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

fn has_anchor(document: &Path, wanted: &str) -> bool {
    let text = fs::read_to_string(document).unwrap_or_default();
    let mut headings = text.lines().filter(|line| line.starts_with('#'));
    headings.any(|heading| anchor(heading) == wanted)
}

#[test]
fn every_link_refers_to_an_existing_file_and_section() {
    let mut found = Vec::new();
    documents(&workspace(), &mut found);
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

#[test]
fn links_paths_and_anchors_are_recognised() {
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
}
