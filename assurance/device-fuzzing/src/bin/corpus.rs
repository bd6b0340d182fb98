//! Writes the inputs of `corpus.txt` to a folder, one in each file, or prints those of a folder as
//! its lines: `corpus unpack FOLDER`, `corpus pack FOLDER`.

#![forbid(unsafe_code)]

use std::error::Error;
use std::path::Path;
use std::{env, fs};

use device_fuzzing::corpus;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["unpack", folder] => unpack(Path::new(folder)),
        ["pack", folder] => pack(Path::new(folder)),
        _ => Err("expected `unpack FOLDER` or `pack FOLDER`".into()),
    }
}

fn unpack(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    for (number, input) in corpus::all().enumerate() {
        fs::write(folder.join(format!("found-{number}")), input)?;
    }
    Ok(())
}

fn pack(folder: &Path) -> Result<(), Box<dyn Error>> {
    let entries = fs::read_dir(folder)?;
    let inputs = entries.map(|entry| fs::read(entry?.path()));
    let mut inputs = inputs.collect::<Result<Vec<_>, _>>()?;
    inputs.sort_by_key(|input| (input.len(), input.clone()));
    inputs
        .iter()
        .for_each(|input| println!("{}", corpus::line(input)));
    Ok(())
}
