//! Records that an experiment has run.

use std::fs;
use std::path::Path;

use toml_edit::{DocumentMut, Item, Table, value};

use crate::{Error, Evidence, Repository};

/// Records in the file that an experiment has run with the sources of the last commit, and its
/// result.
///
/// # Errors
/// There is no such experiment, its sources differ from the last commit, or the file cannot be
/// written.
pub fn record(path: &Path, git: &Repository, id: &str, result: &str) -> Result<(), Error> {
    let evidence = Evidence::read(path)?;
    let paths = evidence.paths(evidence.experiment(id)?);
    let files = git.uncommitted(&paths)?;
    if !files.is_empty() {
        let id = id.into();
        return Err(Error::Uncommitted { id, files });
    }
    let at = |source| Error::File {
        path: path.into(),
        source,
    };
    let text = fs::read_to_string(path).map_err(at)?;
    let mut document: DocumentMut = text.parse().map_err(|error| Error::Format {
        path: path.into(),
        source: Box::new(toml_edit::de::Error::from(error)),
    })?;
    let is_it = |table: &&mut Table| table.get("id").and_then(Item::as_str) == Some(id);
    let experiments = document["experiment"].as_array_of_tables_mut();
    for table in (experiments.into_iter()).flat_map(|all| all.iter_mut().filter(is_it)) {
        table["result"] = value(result);
        table["commit"] = value(git.commit()?);
        table["hash"] = value(git.hash(&paths)?);
    }
    fs::write(path, document.to_string()).map_err(at)
}
