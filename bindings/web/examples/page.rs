//! Builds the core as WebAssembly and writes the page around it as one HTML file:
//! `cargo run -p actuator-web --example page -- [FILE]`, by default `actuator.html`.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use askama::Template;
use base64::prelude::{BASE64_STANDARD, Engine as _};
use cross_build::WEB_TARGET;

const UPLOT_CSS: &str = include_str!("../../../host-sim/assets/uplot/uPlot.min.css");
const UPLOT_JS: &str = include_str!("../../../host-sim/assets/uplot/uPlot.iife.min.js");
const UPLOT_LICENSE: &str = include_str!("../../../host-sim/assets/uplot/LICENSE");
const PAGE_CSS: &str = include_str!("../page/page.css");
const CORE_JS: &str = include_str!("../page/core.js");
const WORKER_JS: &str = include_str!("../page/worker.js");
const CHARTS_JS: &str = include_str!("../page/charts.js");
const CONTROLS_JS: &str = include_str!("../page/controls.js");
const STATE_JS: &str = include_str!("../page/state.js");
const PLOTS_JS: &str = include_str!("../page/plots.js");
const PAGE_JS: &str = include_str!("../page/page.js");

/// The page around the core.
#[derive(Template)]
#[template(path = "page.html")]
struct Page {
    /// The core in base64.
    wasm: String,
}

fn main() -> Result<(), Box<dyn Error>> {
    let out = env::args().nth(1).unwrap_or_else(|| "actuator.html".into());
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let wasm = fs::read(build(&root)?)?;
    let page = Page {
        wasm: BASE64_STANDARD.encode(&wasm),
    };
    let page = page.render()?;
    fs::write(&out, &page)?;
    println!(
        "{out}: {} kB, of which the core is {} kB before base64",
        page.len() / 1000,
        wasm.len() / 1000
    );
    Ok(())
}

/// Builds the library for the browser and returns its path.
fn build(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let target = match env::var_os("CARGO_TARGET_DIR") {
        Some(target) => PathBuf::from(target),
        None => root.join("target"),
    };
    let arguments = ["build", "--profile=web", "-p=actuator-web", "--lib"];
    let arguments = [&arguments[..], &["--target", WEB_TARGET]].concat();
    cross_build::build(WEB_TARGET, &arguments, &target)?;
    Ok(target.join(WEB_TARGET).join("web/actuator_web.wasm"))
}
