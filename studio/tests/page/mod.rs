//! A page without a browser.
#![allow(dead_code, reason = "each test uses a part of it")]

use std::collections::BTreeMap;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, client::IntoClientRequest as _};

/// Time for anything, on a loaded computer.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// A page without a browser.
pub struct Page {
    socket: WebSocket<TcpStream>,
    next: u64,
    /// Whether it answers.
    pub is_alive: bool,
    pub nodes: Value,
    pub control: Value,
    pub number: Value,
    /// The last task that has ended.
    pub ended_task: Option<u64>,
    /// The messages with samples.
    pub rows: u64,
    /// The quantities of a sample, by their keys.
    quantities: Vec<String>,
    /// For each node the number of its samples, and the last one.
    pub samples: BTreeMap<u8, (u64, Vec<f32>)>,
}

impl Page {
    pub fn at(url: &str) -> Self {
        let address = url.trim_start_matches("http://");
        let (host, rest) = address.split_once('/').expect("a path");
        let token = rest.trim_start_matches("?token=");
        let mut request = format!("ws://{host}/socket?token={token}")
            .into_client_request()
            .expect("an address");
        let origin = format!("http://{host}").parse().expect("a value");
        request.headers_mut().insert("Origin", origin);
        let stream = TcpStream::connect(host).expect("a connection");
        stream
            .set_read_timeout(Some(Duration::from_millis(200)))
            .expect("a timeout");
        let socket = tungstenite::client(request, stream)
            .expect("it is accepted")
            .0;
        let mut page = Self {
            socket,
            next: 0,
            is_alive: true,
            nodes: json!([]),
            control: json!(null),
            number: json!(null),
            ended_task: None,
            rows: 0,
            quantities: Vec::new(),
            samples: BTreeMap::new(),
        };
        page.until("hello", |page| page.number.is_u64());
        page
    }

    /// Takes a message, if one comes; returns it if it is an answer.
    pub fn take(&mut self) -> Option<Value> {
        match self.socket.read() {
            Ok(Message::Text(text)) => {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                match message["event"].as_str() {
                    Some("tick") if self.is_alive => self.send(&json!({ "do": "alive" })),
                    Some("hello") => {
                        self.number = message["page"].clone();
                        let keys = message["quantities"].as_array().expect("a list");
                        let keys = keys.iter().filter_map(|quantity| quantity["key"].as_str());
                        self.quantities = keys.map(str::to_owned).collect();
                    }
                    Some("devices") => self.nodes = message["nodes"].clone(),
                    Some("progress") if message["ended"] == true => {
                        self.ended_task = message["task"].as_u64();
                    }
                    Some("control") => self.control = message["holder"].clone(),
                    Some(_) => {}
                    None => return Some(message),
                }
            }
            Ok(Message::Binary(bytes)) => {
                self.rows += 1;
                self.take_samples(&bytes);
            }
            _ => {}
        }
        None
    }

    pub fn send(&mut self, message: &Value) {
        let text = message.to_string();
        self.socket.send(Message::text(text)).expect("it is open");
    }

    pub fn until(&mut self, what: &str, is_met: impl Fn(&Self) -> bool) {
        let end = Instant::now() + PATIENCE;
        while !is_met(self) {
            assert!(
                Instant::now() < end,
                "waited without success for {what}: {}",
                self.nodes
            );
            self.take();
        }
    }

    /// The answer to a request.
    pub fn ask(&mut self, what: &str, mut arguments: Value) -> Result<Value, String> {
        self.next += 1;
        arguments["id"] = self.next.into();
        arguments["do"] = what.into();
        self.send(&arguments);
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "no answer to {what}");
            let Some(answer) = self.take().filter(|answer| answer["id"] == self.next) else {
                continue;
            };
            return match answer["error"].as_str() {
                Some(error) => Err(error.to_owned()),
                None => Ok(answer["ok"].clone()),
            };
        }
    }

    fn take_samples(&mut self, mut bytes: &[u8]) {
        if self.quantities.is_empty() {
            // They may come before the server has said what they are.
            return;
        }
        while let [node, _, low, high, _, _, _, _, rest @ ..] = bytes {
            let (count, values) = self.samples.entry(*node).or_default();
            let rows = usize::from(u16::from_le_bytes([*low, *high]));
            let length = 8 + 4 * self.quantities.len();
            for row in rest[..rows * length].chunks(length) {
                let value = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("4"));
                *values = row[8..].chunks(4).map(value).collect();
                *count += 1;
            }
            bytes = &rest[rows * length..];
        }
    }

    /// The last value of a quantity of a node; NaN before the first sample.
    pub fn last(&self, node: u8, key: &str) -> f32 {
        let place = self.quantities.iter().position(|known| known == key);
        let values = self.samples.get(&node).zip(place);
        values.map_or(f32::NAN, |((_, values), place)| values[place])
    }
}
