//! Reads MAT files of level 5: those of `actuator simulate --out`, of `save` in Octave and MATLAB
//! up to version 7, and of scipy.
//!
//! After MathWorks, "MAT-File Format", chapter "Level 5 MAT-File Format". The columns are the
//! numeric vectors and the columns of the matrices in one struct, or beside each other in the file.
//! Everything else is left out.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::{
    matrix,
    source::MOST_BYTES,
    table::{Column, Group},
};

// Table "MAT-File Data Types".
const MI_UTF8: u32 = 16;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

// Table "MATLAB Array Types (Classes)".
const MX_STRUCT: u32 = 2;
const MX_OBJECT: u32 = 3;
const MX_OPAQUE: u32 = 17;
const MX_NUMBERS: std::ops::RangeInclusive<u32> = 6..=15;
/// Bit of the flags of an array with an imaginary part.
const COMPLEX: u32 = 0x0800;

/// The length of the head of a file.
const HEAD: usize = 128;

/// The groups of columns in a file: those of each struct, and those beside each other.
pub fn groups(bytes: &[u8]) -> Result<Vec<Group>, String> {
    let expected = "expected a MAT file of level 5, as `save -v6` or `save -v7` writes it";
    let (head, mut rest) = bytes.split_at_checked(HEAD).ok_or(expected)?;
    // Version 1.0, and `MI` as a processor of this byte order writes it.
    if head[124..] != *b"\x00\x01IM" {
        return Err(expected.into());
    }
    let (mut beside, mut groups, mut objects) = (Vec::new(), Vec::new(), Vec::new());
    while !rest.is_empty() {
        let element = Element::next(&mut rest).ok_or("the file is cut off")?;
        let inflated;
        let matrix = match element.kind {
            MI_COMPRESSED => {
                inflated = element.inflated()?;
                Element::next(&mut &*inflated).ok_or("a compressed variable is cut off")?
            }
            _ => element,
        };
        match matrix.value(None).ok_or("a variable is damaged")? {
            (_, Value::Numbers(columns)) => beside.extend(columns),
            (name, Value::Struct(fields)) => groups.push((name, fields)),
            (name, Value::Object) => objects.push(name),
            (_, Value::Other) => {}
        }
    }
    groups.push((String::new(), beside));
    match objects.first() {
        Some(name) if groups.iter().all(|(_, columns)| columns.is_empty()) => Err(format!(
            "`{name}` is an object, as a timetable or iddata, expected vectors: of a timetable \
             `time_s = seconds(x.Time); angle_deg = x.angle;`, of iddata `time_s = \
             x.SamplingInstants; command_deg = x.u; angle_deg = x.y;`"
        )),
        _ => Ok(groups),
    }
}

/// A data element: a tag and its content.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

/// What is read of an array.
enum Value {
    /// The columns of a vector or a matrix.
    Numbers(Vec<Column>),
    /// Those of the fields of a struct.
    Struct(Vec<Column>),
    Object,
    Other,
}

impl<'a> Element<'a> {
    /// The first element; `rest` is then what follows it. `None` if it is cut off.
    fn next(rest: &mut &'a [u8]) -> Option<Self> {
        let word = |bytes: &[u8]| Some(u32::from_le_bytes(bytes.first_chunk().copied()?));
        let first = word(rest)?;
        // A small element has its length in the upper half of the first word.
        if first >> 16 != 0 {
            let data = rest.get(4..4 + (first >> 16) as usize)?;
            *rest = rest.get(8..)?;
            let kind = first & 0xffff;
            return (data.len() <= 4).then_some(Self { kind, data });
        }
        let length = word(rest.get(4..)?)? as usize;
        let data = rest.get(8..)?.get(..length)?;
        // Elements begin at multiples of 8 bytes, but for compressed ones.
        let padded = match first {
            MI_COMPRESSED => length,
            _ => length.next_multiple_of(8),
        };
        *rest = rest.get(8 + padded..).unwrap_or_default();
        Some(Self { kind: first, data })
    }

    fn inflated(&self) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut source = ZlibDecoder::new(self.data).take(MOST_BYTES);
        let read = source.read_to_end(&mut bytes);
        read.map_err(|error| format!("a variable cannot be decompressed: {error}"))?;
        Ok(bytes)
    }

    /// The name and the content of an array, whose name in a struct is this one. `None` if it is
    /// damaged.
    fn value(&self, field: Option<String>) -> Option<(String, Value)> {
        if self.kind != MI_MATRIX {
            return Some((String::new(), Value::Other));
        }
        let mut rest = self.data;
        let flags = Element::next(&mut rest)?.numbers()?;
        let flags = *flags.first()? as u32;
        let class = flags & 0xff;
        if class == MX_OPAQUE {
            return Some((Element::next(&mut rest)?.text(), Value::Object));
        }
        let sizes = Element::next(&mut rest)?.numbers()?;
        let name = Element::next(&mut rest)?.text();
        let name = field.unwrap_or(name);
        let count: f64 = sizes.iter().product();
        let value = match class {
            MX_STRUCT if count == 1.0 => Value::Struct(fields(rest)?),
            MX_OBJECT => Value::Object,
            _ if MX_NUMBERS.contains(&class) && flags & COMPLEX == 0 => {
                let numbers = Element::next(&mut rest)?.numbers()?;
                if numbers.len() as f64 != count {
                    return None;
                }
                // Columns are contiguous.
                let sizes: Vec<usize> = sizes.iter().rev().map(|size| *size as usize).collect();
                Value::Numbers(matrix::rows(&name, &sizes, numbers))
            }
            _ => Value::Other,
        };
        Some((name, value))
    }

    /// The numbers of any type. `None` for other types.
    fn numbers(&self) -> Option<Vec<f64>> {
        fn each<const N: usize>(data: &[u8], of: impl Fn([u8; N]) -> f64) -> Option<Vec<f64>> {
            let (numbers, rest) = data.as_chunks();
            rest.is_empty()
                .then(|| numbers.iter().map(|bytes| of(*bytes)).collect())
        }
        let data = self.data;
        match self.kind {
            1 => each(data, |b| i8::from_le_bytes(b).into()),
            2 => each(data, |b| u8::from_le_bytes(b).into()),
            3 => each(data, |b| i16::from_le_bytes(b).into()),
            4 => each(data, |b| u16::from_le_bytes(b).into()),
            5 => each(data, |b| i32::from_le_bytes(b).into()),
            6 => each(data, |b| u32::from_le_bytes(b).into()),
            7 => each(data, |b| f32::from_le_bytes(b).into()),
            9 => each(data, f64::from_le_bytes),
            12 => each(data, |b| i64::from_le_bytes(b) as f64),
            13 => each(data, |b| u64::from_le_bytes(b) as f64),
            _ => None,
        }
    }

    fn text(&self) -> String {
        let is_text = matches!(self.kind, 1 | 2 | MI_UTF8);
        let text = if is_text { self.data } else { &[] };
        String::from_utf8_lossy(text).trim_end_matches('\0').into()
    }
}

/// The numeric vectors of a struct. `None` if it is damaged.
fn fields(mut rest: &[u8]) -> Option<Vec<Column>> {
    let length = *Element::next(&mut rest)?.numbers()?.first()? as usize;
    let names = Element::next(&mut rest)?.data;
    let mut columns = Vec::new();
    for name in names.chunks(length.max(1)) {
        let name = String::from_utf8_lossy(name)
            .trim_end_matches('\0')
            .to_owned();
        match Element::next(&mut rest)?.value(Some(name))? {
            (_, Value::Numbers(found)) => columns.extend(found),
            // As Simulink nests the values in the signals of a structure with time.
            (name, Value::Struct(inside)) => {
                let inside = inside.into_iter();
                columns.extend(inside.map(|(field, column)| (format!("{name}.{field}"), column)));
            }
            _ => {}
        }
    }
    Some(columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What `scipy.io.savemat("x.mat", {"time_s": [0.0, 0.5], "angle_deg": np.array([1, -2],
    /// np.int16), "title": "x"}, do_compression=True)` of scipy 1.17 writes, and the same without
    /// compression.
    const COMPRESSED: &[u8] = include_bytes!("tests/compressed.mat");
    const PLAIN: &[u8] = include_bytes!("tests/plain.mat");

    #[test]
    fn the_vectors_beside_each_other_are_the_columns() {
        let expected = [
            ("time_s".to_owned(), vec![0.0, 0.5]),
            ("angle_deg".to_owned(), vec![1.0, -2.0]),
        ];
        for file in [COMPRESSED, PLAIN] {
            assert_eq!(groups(file), Ok(vec![(String::new(), expected.to_vec())]));
        }
    }

    #[test]
    fn other_versions_and_other_files_are_named() {
        for (bytes, expected) in [
            (
                b"time_s,angle_deg\n".as_slice(),
                "expected a MAT file of level 5",
            ),
            (&PLAIN[..PLAIN.len() - 20], "cut off"),
        ] {
            let problem = groups(bytes).expect_err("not a MAT file of level 5");
            assert!(problem.contains(expected), "{problem}");
        }
    }

    proptest! {
        #[test]
        fn a_damaged_file_is_refused_or_read_without_a_panic(
            at in 0..PLAIN.len(), to in any::<u8>(), cut in 0..PLAIN.len(),
        ) {
            for file in [PLAIN, COMPRESSED] {
                let mut bytes = file.to_vec();
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = to;
                }
                let _ = groups(&bytes);
                let _ = groups(&bytes[..cut.min(bytes.len())]);
            }
        }
    }
}
