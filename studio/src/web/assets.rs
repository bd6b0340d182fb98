//! The files of the page, which are part of the program.

use std::sync::LazyLock;

use host_sim::plot::html::{FIGURE_JS, UPLOT_CSS, UPLOT_JS};
use host_sim::plot::palette::{PALETTE, PALETTE_DARK};

/// A file that a browser may load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asset {
    /// Its path.
    pub path: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// Its content.
    pub text: &'static str,
}

/// The page.
pub const PAGE: Asset = Asset {
    path: "/",
    kind: "text/html; charset=utf-8",
    text: include_str!("../../page/index.html"),
};

const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

macro_rules! scripts {
    ($($name:literal),+ $(,)?) => {
        &[
            Asset { path: "/uplot.js", kind: SCRIPT, text: UPLOT_JS },
            Asset { path: "/figure.js", kind: SCRIPT, text: FIGURE_JS },
            Asset { path: "/uplot.css", kind: STYLE, text: UPLOT_CSS },
            Asset { path: "/style.css", kind: STYLE, text: include_str!("../../page/style.css") },
            $(Asset {
                path: concat!("/", $name),
                kind: SCRIPT,
                text: include_str!(concat!("../../page/", $name)),
            }),+
        ]
    };
}

/// Everything that the page loads. Nothing of it is secret.
pub const FILES: &[Asset] = scripts![
    "main.js",
    "socket.js",
    "state.js",
    "dom.js",
    "number.js",
    "ring.js",
    "plot.js",
    "save.js",
    "control.js",
    "devices.js",
    "live.js",
    "move.js",
    "excitation.js",
    "parameters.js",
    "tune.js",
    "identify.js",
    "faults.js",
    "bus.js",
    "commission.js",
    "health.js",
    "life.js",
    "topics.js",
    "tour.js",
    "servo-devices.js",
    "servo-move.js",
    "servo-parameters.js",
    "xy.js",
];

/// The colours of the curves, those of all figures of the project.
static COLOURS: LazyLock<String> = LazyLock::new(|| {
    let list = |palette: &[&str]| -> String {
        let colours = palette.iter().enumerate();
        colours
            .map(|(i, colour)| format!("--c{i}:{colour};"))
            .collect()
    };
    let (light, dark) = (list(&PALETTE), list(&PALETTE_DARK));
    format!(":root{{{light}}}@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n")
});

/// The file of this path.
pub fn find(path: &str) -> Option<Asset> {
    if path == "/colours.css" {
        return Some(Asset {
            path: "/colours.css",
            kind: STYLE,
            text: COLOURS.as_str(),
        });
    }
    FILES.iter().find(|asset| asset.path == path).copied()
}
