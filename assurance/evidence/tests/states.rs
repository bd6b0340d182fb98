//! The state of an experiment follows from its sources in a repository.

use std::fs;
use std::path::Path;
use std::process::Command;

use evidence::{Error, Evidence, Repository, State, record};
use tempfile::TempDir;

const EVIDENCE: &str = r#"# A comment that stays.
[sources]
program = ["firmware", "core/*.rs"]

[[experiment]]
id = "campaign"
claim = "No flip is silent."
command = "campaign"
sources = ["program", "campaign.rs"]

[[experiment]]
id = "proofs"
claim = "Nothing overflows."
command = "proofs"
sources = ["core"]
each_change = true
"#;

/// A repository with these sources.
struct Fixture {
    folder: TempDir,
    git: Repository,
}

impl Fixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let git = Repository::new(folder.path());
        let fixture = Self { folder, git };
        for path in [
            "firmware/a.rs",
            "core/b.rs",
            "core/readme.md",
            "campaign.rs",
        ] {
            fixture.write(path, "first");
        }
        fixture.write("evidence.toml", EVIDENCE);
        fixture.git(&["init", "--quiet"]);
        fixture.commit();
        fixture
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.folder.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn git(&self, arguments: &[&str]) {
        let mut git = Command::new("git");
        git.current_dir(self.folder.path()).args(arguments);
        assert!(git.status().unwrap().success(), "{arguments:?}");
    }

    fn commit(&self) {
        self.git(&["add", "."]);
        let author = ["-c", "user.name=a", "-c", "user.email=a@b"];
        self.git(&[&author[..], &["commit", "--quiet", "-m", "m"]].concat());
    }

    fn file(&self) -> std::path::PathBuf {
        self.folder.path().join("evidence.toml")
    }

    fn states(&self) -> Vec<State> {
        let evidence = Evidence::read(&self.file()).unwrap();
        let experiments = evidence.experiments.iter();
        experiments
            .map(|it| evidence.state(it, &self.git).unwrap())
            .collect()
    }

    fn record(&self, id: &str) -> Result<(), Error> {
        record(&self.file(), &self.git, id, "none")
    }
}

#[test]
fn a_changed_source_makes_its_experiment_stale_and_another_file_does_not() {
    let fixture = Fixture::new();
    assert_eq!(fixture.states(), [State::NotRun, State::EachChange]);
    fixture.record("campaign").unwrap();
    assert_eq!(fixture.states()[0], State::Current);
    fixture.commit();
    fixture.write("core/readme.md", "second");
    fixture.commit();
    assert_eq!(fixture.states()[0], State::Current);

    for path in ["firmware/a.rs", "core/b.rs", "campaign.rs", "core/new.rs"] {
        fixture.write(path, "second");
        // Before and after it is committed, and until the experiment has run again.
        assert_eq!(fixture.states()[0], State::Stale, "{path}");
        fixture.commit();
        assert_eq!(fixture.states()[0], State::Stale, "{path}");
        fixture.record("campaign").unwrap();
        assert_eq!(fixture.states()[0], State::Current, "{path}");
        fixture.commit();
    }
}

#[test]
fn a_record_keeps_the_rest_of_the_file() {
    let fixture = Fixture::new();
    fixture.record("campaign").unwrap();
    let text = fs::read_to_string(fixture.file()).unwrap();
    let recorded: Vec<&str> = (text.lines())
        .filter(|line| !EVIDENCE.lines().any(|other| other == *line))
        .collect();
    let keys = recorded.iter().map(|line| line.split(' ').next().unwrap());
    assert_eq!(keys.collect::<Vec<_>>(), ["result", "commit", "hash"]);
    assert_eq!(text.lines().count(), EVIDENCE.lines().count() + 3);
}

#[test]
fn sources_that_are_not_committed_or_do_not_exist_are_refused() {
    let fixture = Fixture::new();
    fixture.write("campaign.rs", "second");
    let error = fixture.record("campaign").unwrap_err();
    assert!(matches!(error, Error::Uncommitted { .. }), "{error}");
    assert!(matches!(fixture.record("x"), Err(Error::NoExperiment(_))));
    fixture.write("evidence.toml", &EVIDENCE.replace("campaign.rs", "c.rs"));
    let error = fixture.record("campaign").unwrap_err();
    assert!(
        matches!(&error, Error::NoSource(path) if path == "c.rs"),
        "{error}"
    );
}

#[test]
fn the_sources_of_every_experiment_of_this_project_exist() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let evidence = Evidence::read(&package.with_file_name("evidence.toml")).unwrap();
    let git = Repository::new(package.ancestors().nth(2).unwrap());
    for experiment in &evidence.experiments {
        evidence.state(experiment, &git).unwrap();
    }
}
