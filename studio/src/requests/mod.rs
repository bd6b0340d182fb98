//! Requests of pages. A request is a JSON object with `id`, `do` and its arguments; the answer has
//! the same `id` and either `ok` or `error`.

mod commission;
mod dictionary;
mod faults;
mod files;
mod identify;
mod motion;
mod network;
mod objects;
mod response;
mod servos;
mod tuning;
mod update;

use std::collections::BTreeMap;
use std::sync::Arc;

use host_sim::can::client::Client;
use serde::{Deserialize, de::Error as _};
use serde_json::{Map, Value, json};

use crate::core::{Busy, Core, State};
use crate::web::{PageId, Pages};

/// The first message to a page: what the bus offers.
pub fn hello(page: PageId, core: &Core, state: &State, bus: &str) -> Value {
    match core.servos {
        Some(_) => servos::hello(page, core, state, bus),
        None => dictionary::hello(page, core, state, bus),
    }
}

/// The identifier of a message, 0 where it has none, and its request.
///
/// The arguments are beside `do`. An attribute `tag` would buffer them, and buffered numbers with
/// a fraction are refused where any other crate enables `arbitrary_precision` of `serde_json`.
fn parse(text: &str) -> (u64, Result<Request, serde_json::Error>) {
    let mut arguments: Map<String, Value> = match serde_json::from_str(text) {
        Ok(arguments) => arguments,
        Err(error) => return (0, Err(error)),
    };
    let id = arguments.remove("id").and_then(|id| id.as_u64());
    let request = if arguments.values().all(has_finite_numbers) {
        request(arguments)
    } else {
        Err(serde_json::Error::custom("number out of range"))
    };
    (id.unwrap_or(0), request)
}

/// Whether each number is one: `1e999` is infinite where any other crate enables
/// `arbitrary_precision` of `serde_json`, and an error of the parser otherwise.
fn has_finite_numbers(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.as_f64().is_some_and(f64::is_finite),
        Value::Array(values) => values.iter().all(has_finite_numbers),
        Value::Object(values) => values.values().all(has_finite_numbers),
        _ => true,
    }
}

fn request(mut arguments: Map<String, Value>) -> Result<Request, serde_json::Error> {
    let name: String = match arguments.remove("do") {
        Some(name) => serde_json::from_value(name)?,
        None => return Err(serde_json::Error::missing_field("do")),
    };
    if arguments.is_empty()
        && let Ok(request) = serde_json::from_value(Value::String(name.clone()))
    {
        return Ok(request);
    }
    let request = Map::from_iter([(name, Value::Object(arguments))]);
    serde_json::from_value(Value::Object(request))
}

/// Settings of 2020h by their sub-indices.
#[derive(Debug, Deserialize)]
#[serde(try_from = "BTreeMap<String, i32>")]
pub struct ExcitationValues(Vec<(u8, i32)>);

impl TryFrom<BTreeMap<String, i32>> for ExcitationValues {
    type Error = std::num::ParseIntError;

    fn try_from(texts: BTreeMap<String, i32>) -> Result<Self, Self::Error> {
        let values = texts
            .into_iter()
            .map(|(sub, value)| Ok((sub.parse()?, value)));
        Ok(Self(values.collect::<Result<_, _>>()?))
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Request {
    /// A sign of life.
    Alive,
    TakeControl,
    AnswerControl {
        give: bool,
    },
    Scan,
    Cancel {
        task: u64,
    },
    Network {
        node: u8,
        command: String,
    },
    LssFind,
    LssAssign {
        serial: u32,
        node: u8,
    },
    Stop,
    Enable {
        node: u8,
    },
    Disable {
        node: u8,
    },
    Move {
        node: u8,
        deg: f64,
    },
    Turn {
        node: u8,
        deg_s: f64,
    },
    Press {
        node: u8,
        nm: f64,
    },
    Preview {
        settings: ExcitationValues,
    },
    Excite {
        node: u8,
        settings: ExcitationValues,
    },
    Read {
        node: u8,
        objects: Vec<String>,
    },
    ReadAll {
        node: u8,
    },
    Write {
        node: u8,
        object: String,
        value: String,
    },
    Save {
        node: u8,
        group: objects::Group,
    },
    Restore {
        node: u8,
    },
    Export {
        node: u8,
        format: files::ParameterFormat,
    },
    ParseFile {
        text: String,
    },
    Faults {
        node: u8,
    },
    ResetFaults {
        node: u8,
    },
    ClearHistory {
        node: u8,
    },
    /// Begins or ends a recording that is longer than what is kept anyway.
    Record {
        nodes: Vec<u8>,
        is_on: bool,
    },
    SaveRecording(files::Recording),
    ArmCapture {
        node: u8,
        trigger: u8,
        before: u16,
        decimation: u16,
    },
    ReadCapture {
        node: u8,
    },
    Tune(tuning::TuneValues),
    Response {
        node: u8,
        from_s: f64,
        to_s: f64,
    },
    ApplyGains {
        node: u8,
        gains: tuning::Gains,
    },
    Predict(identify::Prediction),
    Identify(identify::Identification),
    TakeOver {
        node: u8,
        values: BTreeMap<String, f64>,
    },
    Commission(commission::Order),
    /// A part of the image of the next update.
    ImagePart {
        is_first: bool,
        hex: String,
    },
    Update {
        node: u8,
    },
    /// Breaks or mends the encoder of a simulated actuator.
    BreakEncoder {
        node: u8,
        is_broken: bool,
    },
}

impl Request {
    /// Whether only the page that has control may send it.
    fn needs_control(&self) -> bool {
        !matches!(
            self,
            Self::Alive
                | Self::TakeControl
                | Self::AnswerControl { .. }
                | Self::Scan
                | Self::Cancel { .. }
                | Self::Stop
                | Self::Preview { .. }
                | Self::Read { .. }
                | Self::ReadAll { .. }
                | Self::Export { .. }
                | Self::ParseFile { .. }
                | Self::Faults { .. }
                | Self::Record { .. }
                | Self::SaveRecording(_)
                | Self::ReadCapture { .. }
                | Self::Tune(_)
                | Self::Response { .. }
                | Self::Predict(_)
                | Self::Identify(_)
        )
    }
}

/// The way of an answer.
#[derive(Clone)]
pub struct Reply {
    pages: Pages,
    page: PageId,
    id: u64,
}

impl Reply {
    /// Sends the result.
    pub fn result(&self, result: Result<Value, String>) {
        let answer = match result {
            Ok(value) => json!({ "id": self.id, "ok": value }),
            Err(error) => json!({ "id": self.id, "error": error }),
        };
        self.pages.tell(self.page, &answer);
    }

    fn busy(&self, requested: Result<(), Busy>) {
        if let Err(busy) = requested {
            self.result(Err(busy.to_string()));
        }
    }
}

/// Where a request comes from, and what it acts on.
pub struct Context {
    /// The state.
    pub core: Arc<Core>,
    /// The page.
    pub page: PageId,
    /// The way of the answer.
    pub reply: Reply,
}

impl Context {
    /// Does work for a node and answers with its result.
    fn at_node<E: std::fmt::Display>(
        self,
        node: u8,
        work: impl FnOnce(&Arc<Core>, &mut Client) -> Result<Value, E> + Send + 'static,
    ) {
        let (core, reply) = (Arc::clone(&self.core), self.reply.clone());
        let requested = self.core.at_node(node, move |client| {
            reply.result(work(&core, client).map_err(|error| error.to_string()));
        });
        self.reply.busy(requested);
    }

    /// Does work that moves the shaft of a node; a stop ends it.
    fn move_at_node<E: std::fmt::Display>(
        self,
        node: u8,
        work: impl FnOnce(&Arc<Core>, &mut Client) -> Result<Value, E> + Send + 'static,
    ) {
        let (core, reply) = (Arc::clone(&self.core), self.reply.clone());
        let requested = self.core.move_at_node(node, move |client| {
            reply.result(work(&core, client).map_err(|error| error.to_string()));
        });
        self.reply.busy(requested);
    }
}

/// Handles a message of a page. One that is no request is answered as one that is refused: the page
/// stays open.
pub fn handle(core: &Arc<Core>, page: PageId, text: &str) {
    let (id, request) = parse(text);
    let reply = Reply {
        pages: core.pages.clone(),
        page,
        id,
    };
    let request = match request {
        Ok(request) => request,
        Err(error) => return reply.result(Err(format!("not a request: {error}"))),
    };
    let has_control = core.with(|state| state.control.is_held_by(page));
    if request.needs_control() && !has_control {
        return reply.result(Err("another page has the control; take it first".into()));
    }
    let context = Context {
        core: Arc::clone(core),
        page,
        reply,
    };
    if core.servos.is_some() {
        return servos::dispatch(context, request);
    }
    dispatch(context, request);
}

fn dispatch(context: Context, request: Request) {
    match request {
        Request::Alive => network::alive(&context),
        Request::TakeControl => network::take_control(&context),
        Request::AnswerControl { give } => network::answer_control(&context, give),
        Request::Scan => network::scan(&context),
        Request::Cancel { task } => context.core.cancel(task),
        Request::Network { node, command } => network::command(&context, node, &command),
        Request::LssFind => network::find(context),
        Request::LssAssign { serial, node } => network::assign(context, serial, node),
        Request::Stop => motion::stop(&context),
        Request::Enable { node } => motion::enable(context, node),
        Request::Disable { node } => motion::disable(context, node),
        Request::Move { node, deg } => motion::go(context, node, deg),
        Request::Turn { node, deg_s } => motion::turn(context, node, deg_s),
        Request::Press { node, nm } => motion::press(context, node, nm),
        Request::Preview { settings } => motion::preview(&context, &settings),
        Request::Excite { node, settings } => motion::excite(context, node, settings),
        Request::Read { node, objects } => objects::read(context, node, objects),
        Request::ReadAll { node } => objects::read_all(context, node),
        Request::Write {
            node,
            object,
            value,
        } => objects::write(context, node, object, value),
        Request::Save { node, group } => objects::save(context, node, group),
        Request::Restore { node } => objects::restore(context, node),
        Request::Export { node, format } => files::export(context, node, format),
        Request::ParseFile { text } => files::parse(&context, &text),
        Request::Faults { node } => faults::read(context, node),
        Request::ResetFaults { node } => faults::reset(context, node),
        Request::ClearHistory { node } => faults::clear(context, node),
        Request::Record { nodes, is_on } => files::record(&context, &nodes, is_on),
        Request::SaveRecording(recording) => files::save_recording(context, recording),
        Request::ArmCapture {
            node,
            trigger,
            before,
            decimation,
        } => {
            files::arm_capture(context, node, trigger, before, decimation);
        }
        Request::ReadCapture { node } => files::read_capture(context, node),
        Request::Tune(values) => tuning::tune(context, values),
        Request::Response { node, from_s, to_s } => response::measured(context, node, from_s, to_s),
        Request::ApplyGains { node, gains } => tuning::apply(context, node, gains),
        Request::Predict(prediction) => identify::predict(context, prediction),
        Request::Identify(identification) => identify::identify(context, identification),
        Request::TakeOver { node, values } => identify::take_over(context, node, values),
        Request::Commission(order) => commission::commission(context, order),
        Request::ImagePart { is_first, hex } => update::part(&context, is_first, &hex),
        Request::Update { node } => update::update(context, node),
        Request::BreakEncoder { node, is_broken } => {
            faults::break_encoder(&context, node, is_broken);
        }
    }
}

#[cfg(test)]
mod tests;
