//! The components of the release (SBOM): every crate that its programs and libraries are made of,
//! on any platform, as CycloneDX 1.5.
//!
//! The file depends on `Cargo.lock` and the manifests alone: it has no date and no serial number.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    process::Command,
};

use serde::Deserialize;
use serde_json::{Value, json};

use crate::{
    error::{Error, at},
    program::FEATURES,
    tools::{Tools, output},
};

/// The packages of which something is released.
const RELEASED: [&str; 8] = [
    "actuator",
    "actuator-c",
    "actuator-fmu",
    "actuator-python",
    "actuator-web",
    "board-f427",
    "board-h743",
    "bootloader",
];

/// What `cargo metadata` prints, as far as it is needed here.
#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Debug, Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    /// The registry; none for a package of this workspace.
    source: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

/// `dev` or `build`, or nothing for an ordinary dependency.
#[derive(Debug, Deserialize)]
struct Kind {
    kind: Option<String>,
}

impl Dependency {
    /// Whether it is needed for more than tests.
    fn is_built(&self) -> bool {
        self.dep_kinds
            .iter()
            .any(|kind| kind.kind.as_deref() != Some("dev"))
    }
}

impl Package {
    /// Its package URL.
    fn url(&self) -> String {
        format!("pkg:cargo/{}@{}", self.name, self.version)
    }

    fn component(&self) -> Value {
        let kind = match self.source {
            Some(_) => "library",
            None => "application",
        };
        let mut component = json!({
            "type": kind,
            "bom-ref": self.url(),
            "name": self.name,
            "version": self.version,
            "purl": self.url(),
        });
        if let Some(license) = &self.license {
            // Older crates separate alternatives by a slash.
            let expression = license.replace('/', " OR ");
            component["licenses"] = json!([{ "expression": expression }]);
        }
        component
    }
}

/// Writes the file.
pub fn make(_: &Tools, out: &Path) -> Result<(), Error> {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(cross_build::workspace()).args([
        "metadata",
        "--format-version",
        "1",
        "--locked",
        "--features",
        FEATURES,
    ]);
    let metadata = serde_json::from_slice(&output(&mut cargo)?)?;
    let path = out.join("components.cdx.json");
    let text = serde_json::to_string_pretty(&bill(&metadata))?;
    fs::write(&path, text + "\n").map_err(at(&path))
}

/// The bill of the packages that the released ones are built of, these included.
fn bill(metadata: &Metadata) -> Value {
    let nodes: BTreeMap<&str, &Node> =
        (metadata.resolve.nodes.iter().map(|node| (&*node.id, node))).collect();
    let packages: BTreeMap<&str, &Package> = (metadata
        .packages
        .iter()
        .map(|package| (&*package.id, package)))
    .collect();
    let is_released = |package: &&&Package| RELEASED.contains(&&*package.name);
    let mut left: Vec<&str> = (packages.values().filter(is_released))
        .map(|package| &*package.id)
        .collect();
    let mut found = BTreeSet::new();
    let built = |id: &str| {
        let dependencies = nodes.get(id).map_or(&[][..], |node| &node.deps);
        dependencies
            .iter()
            .filter(|dependency| dependency.is_built())
    };
    while let Some(id) = left.pop() {
        if found.insert(id) {
            left.extend(built(id).map(|dependency| &*dependency.pkg));
        }
    }
    let listed = || found.iter().filter_map(|id| packages.get(id));
    let dependencies = |package: &&Package| {
        let urls = built(&package.id).filter_map(|dependency| packages.get(&*dependency.pkg));
        let urls: BTreeSet<String> = urls.map(|package| package.url()).collect();
        json!({ "ref": package.url(), "dependsOn": urls })
    };
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": { "component": {
            "type": "application",
            "name": "smart-actuator",
            "version": env!("CARGO_PKG_VERSION"),
        } },
        "components": listed().map(|package| package.component()).collect::<Vec<_>>(),
        "dependencies": listed().map(dependencies).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A released package with an ordinary, a build and a dev dependency, of which the build
    /// dependency has one of its own.
    fn metadata() -> Metadata {
        let package = |name: &str| {
            json!({
                "id": name, "name": name, "version": "1.0.0",
                "license": "MIT/Apache-2.0", "source": "registry",
            })
        };
        let dependency =
            |name: &str, kind: Value| json!({ "pkg": name, "dep_kinds": [{ "kind": kind }] });
        let text = json!({
            "packages": (["actuator", "used", "builder", "tester", "deep"].map(package)),
            "resolve": { "nodes": [
                { "id": "actuator", "deps": [
                    dependency("used", Value::Null),
                    dependency("builder", json!("build")),
                    dependency("tester", json!("dev")),
                ] },
                { "id": "builder", "deps": [dependency("deep", Value::Null)] },
            ] },
        });
        serde_json::from_value(text).unwrap()
    }

    #[test]
    fn what_is_built_is_listed_once_and_what_only_tests_need_is_not() {
        let bill = bill(&metadata());
        let names: Vec<_> = (bill["components"].as_array().unwrap().iter())
            .map(|component| component["name"].as_str().unwrap())
            .collect();
        assert_eq!(names, ["actuator", "builder", "deep", "used"]);
        assert_eq!(
            bill["dependencies"][0],
            json!({
                "ref": "pkg:cargo/actuator@1.0.0",
                "dependsOn": ["pkg:cargo/builder@1.0.0", "pkg:cargo/used@1.0.0"],
            })
        );
        let license = &bill["components"][0]["licenses"][0]["expression"];
        assert_eq!(license, "MIT OR Apache-2.0");
    }
}
