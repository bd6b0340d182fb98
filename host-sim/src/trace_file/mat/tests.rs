//! A separate reader, after the same chapter, parses the files.

use std::{collections::BTreeMap, io::Cursor};

use super::*;

/// What a file holds.
#[derive(Debug, PartialEq)]
enum Read {
    /// A column vector, as bits.
    Numbers(Vec<u64>),
    Text(String),
    Struct(BTreeMap<String, Read>),
}

/// Bytes that are taken from the front.
struct Elements<'a>(&'a [u8]);

impl<'a> Elements<'a> {
    fn take(&mut self, n: usize) -> &'a [u8] {
        let (front, rest) = self.0.split_at(n);
        self.0 = rest;
        front
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().expect("four bytes"))
    }

    /// The next element, which must be of this type.
    fn element(&mut self, kind: u32) -> &'a [u8] {
        let first = self.word();
        if first >> 16 != 0 {
            assert_eq!(first & 0xffff, kind);
            return &self.take(4)[..(first >> 16) as usize];
        }
        assert_eq!(first, kind);
        let bytes = self.word() as usize;
        let data = self.take(bytes);
        let padding = self.take(bytes.next_multiple_of(8) - bytes);
        assert!(padding.iter().all(|byte| *byte == 0));
        data
    }

    fn matrix(&mut self) -> (String, Read) {
        let mut parts = Elements(self.element(14));
        assert_eq!(parts.0.len() % 8, 0, "aligned");
        let class = Elements(parts.element(6)).word();
        let mut dimensions = Elements(parts.element(5));
        let [rows, columns] = [(); 2].map(|()| dimensions.word() as usize);
        assert!(dimensions.0.is_empty());
        let name = String::from_utf8(parts.element(1).to_vec()).expect("ASCII");
        let value = match class {
            6 => {
                let numbers = parts.element(9).as_chunks::<8>().0.iter();
                let numbers: Vec<u64> = numbers.map(|bytes| u64::from_le_bytes(*bytes)).collect();
                assert_eq!((numbers.len(), 1), (rows, columns));
                Read::Numbers(numbers)
            }
            4 => {
                let units = parts.element(4).as_chunks::<2>().0.iter();
                let units: Vec<u16> = units.map(|bytes| u16::from_le_bytes(*bytes)).collect();
                assert_eq!((1, units.len()), (rows, columns));
                Read::Text(String::from_utf16(&units).expect("UTF-16"))
            }
            2 => {
                assert_eq!((rows, columns), (1, 1));
                Read::Struct(parts.fields())
            }
            other => panic!("class {other}"),
        };
        assert!(parts.0.is_empty(), "{name}: {} bytes more", parts.0.len());
        (name, value)
    }

    fn fields(&mut self) -> BTreeMap<String, Read> {
        let room = Elements(self.element(5)).word() as usize;
        let names = self.element(1).chunks(room).map(|name| {
            let end = name.iter().position(|byte| *byte == 0);
            String::from_utf8(name[..end.expect("a zero ends it")].to_vec()).expect("ASCII")
        });
        names.map(|name| (name, self.matrix().1)).collect()
    }
}

/// The fields of the only variable of a file.
fn read(file: &[u8]) -> BTreeMap<String, Read> {
    let (header, variables) = file.split_at(128);
    assert!(header.starts_with(b"MATLAB 5.0 MAT-file"));
    assert_eq!(header[124..], [0, 1, b'I', b'M']);
    let mut variables = Elements(variables);
    let (name, value) = variables.matrix();
    assert_eq!(name, "trace");
    assert!(variables.0.is_empty(), "one variable");
    match value {
        Read::Struct(fields) => fields,
        other => panic!("{other:?}"),
    }
}

fn written(
    columns: &[&'static str],
    rows: &[Vec<f64>],
    description: &Description,
) -> BTreeMap<String, Read> {
    let file = Cursor::new(Vec::new());
    let mut mat =
        Mat::create(file, columns, rows.len() as u64, description).expect("memory takes it");
    for row in rows {
        mat.row(row).expect("memory takes it");
    }
    read(mat.finish().expect("memory takes it").get_ref())
}

fn text(text: &str) -> Read {
    Read::Text(text.into())
}

#[test]
fn every_column_is_read_back_bit_for_bit_for_any_number_of_rows() {
    let odd = [
        0.0,
        -0.0,
        f64::NAN,
        f64::INFINITY,
        5e-324,
        f64::MAX,
        1.0 / 3.0,
    ];
    for rows in [
        1,
        2,
        7,
        ROWS_AT_A_TIME - 1,
        ROWS_AT_A_TIME,
        ROWS_AT_A_TIME + 1,
        150_000,
    ] {
        let value = |row: usize, column: usize| match odd.get(row) {
            Some(odd) => *odd * (column as f64 - 1.0),
            None => row as f64 / (column as f64 + 3.0),
        };
        let rows: Vec<Vec<f64>> = (0..rows)
            .map(|row| (0..3).map(|column| value(row, column)).collect())
            .collect();
        let fields = written(
            &["time_s", "angle_deg", "compare_counts"],
            &rows,
            &Description::default(),
        );
        for (column, name) in ["time_s", "angle_deg", "compare_counts"]
            .into_iter()
            .enumerate()
        {
            let expected = rows.iter().map(|row| row[column].to_bits()).collect();
            assert!(fields[name] == Read::Numbers(expected), "{name}");
        }
    }
}

#[test]
fn units_texts_and_parameters_stand_beside_the_columns() {
    let description = Description {
        texts: vec![
            ("model", "board".into()),
            ("input", "Flüge/🛩.csv".into()),
            ("none", String::new()),
        ],
        groups: vec![(
            "parameters",
            vec![("position_gain", 10.0), ("limit", f64::INFINITY)],
        )],
    };
    let fields = written(&["time_s", "rate_deg_s"], &[vec![0.0, 1.0]], &description);
    let number = |value: f64| Read::Numbers(vec![value.to_bits()]);
    let structure = |fields: Vec<(&str, Read)>| {
        Read::Struct(
            fields
                .into_iter()
                .map(|(name, value)| (name.to_owned(), value))
                .collect(),
        )
    };
    let units = structure(vec![("time_s", text("s")), ("rate_deg_s", text("deg/s"))]);
    assert_eq!(fields["units"], units);
    let parameters = structure(vec![
        ("position_gain", number(10.0)),
        ("limit", number(f64::INFINITY)),
    ]);
    let meta = structure(vec![
        ("model", text("board")),
        ("input", text("Flüge/🛩.csv")),
        ("none", text("")),
        ("parameters", parameters),
    ]);
    assert_eq!(fields["meta"], meta);
}

#[test]
fn a_field_has_room_for_31_characters_or_where_one_needs_it_for_63() {
    let longest = "a_name_that_has_sixty_three_characters_which_is_what_matlab_has";
    for name in [
        "a_name_of_thirty_one_characters",
        "a_name_of_thirty_two_characters_",
        longest,
    ] {
        let fields = written(
            &["time_s", name],
            &[vec![0.0, 1.0]],
            &Description::default(),
        );
        assert_eq!(fields[name], Read::Numbers(vec![1f64.to_bits()]));
        assert_eq!(fields.len(), 4);
    }
}

#[test]
fn the_greatest_number_of_rows_is_that_of_two_gibibytes() {
    // Only the layout is checked: no data are written into the sparse file.
    let sized = |rows: u64| {
        let names = ["time_s", "a", "b", "c", "d", "e", "f", "g"];
        let description = Description::default();
        let value = variable(&names, rows, &description);
        layout::write(Holes::default(), "trace", &value).map(|(file, _)| file.end)
    };
    let most = most_rows(8);
    assert!(sized(most).expect("it goes") <= i32::MAX as u64);
    assert!(sized(2 * most).expect("the length fits its field") > i32::MAX as u64);
    assert!(sized(3 * most).is_err(), "too long for the length field");
}

/// A file of which only the end is known.
#[derive(Default)]
struct Holes {
    at: u64,
    end: u64,
}

impl Write for Holes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.seek(SeekFrom::Current(bytes.len() as i64))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Holes {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.at.wrapping_add_signed(by),
            SeekFrom::End(by) => self.end.wrapping_add_signed(by),
        };
        self.end = self.end.max(self.at);
        Ok(self.at)
    }
}
