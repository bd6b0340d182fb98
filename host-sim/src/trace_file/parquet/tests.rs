//! The files are read back with the library's reader.

use std::{collections::BTreeMap, fs::File};

use parquet::{
    file::reader::{FileReader, SerializedFileReader},
    record::RowAccessor,
};

use super::*;

fn written(rows: usize) -> (Vec<[f64; 2]>, SerializedFileReader<File>) {
    let description = Description {
        texts: vec![("model", "board".into())],
        groups: vec![(
            "parameters",
            vec![("limit", f64::INFINITY), ("third", 1.0 / 3.0)],
        )],
    };
    let odd = [0.0, -0.0, f64::NAN, f64::NEG_INFINITY, 5e-324, f64::MAX];
    let value = |row: usize| *odd.get(row).unwrap_or(&(row as f64 / 3.0));
    let rows: Vec<_> = (0..rows).map(|row| [row as f64, value(row)]).collect();
    let file = tempfile::tempfile().expect("a file");
    let mut parquet =
        Parquet::create(file, &["time_s", "angle_deg"], &description).expect("the file is written");
    for row in &rows {
        parquet.row(row).expect("the file is written");
    }
    let file = parquet.finish().expect("the file is written");
    (rows, SerializedFileReader::new(file).expect("it is one"))
}

#[test]
fn every_column_is_read_back_bit_for_bit_from_several_groups() {
    for (rows, groups) in [
        (1, 1),
        (1000, 1),
        (ROWS_OF_A_GROUP, 1),
        (ROWS_OF_A_GROUP + 1, 2),
    ] {
        let (expected, reader) = written(rows);
        assert_eq!(reader.num_row_groups(), groups);
        let read = reader.get_row_iter(None).expect("it has rows").map(|row| {
            let row = row.expect("a row");
            [0, 1].map(|column| row.get_double(column).expect("a double").to_bits())
        });
        assert!(read.eq(expected.iter().map(|row| row.map(f64::to_bits))));
    }
}

#[test]
fn the_description_and_the_units_are_its_metadata() {
    let (_, reader) = written(1);
    let metadata = reader.metadata().file_metadata();
    let pairs = metadata.key_value_metadata().expect("some").iter();
    let pairs: BTreeMap<_, _> = pairs
        .map(|pair| (pair.key.as_str(), pair.value.as_deref().unwrap_or_default()))
        .collect();
    let expected = [
        ("model", "board"),
        ("parameters.limit", "inf"),
        ("parameters.third", "0.3333333333333333"),
        ("units.angle_deg", "deg"),
        ("units.time_s", "s"),
    ];
    assert_eq!(pairs, BTreeMap::from(expected));
}
