//! Reads Apache Parquet. Items of a list are columns as `action[0]`.

#[cfg(feature = "parquet")]
pub use self::reader::read;

use super::{ImportError, Table};

/// The error of a program without this format.
#[cfg(not(feature = "parquet"))]
pub fn read(_: Vec<u8>, table: Table) -> Result<Table, ImportError> {
    Err(table.problem(1, super::not_built("a Parquet file")))
}

#[cfg(feature = "parquet")]
mod reader {
    use parquet::{
        errors::ParquetError,
        file::reader::{FileReader, SerializedFileReader},
        record::Field,
    };

    use super::{ImportError, Table};

    /// Reads the file.
    pub fn read(bytes: Vec<u8>, mut table: Table) -> Result<Table, ImportError> {
        let filled = fill(bytes, &mut table);
        filled.map_err(|error| {
            table.problem(1, format!("a Parquet file that cannot be read: {error}"))
        })?;
        Ok(table)
    }

    fn fill(bytes: Vec<u8>, table: &mut Table) -> Result<(), ParquetError> {
        let file = SerializedFileReader::new(bytes::Bytes::from(bytes))?;
        for (line, row) in (1..).zip(file.get_row_iter(None)?) {
            let mut values = Vec::new();
            for (name, field) in row?.into_columns() {
                flatten(name, &field, &mut values);
            }
            table.push(line, values);
        }
        Ok(())
    }

    fn flatten(name: String, field: &Field, row: &mut Vec<(String, f64)>) {
        match field {
            Field::ListInternal(list) => {
                for (index, item) in list.elements().iter().enumerate() {
                    flatten(format!("{name}[{index}]"), item, row);
                }
            }
            Field::Group(members) => {
                for (member, field) in members.get_column_iter() {
                    flatten(format!("{name}.{member}"), field, row);
                }
            }
            field => row.push((name, number(field))),
        }
    }

    /// The number of a field, NaN where it is missing, and infinite for other types.
    fn number(field: &Field) -> f64 {
        match field {
            Field::Null => f64::NAN,
            Field::Bool(value) => f64::from(u8::from(*value)),
            Field::Byte(value) => f64::from(*value),
            Field::Short(value) => f64::from(*value),
            Field::Int(value) => f64::from(*value),
            Field::Long(value) => *value as f64,
            Field::UByte(value) => f64::from(*value),
            Field::UShort(value) => f64::from(*value),
            Field::UInt(value) => f64::from(*value),
            Field::ULong(value) => *value as f64,
            Field::Float16(value) => f64::from(f32::from(*value)),
            Field::Float(value) => f64::from(*value),
            Field::Double(value) => *value,
            Field::TimestampMillis(value) => *value as f64 * 1e-3,
            Field::TimestampMicros(value) => *value as f64 * 1e-6,
            _ => f64::INFINITY,
        }
    }
}
