//! Counts and rates of the frames on the bus.

use std::collections::{BTreeMap, VecDeque};

use canopen::{CanFrame, cob_id};
use host_sim::can::bus_load::frame_bits;
use serde_json::{Value, json};

use super::decode::Decoded;

/// Frames of services other than PDOs and heartbeats that are kept.
const TRACE: usize = 200;

/// Identifiers that are counted one by one; 11 bits give no more.
const IDENTIFIERS: usize = 1 << 11;

/// Frames of one identifier.
#[derive(Debug, Default)]
struct Stream {
    count: u64,
    count_before: u64,
    rate_hz: f64,
    data: Vec<u8>,
    decoded: Option<Decoded>,
    /// The content was displayed: the next frame is decoded.
    is_displayed: bool,
    last_s: f64,
}

/// Time after which an identifier without frames is no longer displayed, s.
const FORGOTTEN_S: f64 = 10.0;

/// The frames of the bus.
#[derive(Debug, Default)]
pub struct Statistics {
    streams: BTreeMap<(u32, bool), Stream>,
    /// Bits since the last update: without stuff bits, and with the most.
    bits: (u64, u64),
    load: (f64, f64),
    frames: u64,
    trace: VecDeque<Value>,
    /// Number of frames that were added to the trace.
    traced: u64,
}

fn hex(data: &[u8]) -> String {
    let bytes: Vec<_> = data.iter().map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

impl Statistics {
    /// A frame on the bus.
    pub fn count(&mut self, frame: &CanFrame, time_s: f64, decode: impl FnOnce() -> Decoded) {
        use embedded_can::Frame as _;
        let (least, most) = frame_bits(frame.dlc() as u32);
        self.bits.0 += u64::from(least);
        self.bits.1 += u64::from(most);
        self.frames += 1;
        let key = frame.raw_id();
        if !self.streams.contains_key(&key) && self.streams.len() >= IDENTIFIERS {
            return;
        }
        let stream = self.streams.entry(key).or_default();
        stream.count += 1;
        stream.last_s = time_s;
        let is_periodic = {
            let function = cob_id::split(key.0).0;
            (cob_id::tpdo(1)..=cob_id::rpdo(4)).contains(&function) || function == cob_id::HEARTBEAT
        };
        // The content of a periodic frame is decoded only as often as it is displayed.
        if is_periodic && stream.decoded.is_some() && !stream.is_displayed {
            return;
        }
        stream.is_displayed = false;
        stream.data = frame.data().to_vec();
        let decoded = decode();
        if !is_periodic {
            if self.trace.len() == TRACE {
                self.trace.pop_front();
            }
            self.traced += 1;
            self.trace.push_back(json!({
                "t": time_s, "id": format!("{:03X}", key.0), "service": decoded.service,
                "node": decoded.node, "content": decoded.content, "data": hex(frame.data()),
            }));
        }
        stream.decoded = Some(decoded);
    }

    /// Computes rates and load over the time since the last call.
    pub fn update(&mut self, elapsed_s: f64, bit_rate: f64) {
        for stream in self.streams.values_mut() {
            stream.rate_hz = (stream.count - stream.count_before) as f64 / elapsed_s;
            stream.count_before = stream.count;
        }
        let (least, most) = std::mem::take(&mut self.bits);
        let share = |bits: u64| bits as f64 / elapsed_s / bit_rate;
        self.load = (share(least), share(most));
    }

    /// Everything for the display, `now_s` after the start; of the trace the frames after the
    /// `known` first ones. The next frame of each identifier is decoded again.
    pub fn snapshot(&mut self, known: u64, now_s: f64) -> Value {
        let streams: Vec<_> = self
            .streams
            .iter_mut()
            .filter(|(_, stream)| now_s - stream.last_s < FORGOTTEN_S)
            .map(|((id, _), stream)| {
                stream.is_displayed = true;
                let decoded = stream.decoded.as_ref();
                let of = |text: fn(&Decoded) -> Value| decoded.map(text);
                json!({
                    "id": format!("{id:03X}"), "count": stream.count, "rate_hz": stream.rate_hz,
                    "data": hex(&stream.data),
                    "service": of(|d| d.service.into()), "node": of(|d| d.node.into()),
                    "content": of(|d| d.content.clone().into()),
                })
            })
            .collect();
        let new = (self.traced - known.min(self.traced)).min(self.trace.len() as u64) as usize;
        let trace: Vec<_> = self.trace.iter().skip(self.trace.len() - new).collect();
        json!({
            "event": "bus", "load_least": self.load.0, "load_most": self.load.1,
            "frames": self.frames, "streams": streams, "trace": trace,
        })
    }

    /// Number of frames that were added to the trace.
    pub fn traced(&self) -> u64 {
        self.traced
    }
}
