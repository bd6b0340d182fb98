//! Requests to the node and their responses.

use crate::application::{Application, Level, Opcode, Parameter, Status, Target, Telemetry, Value};
use crate::{Payload, Reader};

/// A status at this time since the start.
pub(crate) fn put_status(payload: &mut Payload, status: Status, uptime_s: u32) {
    payload
        .unsigned(uptime_s.into(), 32)
        .unsigned(status.health as u64, 2)
        .unsigned(status.mode as u64, 3)
        .unsigned(0, 3)
        .unsigned(status.code.into(), 16);
}

/// The response to `GetNodeInfo`.
pub(crate) fn node_info(app: &impl Application, uptime_s: u32) -> Payload {
    let (identity, mut payload) = (app.identity(), Payload::new());
    put_status(&mut payload, app.status(), uptime_s);
    let [(major, minor), (board, revision)] = [identity.software, identity.hardware];
    payload
        .put(&[major, minor, 0])
        // Neither a commit nor a CRC of the image.
        .unsigned(0, 32)
        .unsigned(0, 64)
        .put(&[board, revision])
        .put(&app.unique_id())
        // No certificate.
        .put(&[0])
        .put(identity.name.as_bytes());
    payload
}

/// Calls `each` for each command of an `ArrayCommand`.
pub(crate) fn commands(payload: &[u8], mut each: impl FnMut(u8, Target)) {
    for command in payload.chunks_exact(4) {
        let mut reader = Reader::new(command);
        let (actuator_id, kind) = (reader.unsigned(8) as u8, reader.unsigned(8) as u8);
        if let Some(target) = Target::new(kind, reader.float16()) {
            each(actuator_id, target);
        }
    }
}

/// Answers `GetSet`; `None` if the request is malformed.
pub(crate) fn get_set(app: &mut impl Application, request: &[u8]) -> Option<Payload> {
    let mut reader = Reader::new(request);
    let index = reader.unsigned(13) as u16;
    let value = match reader.unsigned(3) {
        1 => Some(Value::Integer(reader.signed(64))),
        2 => Some(Value::Real(reader.float32())),
        3 => Some(Value::Integer((reader.unsigned(8) != 0).into())),
        4 => {
            let length = reader.unsigned(8) as usize;
            reader.skip(length);
            None
        }
        _ => None,
    };
    if !reader.is_complete() {
        return None;
    }
    let name = reader.rest();
    let index = if name.is_empty() {
        Some(index)
    } else {
        app.find(name)
    };
    if let (Some(index), Some(value)) = (index, value) {
        app.set(index, value);
    }
    let parameter = index.and_then(|index| app.parameter(index));
    Some(parameter.map_or_else(empty, |parameter| describe(&parameter)))
}

/// The response for a parameter that does not exist.
fn empty() -> Payload {
    let mut payload = Payload::new();
    payload.unsigned(0, 32);
    payload
}

fn describe(parameter: &Parameter) -> Payload {
    let mut payload = Payload::new();
    let (least, greatest) = parameter.range.unzip();
    put_value(&mut payload, Some(parameter.value));
    put_value(&mut payload, Some(parameter.default));
    put_value(&mut payload, greatest);
    put_value(&mut payload, least);
    payload.put(parameter.name.as_bytes());
    payload
}

/// The number of the present alternative, which unused bits extend to a byte, and its content.
fn put_value(payload: &mut Payload, value: Option<Value>) {
    match value {
        None => payload.put(&[0]),
        Some(Value::Integer(integer)) => payload.put(&[1]).unsigned(integer as u64, 64),
        Some(Value::Real(real)) => payload.put(&[2]).unsigned(real.to_bits().into(), 32),
    };
}

/// The operation of an `ExecuteOpcode` request; `None` for an unknown one.
pub(crate) fn opcode(request: &[u8]) -> Option<Opcode> {
    match request.first() {
        Some(0) => Some(Opcode::Save),
        Some(1) => Some(Opcode::Erase),
        _ => None,
    }
}

/// The response to `ExecuteOpcode`.
pub(crate) fn executed(is_done: bool) -> Payload {
    let mut payload = Payload::new();
    payload.unsigned(0, 48).unsigned(is_done.into(), 1);
    payload
}

/// Whether a `RestartNode` request has its magic number.
pub(crate) fn is_restart(request: &[u8]) -> bool {
    Reader::new(request).unsigned(40) == 0xAC_CE55_1B1E
}

/// The response to `RestartNode`.
pub(crate) fn restarted(is_accepted: bool) -> Payload {
    let mut payload = Payload::new();
    payload.unsigned(is_accepted.into(), 1);
    payload
}

/// The response to `BeginFirmwareUpdate`: the number of an error and its reason, or none.
pub(crate) fn update_begun(refused: Option<(u8, &str)>) -> Payload {
    let mut payload = Payload::new();
    let (error, reason) = refused.unwrap_or_default();
    payload.put(&[error]).put(reason.as_bytes());
    payload
}

/// An `actuator.Status`.
pub(crate) fn actuator_status(telemetry: &Telemetry) -> Payload {
    let mut payload = Payload::new();
    payload
        .put(&[telemetry.actuator_id])
        .float16(telemetry.position_rad)
        .float16(telemetry.torque_nm)
        .float16(telemetry.rate_rad_s)
        // 127 means an unknown load.
        .unsigned(telemetry.load_pct.min(126).into(), 8);
    payload
}

/// A `CircuitStatus`.
pub(crate) fn circuit_status(telemetry: &Telemetry) -> Payload {
    let mut payload = Payload::new();
    payload
        .unsigned(telemetry.actuator_id.into(), 16)
        .float16(telemetry.supply_v)
        .float16(telemetry.current_a)
        .put(&[telemetry.circuit_errors]);
    payload
}

/// A `device.Temperature`.
pub(crate) fn temperature(telemetry: &Telemetry) -> Payload {
    let mut payload = Payload::new();
    payload
        .unsigned(telemetry.actuator_id.into(), 16)
        .float16(telemetry.temperature_k)
        .put(&[telemetry.is_overheated.into()]);
    payload
}

/// A `LogMessage` of the actuator.
pub(crate) fn log(level: Level, text: &[u8]) -> Payload {
    const SOURCE: &[u8] = b"actuator";
    let mut payload = Payload::new();
    payload
        .unsigned(level as u64, 3)
        .unsigned(SOURCE.len() as u64, 5)
        .put(SOURCE)
        .put(text);
    payload
}
