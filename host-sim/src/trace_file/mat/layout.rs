//! The elements of a MAT file, with space for the columns.

use std::io::{self, Seek, SeekFrom, Write};

// Table "MAT-File Data Types".
const MI_INT8: u32 = 1;
const MI_UINT16: u32 = 4;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;

// Table "MATLAB Array Types (Classes)".
const MX_STRUCT: u32 = 2;
const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;

/// The content of a variable or of a field of a struct.
pub enum Value<'a> {
    /// A column vector of this many numbers, which are written later.
    Column(u64),
    /// A number.
    Number(f64),
    /// A row of characters.
    Text(&'a str),
    /// A struct with these fields.
    Struct(Vec<(&'a str, Value<'a>)>),
}

/// Writes the header of a file and one variable; returns `out` and the positions of the columns.
pub fn write<W: Write + Seek>(out: W, name: &str, value: &Value<'_>) -> io::Result<(W, Vec<u64>)> {
    let places = Vec::new();
    let mut layout = Layout { out, places };
    layout.header()?;
    layout.matrix(name, value)?;
    Ok((layout.out, layout.places))
}

struct Layout<W> {
    out: W,
    places: Vec<u64>,
}

impl<W: Write + Seek> Layout<W> {
    fn header(&mut self) -> io::Result<()> {
        let text = "MATLAB 5.0 MAT-file, written by actuator";
        write!(self.out, "{text:116}")?;
        // No data of subsystems, version 1.0, and `MI` as this byte order writes it.
        self.out.write_all(b"\0\0\0\0\0\0\0\0\x00\x01IM")
    }

    fn matrix(&mut self, name: &str, value: &Value<'_>) -> io::Result<()> {
        self.tag(MI_MATRIX, 0)?;
        let start = self.out.stream_position()?;
        match value {
            Value::Column(rows) => {
                self.array(MX_DOUBLE, [*rows, 1], name)?;
                self.gap(8 * rows)?;
            }
            Value::Number(number) => {
                self.array(MX_DOUBLE, [1, 1], name)?;
                self.data(MI_DOUBLE, &number.to_le_bytes())?;
            }
            Value::Text(text) => {
                let bytes: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
                self.array(MX_CHAR, [1, bytes.len() as u64 / 2], name)?;
                self.data(MI_UINT16, &bytes)?;
            }
            Value::Struct(fields) => {
                self.array(MX_STRUCT, [1, 1], name)?;
                self.fields(fields)?;
            }
        }
        // The length is known now.
        let end = self.out.stream_position()?;
        self.out.seek(SeekFrom::Start(start - 4))?;
        self.out.write_all(&length(end - start)?)?;
        self.out.seek(SeekFrom::Start(end))?;
        Ok(())
    }

    /// The start of every array: flags, dimensions and name.
    fn array(&mut self, class: u32, dimensions: [u64; 2], name: &str) -> io::Result<()> {
        let mut flags = [0; 8];
        flags[..4].copy_from_slice(&class.to_le_bytes());
        self.data(MI_UINT32, &flags)?;
        let [rows, columns] = dimensions.map(length);
        self.data(MI_INT32, &[rows?, columns?].concat())?;
        self.data(MI_INT8, name.as_bytes())
    }

    fn fields(&mut self, fields: &[(&str, Value<'_>)]) -> io::Result<()> {
        // MATLAB before 7.6 limits names to 31 characters and a zero.
        let is_long = fields.iter().any(|(name, _)| name.len() > 31);
        let room: u32 = if is_long { 64 } else { 32 };
        // This one is always a small data element: size and type share four bytes.
        self.out.write_all(&(4 << 16 | MI_INT32).to_le_bytes())?;
        self.out.write_all(&room.to_le_bytes())?;
        let mut names = vec![0; fields.len() * room as usize];
        for (place, (name, _)) in names.chunks_exact_mut(room as usize).zip(fields) {
            let name = &name.as_bytes()[..name.len().min(room as usize - 1)];
            place[..name.len()].copy_from_slice(name);
        }
        self.data(MI_INT8, &names)?;
        for (_, value) in fields {
            self.matrix("", value)?;
        }
        Ok(())
    }

    fn data(&mut self, kind: u32, bytes: &[u8]) -> io::Result<()> {
        self.tag(kind, bytes.len() as u64)?;
        self.out.write_all(bytes)?;
        // The next element starts at a multiple of eight bytes.
        let padding = bytes.len().next_multiple_of(8) - bytes.len();
        self.out.write_all(&[0; 8][..padding])
    }

    fn gap(&mut self, bytes: u64) -> io::Result<()> {
        self.tag(MI_DOUBLE, bytes)?;
        let place = self.out.stream_position()?;
        self.places.push(place);
        self.out.seek(SeekFrom::Start(place + bytes))?;
        Ok(())
    }

    fn tag(&mut self, kind: u32, bytes: u64) -> io::Result<()> {
        self.out.write_all(&kind.to_le_bytes())?;
        self.out.write_all(&length(bytes)?)
    }
}

fn length(bytes: u64) -> io::Result<[u8; 4]> {
    let bytes = u32::try_from(bytes).map_err(io::Error::other)?;
    Ok(bytes.to_le_bytes())
}
