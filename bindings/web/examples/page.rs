//! Builds the core as WebAssembly and writes the page around it as one HTML file:
//! `cargo run -p actuator-web --example page -- [FILE]`, by default `actuator.html`.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use cross_build::WEB_TARGET;

const UPLOT: &str = "host-sim/assets/uplot";

fn main() -> Result<(), Box<dyn Error>> {
    let out = env::args().nth(1).unwrap_or_else(|| "actuator.html".into());
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let wasm = fs::read(build(&root)?)?;
    let page = assemble(&root, &wasm)?;
    fs::write(&out, &page)?;
    println!(
        "{out}: {} kB, of which the core is {} kB before base64",
        page.len() / 1000,
        wasm.len() / 1000
    );
    Ok(())
}

/// Builds the library for the browser and says where it is.
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

/// Puts every part into its place, marked as `{{name}}`.
fn assemble(root: &Path, wasm: &[u8]) -> Result<String, Box<dyn Error>> {
    let read = |path: String| {
        let path = root.join(path);
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let of_page = |name: &str| read(format!("bindings/web/page/{name}"));
    let parts = [
        ("uplot.css", read(format!("{UPLOT}/uPlot.min.css"))?),
        ("page.css", of_page("page.css")?),
        ("uplot.license", read(format!("{UPLOT}/LICENSE"))?),
        ("uplot.js", read(format!("{UPLOT}/uPlot.iife.min.js"))?),
        ("charts.js", of_page("charts.js")?),
        ("controls.js", of_page("controls.js")?),
        ("core.js", of_page("core.js")?),
        ("state.js", of_page("state.js")?),
        ("plots.js", of_page("plots.js")?),
        ("page.js", of_page("page.js")?),
        ("wasm", base64(wasm)),
    ];
    let mut page = of_page("page.html")?;
    for (name, part) in parts {
        let mark = format!("{{{{{name}}}}}");
        if page.matches(&mark).count() != 1 {
            return Err(format!("page.html has {mark} not exactly once").into());
        }
        page = page.replace(&mark, &part);
    }
    Ok(page)
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |i: usize| u32::from(group.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            if digit <= group.len() {
                text.push(DIGITS[(bits >> (18 - 6 * digit) & 63) as usize].into());
            } else {
                text.push('=');
            }
        }
    }
    text
}
