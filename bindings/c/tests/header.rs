//! The committed header agrees with the source.

use std::{fs, path::Path};

#[test]
fn the_header_agrees_with_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let sources =
        ["error", "settings", "actuator", "state"].map(|name| root.join(format!("src/{name}.rs")));
    let builder = cbindgen::Builder::new().with_config(config);
    let builder = sources.iter().fold(builder, |b, source| b.with_src(source));
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let path = root.join("include/actuator.h");
    if std::env::var_os("UPDATE_HEADER").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept.as_bytes() == made,
        "actuator.h differs from the source; UPDATE_HEADER=1 cargo test -p actuator-c updates it"
    );
}
