//! Rust of the control tables in `tables/`.

use std::fmt::Write as _;
use std::{env, fs, path::Path};

/// A file: the module of its registers, the order of the bytes of a value, and its models.
struct File {
    module: &'static str,
    order: &'static str,
    models: &'static [Model],
}

/// A model and its indirect registers: first address of the addresses, of the data, number.
struct Model {
    name: &'static str,
    indirect: &'static [(u16, u16, u16)],
}

const FILES: [File; 3] = [
    File {
        module: "sts",
        order: "Little",
        models: &[model("sts3215", &[]), model("sts3250", &[])],
    },
    File {
        module: "scs",
        order: "Big",
        models: &[model("scs0009", &[])],
    },
    File {
        module: "x",
        order: "Little",
        models: &[
            model("xl330-m288", &[(168, 208, 20)]),
            model("xm430-w350", &[(168, 224, 28), (578, 634, 28)]),
        ],
    },
];

const fn model(name: &'static str, indirect: &'static [(u16, u16, u16)]) -> Model {
    Model { name, indirect }
}

fn main() {
    let mut rust = String::new();
    for File {
        module,
        order,
        models,
    } in FILES
    {
        let path = format!("tables/{module}.csv");
        println!("cargo::rerun-if-changed={path}");
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let rows: Vec<Vec<&str>> = text
            .lines()
            .skip(1)
            .map(|l| l.split(',').collect())
            .collect();
        for (row, line) in rows.iter().zip(2..) {
            assert_eq!(row.len(), 13, "{path}:{line}: expected 13 fields");
        }
        write_fields(&mut rust, module, &rows);
        write_family(&mut rust, module, &rows);
        for model in models {
            write_table(&mut rust, &rows, model, module, order);
        }
    }
    let out = env::var("OUT_DIR").expect("set by cargo");
    fs::write(Path::new(&out).join("tables.rs"), rust).expect("writable");
}

/// The constants of a family; rows that models have of their own agree in all but the values.
fn write_fields(rust: &mut String, module: &str, rows: &[Vec<&str>]) {
    let _ = writeln!(
        rust,
        "/// Registers of `tables/{module}.csv`.\npub mod {module} {{"
    );
    let _ = writeln!(rust, "use super::super::table::{{Field, Sign}};");
    let mut names = Vec::new();
    for row in rows {
        let name = row[3].to_uppercase();
        if !names.contains(&name) {
            let _ = writeln!(
                rust,
                "/// `{}`\npub const {name}: Field = {};",
                row[3],
                field(row)
            );
            names.push(name);
        }
    }
    let _ = writeln!(rust, "}}");
}

fn field(row: &[&str]) -> String {
    let sign = match row[6] {
        "" => "Sign::None".to_owned(),
        "two" => "Sign::Two".to_owned(),
        bit => format!("Sign::Bit({bit})"),
    };
    format!(
        "Field {{ address: {}, size: {}, sign: {sign} }}",
        row[1], row[2]
    )
}

/// Index and sub-index of an object that is written as 607Ah:0; of none if it is empty.
fn object(text: &str) -> String {
    if text.is_empty() {
        return "None".to_owned();
    }
    let (index, sub) =
        (text.split_once("h:")).unwrap_or_else(|| panic!("{text}: expected 607Ah:0"));
    format!("Some((0x{index}, {sub}))")
}

/// The registers that all models of a family have.
fn write_family(rust: &mut String, module: &str, rows: &[Vec<&str>]) {
    let shared = rows.iter().filter(|row| row[0].is_empty());
    let _ = writeln!(
        rust,
        "static {}: [Register; {}] = [{}];",
        module.to_uppercase(),
        shared.clone().count(),
        shared.map(|row| register(row)).collect::<String>()
    );
}

fn write_table(rust: &mut String, rows: &[Vec<&str>], model: &Model, module: &str, order: &str) {
    let &Model {
        name: model,
        indirect,
    } = model;
    let own = rows.iter().filter(|row| row[0] == model);
    let all = rows
        .iter()
        .filter(|row| row[0].is_empty() || row[0] == model);
    let lock = rows.iter().find(|row| row[3] == "lock");
    let lock = lock.map_or("None".to_owned(), |row| format!("Some({})", field(row)));
    let number = |text: &str| -> u16 { text.parse().expect("a number") };
    let direct = all.clone().map(|row| number(row[1]) + number(row[2]));
    let pointed = indirect.iter().map(|(_, data, number)| data + number);
    let current = all.clone().find(|row| row[3] == "present_current");
    let _ = writeln!(
        rust,
        "/// Control table of the model `{model}`.\npub static {}: Table = Table {{ \
         #[cfg(feature = \"names\")] name: \"{model}\", order: Order::{order}, lock: {lock}, \
         indirect: &{indirect:?}, end: {}, current_ua: {}, registers: Registers {{ \
         of_family: &{}, of_model: &[{}] }} }};",
        model.replace('-', "_").to_uppercase(),
        direct.chain(pointed).max().unwrap_or(0),
        current.map_or(0, |row| micro_amperes(row[10])),
        module.to_uppercase(),
        own.map(|row| register(row)).collect::<String>()
    );
}

/// Of a unit that is written as 6.5 mA.
fn micro_amperes(unit: &str) -> u16 {
    let number = unit.strip_suffix(" mA").and_then(|text| text.parse().ok());
    let number: f64 = number.unwrap_or_else(|| panic!("{unit}: expected mA"));
    (number * 1000.0).round() as u16
}

fn register(row: &[&str]) -> String {
    format!(
        "Register {{ #[cfg(feature = \"names\")] name: \"{}\", #[cfg(feature = \"names\")] \
         unit: \"{}\", #[cfg(feature = \"names\")] object: {}, #[cfg(feature = \"names\")] \
         meaning: \"{}\", field: {}, is_writable: {}, \
         is_eeprom: {}, min: {}, max: {}, default: {} }},",
        row[3],
        row[10],
        object(row[11]),
        row[12],
        field(row),
        row[4] == "rw",
        row[5] == "eeprom",
        row[7],
        row[8],
        row[9]
    )
}
