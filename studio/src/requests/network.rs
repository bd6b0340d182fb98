//! Pages, nodes and their network states.

use std::time::Instant;

use canopen::{CanFrame, cob_id::LSS_RESPONSE};
use embedded_can::{Frame as _, StandardId};
use serde_json::json;

use super::Context;
use crate::attach;
use crate::bus::decode::nmt_command;
use crate::bus::lss::LssMaster;
use crate::motion;

pub fn alive(context: &Context) {
    context.core.with(|state| {
        if let Some(page) = state.pages.get_mut(&context.page) {
            page.alive = Instant::now();
        }
    });
}

pub fn take_control(context: &Context) {
    let event = context.core.with(|state| {
        state.control.ask(context.page, Instant::now());
        state.control.event()
    });
    context.core.pages.tell_all(&event);
    context.reply.result(Ok(json!(null)));
}

pub fn answer_control(context: &Context, give: bool) {
    let (is_holder, event) = context.core.with(|state| {
        let is_holder = state.control.answer(context.page, give);
        (is_holder, state.control.event())
    });
    context.core.pages.tell_all(&event);
    let answer = match is_holder {
        true => Ok(json!(null)),
        false => Err("this page does not have the control".into()),
    };
    context.reply.result(answer);
}

pub fn scan(context: &Context) {
    let reply = context.reply.clone();
    let begun = context.core.spawn(move |core, task| {
        attach::scan(core, &task);
        reply.result(Ok(json!(null)));
    });
    context.reply.busy(begun.map(drop));
}

/// The commands of CiA 301 by the names that pages use.
const COMMANDS: [u8; 5] = [1, 2, 128, 129, 130];

pub fn command(context: &Context, node: u8, command: &str) {
    let known = COMMANDS
        .into_iter()
        .find(|code| nmt_command(*code) == command);
    let Some(code) = known else {
        let known = COMMANDS.map(nmt_command).join(", ");
        let problem = format!("the command is {command}, expected one of {known}");
        return context.reply.result(Err(problem));
    };
    // A stopped or restarted node takes no stop any more.
    if code != 1 {
        motion::stop(&context.core, node);
    }
    let frame = CanFrame::new(StandardId::ZERO, &[code, node]);
    let sent = frame.map_or(Ok(()), |frame| context.core.hub.send(&frame));
    let answer = sent
        .map(|()| json!(null))
        .map_err(|error| error.to_string());
    context.reply.result(answer);
}

pub fn find(context: Context) {
    let reply = context.reply.clone();
    let begun = context.core.spawn(move |core, _| {
        let mut link = core.hub.link(LSS_RESPONSE..=LSS_RESPONSE);
        let mut master = LssMaster::new(&mut link);
        let found = master.find().and_then(|found| {
            master.leave()?;
            Ok(found)
        });
        let answer = found.map(|found| {
            found.map_or(json!(null), |[vendor, product, revision, serial]| {
                json!({ "vendor": vendor, "product": product, "revision": revision, "serial": serial })
            })
        });
        reply.result(answer.map_err(|error| error.to_string()));
    });
    context.reply.busy(begun.map(drop));
}

pub fn assign(context: Context, serial: u32, node: u8) {
    let is_taken = context
        .core
        .with(|state| state.nodes.get(&node).is_some_and(|node| !node.is_lost));
    if is_taken || !(1..=127).contains(&node) || node == motion::OWN_NODE {
        let problem = format!("{node} is no free node-ID, expected one of 1 to 126");
        return context.reply.result(Err(problem));
    }
    let reply = context.reply.clone();
    let begun = context.core.spawn(move |core, _| {
        let mut link = core.hub.link(LSS_RESPONSE..=LSS_RESPONSE);
        let mut master = LssMaster::new(&mut link);
        let assigned = match master.find() {
            Ok(Some([.., found])) if found == serial => {
                master.assign(node).map_err(|e| e.to_string())
            }
            Ok(_) => {
                // It leaves the state of configuration; without a bus there is nothing to leave.
                let _ = master.leave();
                Err("another device answers now; search again".to_owned())
            }
            Err(error) => Err(error.to_string()),
        };
        reply.result(assigned.map(|()| json!(null)));
    });
    context.reply.busy(begun.map(drop));
}
