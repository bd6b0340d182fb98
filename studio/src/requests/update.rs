//! The update of an actuator's program.

use std::sync::Arc;
use std::sync::mpsc;

use bootloader::layout::STM32F427;
use canopen::cob_id::{HEARTBEAT, SDO_RESPONSE};
use host_sim::can::update::update as load;
use program_image::signed::{SignError, inspect};
use serde_json::{Value, json};

use super::Context;
use crate::core::{Core, Task};

/// Bytes of an image that are kept at most: the flash of the largest board.
const LONGEST: usize = 2 << 20;

/// Takes a part of an image, two digits a byte: a whole one is longer than a message may be.
pub fn part(context: &Context, is_first: bool, hex: &str) {
    let digits = hex.as_bytes().chunks(2);
    let bytes: Option<Vec<u8>> = digits
        .map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok())
        .collect();
    let taken = context.core.with(|state| {
        if is_first {
            state.image.clear();
        }
        let bytes = bytes.ok_or("the part is not in hexadecimal digits")?;
        if state.image.len() + bytes.len() > LONGEST {
            return Err("the image is longer than the flash of any board");
        }
        state.image.extend(bytes);
        Ok(json!(state.image.len()))
    });
    context.reply.result(taken.map_err(str::to_owned));
}

/// Loads the image into an actuator, and waits until the new program has confirmed itself. No other
/// transfer with the actuator comes in between.
pub fn update(context: Context, node: u8) {
    let image = context.core.with(|state| std::mem::take(&mut state.image));
    let reply = context.reply.clone();
    let begun = context.core.spawn(move |core, task| {
        let (done, ended) = mpsc::channel();
        let begun = core.at_node(node, {
            let (core, task) = (Arc::clone(core), task.clone());
            move |_| {
                let _ = done.send(run(&core, &task, node, &image));
            }
        });
        reply.result(match begun {
            Ok(()) => ended.recv().unwrap_or_else(|error| Err(error.to_string())),
            Err(busy) => Err(busy.to_string()),
        });
    });
    context.reply.busy(begun.map(drop));
}

fn run(core: &Arc<Core>, task: &Task, node: u8, image: &[u8]) -> Result<Value, String> {
    let header = inspect(image, &STM32F427).map_err(|refusal| SignError::Refused {
        path: "the image".into(),
        refusal,
    });
    let header = header.map_err(|error| error.to_string())?;
    let number = u32::from(node);
    let mut link = core.hub.link(SDO_RESPONSE + number..=HEARTBEAT + number);
    let mut progress = |bytes| task.progress("bytes of the program", bytes, image.len());
    load(&mut link, node, (&header, image), &mut progress).map_err(|error| error.to_string())?;
    let version = header.version.to_string();
    core.log(
        "info",
        Some(node),
        &format!("has program version {version}"),
    );
    Ok(json!(version))
}
