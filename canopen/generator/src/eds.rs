//! The electronic data sheet (CiA 306-1).

use std::fmt::Write;

use crate::row::{Access, DataType, Default, Row};

/// The sections of an EDS that describe the device and not its objects.
#[derive(Clone, Debug)]
pub struct Device {
    /// Name of the file.
    pub file: String,
    /// Description.
    pub description: String,
    /// Vendor's name.
    pub vendor: String,
    /// Product's name.
    pub product: String,
    /// Bit rates in kbit/s.
    pub bit_rates: Vec<u16>,
}

const VARIABLE: u8 = 7;
const ARRAY: u8 = 8;
const RECORD: u8 = 9;
const DOMAIN: u8 = 2;

/// The EDS.
#[must_use]
pub fn eds(device: &Device, rows: &[Row]) -> String {
    let mut out = format!("; {}\n", crate::HEAD);
    general(&mut out, device, rows);
    let mandatory = |index: u16| matches!(index, 0x1000 | 0x1001 | 0x1018);
    let manufacturer = |index: u16| (0x2000..0x6000).contains(&index);
    list(&mut out, "MandatoryObjects", rows, mandatory);
    list(&mut out, "OptionalObjects", rows, |index| {
        !mandatory(index) && !manufacturer(index)
    });
    list(&mut out, "ManufacturerObjects", rows, manufacturer);
    for object in crate::objects(rows) {
        describe(&mut out, object);
    }
    out
}

fn section(out: &mut String, name: &str, pairs: &[(&str, String)]) {
    write!(out, "\n[{name}]\n").expect("a string takes all");
    for (key, value) in pairs {
        writeln!(out, "{key}={value}").expect("a string");
    }
}

fn general(out: &mut String, device: &Device, rows: &[Row]) {
    let text = |text: &str| text.to_string();
    let value = |index, sub| {
        let row = rows
            .iter()
            .find(|row| (row.index, row.sub_index()) == (index, sub));
        match row.map(|row| &row.default) {
            Some(Default::Integer(value, _)) => format!("0x{value:08X}"),
            _ => text("0x00000000"),
        }
    };
    section(
        out,
        "FileInfo",
        &[
            ("FileName", device.file.clone()),
            ("FileVersion", text("1")),
            ("FileRevision", text("1")),
            ("EDSVersion", text("4.0")),
            ("Description", device.description.clone()),
            ("CreationTime", text("12:00AM")),
            ("CreationDate", text("01-01-2026")),
            ("CreatedBy", device.vendor.clone()),
            ("ModificationTime", text("12:00AM")),
            ("ModificationDate", text("01-01-2026")),
            ("ModifiedBy", device.vendor.clone()),
        ],
    );
    let flag = |on: bool| text(if on { "1" } else { "0" });
    let count = |low, high| {
        crate::objects(rows)
            .filter(|rows| (low..=high).contains(&rows[0].index))
            .count()
    };
    let rates = [10, 20, 50, 125, 250, 500, 800, 1000];
    let names = rates.map(|rate| format!("BaudRate_{rate}"));
    let mut pairs = vec![
        ("VendorName", device.vendor.clone()),
        ("VendorNumber", value(0x1018, 1)),
        ("ProductName", device.product.clone()),
        ("ProductNumber", value(0x1018, 2)),
        ("RevisionNumber", value(0x1018, 3)),
        ("OrderCode", device.product.clone()),
    ];
    for (rate, name) in rates.into_iter().zip(&names) {
        pairs.push((name, flag(device.bit_rates.contains(&rate))));
    }
    pairs.extend([
        ("SimpleBootUpMaster", flag(false)),
        ("SimpleBootUpSlave", flag(true)),
        ("Granularity", text("8")),
        ("DynamicChannelsSupported", text("0")),
        ("GroupMessaging", flag(false)),
        ("NrOfRXPDO", count(0x1400, 0x15FF).to_string()),
        ("NrOfTXPDO", count(0x1800, 0x19FF).to_string()),
        ("LSS_Supported", flag(true)),
    ]);
    section(out, "DeviceInfo", &pairs);
    let dummies: Vec<_> = (1..=7).map(|dummy| format!("Dummy{dummy:04}")).collect();
    let pairs: Vec<_> = dummies
        .iter()
        .zip(1..)
        .map(|(name, at)| (name.as_str(), flag(at > 1)))
        .collect();
    section(out, "DummyUsage", &pairs);
    section(
        out,
        "Comments",
        &[("Lines", text("1")), ("Line1", device.description.clone())],
    );
}

fn list(out: &mut String, name: &str, rows: &[Row], belongs: impl Fn(u16) -> bool) {
    let objects: Vec<_> = crate::objects(rows)
        .map(|rows| rows[0].index)
        .filter(|index| belongs(*index))
        .collect();
    write!(out, "\n[{name}]\nSupportedObjects={}\n", objects.len()).expect("a string");
    for (number, index) in (1..).zip(objects) {
        writeln!(out, "{number}=0x{index:04X}").expect("a string");
    }
}

fn describe(out: &mut String, object: &[Row]) {
    let first = &object[0];
    if first.sub.is_none() {
        return variable(out, &format!("{:04X}", first.index), &first.object, first);
    }
    let pairs = [
        ("ParameterName", first.object.clone()),
        ("ObjectType", format!("0x{:X}", object_type(object))),
        ("SubNumber", object.len().to_string()),
    ];
    section(out, &format!("{:04X}", first.index), &pairs);
    for row in object {
        variable(
            out,
            &format!("{:04X}sub{:X}", row.index, row.sub_index()),
            &row.entry,
            row,
        );
    }
}

/// An ARRAY if all elements have one type; PDO parameters and identity are RECORDs by the standard.
fn object_type(object: &[Row]) -> u8 {
    let record = matches!(object[0].index, 0x1018 | 0x1200..=0x1BFF);
    let mut kinds = object
        .iter()
        .filter(|row| row.sub != Some(0))
        .map(|row| row.kind);
    let first = kinds.next();
    if record || kinds.any(|kind| Some(kind) != first) {
        RECORD
    } else {
        ARRAY
    }
}

fn variable(out: &mut String, name: &str, title: &str, row: &Row) {
    let object_type = if row.kind == DataType::Domain {
        DOMAIN
    } else {
        VARIABLE
    };
    let mut pairs = vec![
        ("ParameterName", title.to_string()),
        ("ObjectType", format!("0x{object_type:X}")),
        ("DataType", format!("0x{:04X}", row.kind.number())),
        ("AccessType", row.access.name().to_string()),
    ];
    // Importers disagree on the format of a REAL32: it gets no default.
    match &row.default {
        Default::Integer(_, text) | Default::Text(text) => {
            pairs.push(("DefaultValue", text.clone()));
        }
        Default::NodeId(value) => pairs.push(("DefaultValue", format!("$NODEID+0x{value:X}"))),
        Default::None | Default::Real(_) => {}
    }
    // CiA 306 has no such keyword for a DOMAIN, and node-canopen refuses an EDS that has it.
    if row.kind != DataType::Domain {
        pairs.push(("PDOMapping", u8::from(row.mappable).to_string()));
    }
    if let Some((low, high)) = row.limits.as_ref().filter(|_| row.kind != DataType::F32) {
        pairs.push(("LowLimit", low.clone()));
        pairs.push(("HighLimit", high.clone()));
    }
    section(out, name, &pairs);
    debug_assert!(!(row.access == Access::Const && row.mappable && row.kind == DataType::Domain));
}
