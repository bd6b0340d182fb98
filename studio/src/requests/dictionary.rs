//! What a page needs once: objects, faults, quantities and excitations, from the sources of the
//! firmware.

use canopen_generator::{Access, DataType, Default as DefaultValue, Flag, Row};
use firmware::faults::{Fault, FaultSet, TABLE};
use firmware::parameters::BoardParameters;
use host_sim::can::excitation::{REPETITIONS, SHAPES};
use host_sim::can::names;
use serde_json::{Value, json};

use super::objects::address;
use crate::bus::decode::nmt_command;
use crate::core::{Core, State};
use crate::quantity;
use crate::record::MINUTES;
use crate::web::PageId;

fn access(row: &Row) -> &'static str {
    match row.access {
        Access::Const => "const",
        Access::Ro => "ro",
        Access::Wo => "wo",
        Access::Rw | Access::Rww => "rw",
    }
}

fn kind(row: &Row) -> &'static str {
    match row.kind {
        DataType::F32 => "real",
        DataType::Text => "text",
        DataType::Domain => "domain",
        _ => "integer",
    }
}

/// The default value; of one that depends on the node-ID its summand.
fn default(row: &Row) -> Value {
    match &row.default {
        DefaultValue::None => json!(null),
        DefaultValue::Integer(value, _) => json!(*value as i64),
        DefaultValue::NodeId(base) => json!({ "node_id_plus": base }),
        DefaultValue::Real(value) => json!(value),
        DefaultValue::Text(text) => json!(text),
    }
}

fn part(index: u16) -> &'static str {
    match index {
        0..0x2000 => "Communication",
        0x2000..0x6000 => "Actuator",
        _ => "Drive profile",
    }
}

/// The range of an integer type; `None` for other types and those of 64 bits, which a page's
/// numbers do not hold.
fn limits_of(kind: DataType) -> Option<(String, String)> {
    let (size, is_signed) = names::layout(kind).filter(|(size, _)| *size < 8)?;
    let bits = 8 * size as u32 - u32::from(is_signed);
    let greatest = (1_i64 << bits) - 1;
    let least = if is_signed { -greatest - 1 } else { 0 };
    Some((least.to_string(), greatest.to_string()))
}

fn object(row: &Row) -> Value {
    let (low, high) = row.limits.clone().or_else(|| limits_of(row.kind)).unzip();
    json!({
        "address": address(row), "name": names::name(row), "object": row.object,
        "entry": row.entry, "index": row.index, "sub": row.sub, "part": part(row.index),
        "kind": kind(row), "access": access(row), "default": default(row),
        "min": low, "max": high, "unit": row.unit, "meaning": row.meaning, "source": row.source,
        "is_locked": row.flag == Flag::Locked, "is_stored": is_stored(row),
    })
}

/// Whether 1010h stores it.
fn is_stored(row: &Row) -> bool {
    let is_communication = row.index < 0x2000 && access(row) == "rw";
    let is_value = row.value.as_ref().is_some_and(|value| {
        use canopen_generator::StorageLocation::{Control, Parameters, Values};
        matches!(value.location, Control | Parameters | Values)
    });
    is_value || (is_communication && !matches!(row.index, 0x1003 | 0x1010 | 0x1011))
}

/// The reaction as docs/faults.md has it.
fn reaction(fault: Fault, parameters: &BoardParameters) -> String {
    let brakes = FaultSet::of_bits(parameters.stop.brake_faults.cast_unsigned());
    let end = if brakes.contains(fault) {
        "brake"
    } else {
        "coast"
    };
    let before = fault.reaction().words();
    before.map_or_else(|| end.to_owned(), |before| format!("{before}, {end}"))
}

fn faults() -> Vec<Value> {
    let parameters = BoardParameters::DEFAULT;
    TABLE
        .iter()
        .map(|row| {
            let fault = row.fault;
            json!({
                "number": fault.number(), "name": row.name, "condition": row.condition,
                "watched": row.watched.words(), "reaction": reaction(fault, &parameters),
                "code": format!("{:04X}h", row.error_code),
                "detected_ms": fault.detected_ms(&parameters), "safe_ms": fault.safe_ms(&parameters),
                "remedy": fault.remedy(),
            })
        })
        .collect()
}

/// The first message to a page.
pub fn hello(page: PageId, core: &Core, state: &State, bus: &str) -> Value {
    let objects: Vec<_> = names::rows().iter().map(object).collect();
    let commands = [1, 128, 2, 130, 129].map(nmt_command);
    json!({
        "event": "hello", "kind": "actuators", "page": page, "bus": bus, "now_s": core.now_s(),
        "simulated": core.encoder_switches.len(),
        "version": env!("CARGO_PKG_VERSION"), "minutes": MINUTES,
        "objects": objects, "faults": faults(), "quantities": quantity::ALL,
        "excitations": SHAPES, "repetitions": REPETITIONS,
        "commands": commands, "commission": super::commission::limits(),
        "parquet": cfg!(feature = "parquet"),
        "models": super::identify::models(), "tune": super::tuning::parameters(),
        "log": state.log,
    })
}
