//! What is written and saved, and when.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use canopen::{CanFrame, NodeId};
use embedded_can::{Frame as _, StandardId};
use model_core::plant::board::{BoardPlantOptions, Defects};

use super::bench::{LIMITS, client};
use crate::can::client::Client;
use crate::can::link::Link;
use crate::can::names;
use crate::can::native_link::NativeLink;
use crate::can::native_node::{CAPTURE_VALUES, NativeNode};
use crate::commission::{Baseline, Kept, measure, tune, write};

#[test]
fn only_the_write_changes_what_the_actuator_keeps() {
    let mut client = client(&BoardPlantOptions::another_servo(3), Defects::default());
    let model = |client: &mut Client| {
        let value = client.get(names::find("2011:2").expect("an object"));
        value.expect("a value").to_string()
    };
    const TUNED: [&str; 5] = ["60FB:1", "60F9:1", "60F9:3", "2013:2", "6083"];
    let tuned = |client: &mut Client| {
        TUNED.map(|object| {
            let value = client.get(names::find(object).expect("an object"));
            value.expect("a value").to_string()
        })
    };
    let (before, tuned_before) = (model(&mut client), tuned(&mut client));
    let signal = client.integer("2031:2").expect("a signal");
    let kept = Kept::of(&mut client).expect("values");
    let mut found = measure(&mut client, &LIMITS).expect("a good bench");
    found.tuning = Some(tune(&mut client, &found).expect("gains"));
    assert_ne!(tuned(&mut client), tuned_before);
    kept.restore(&mut client).expect("the drive is off");
    assert_eq!(model(&mut client), before);
    assert_eq!(tuned(&mut client), tuned_before);
    assert_eq!(client.integer("2031:2").expect("a signal"), signal);
    assert_eq!(client.integer("607D:2").expect("a limit"), 60_000);
    let mut refused = found.clone();
    refused.baseline = Some(Baseline {
        friction_ma: 30.0,
        constant_v_s_deg: 1e3,
        ..Baseline::default()
    });
    let error = write(&mut client, &refused).expect_err("beyond the range");
    assert!(error.to_string().contains("2053"), "{error}");
    assert_eq!(client.integer("2053:1").expect("a baseline"), 300);
    kept.restore(&mut client).expect("the drive is off");
    assert_eq!(client.integer("2053:1").expect("a baseline"), 0);
    assert_eq!(model(&mut client), before);
    assert_eq!(tuned(&mut client), tuned_before);
    write(&mut client, &found).expect("it saves");
    assert_ne!(model(&mut client), before);
    assert!(
        found
            .objects()
            .iter()
            .any(|(object, _)| *object == "2013:2")
    );
    for (object, value) in found.objects() {
        let stored = client.get(names::find(object).expect("an object"));
        let stored = stored.expect("a value").to_string();
        assert_eq!(stored, (value as f32).to_string(), "{object}");
    }
    assert_eq!(client.integer("607D:2").expect("a limit"), 45_000);
    // The date of the configuration, days since 1984, of a test that runs after 2026-01-01.
    assert!(client.integer("1020:1").expect("a date") >= 15_341);
}

/// Time of a start of the node.
pub const START: Duration = Duration::from_millis(200);

/// A bus that resets its node before a frame, and continues when it has started.
struct Resetting {
    link: NativeLink,
    /// Frames until then.
    left: Arc<AtomicUsize>,
}

impl Link for Resetting {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        if self.left.fetch_sub(1, Ordering::Relaxed) == 0 {
            const RESET_NODE: [u8; 2] = [0x81, 0];
            let reset = CanFrame::new(StandardId::ZERO, &RESET_NODE).expect("two bytes");
            self.link.send(&reset)?;
            self.link.pause(START)?;
        }
        self.link.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        self.link.receive(timeout)
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.link.pause(time)
    }
}

#[test]
fn a_restart_before_any_frame_of_the_write_leaves_one_whole_set() {
    let options = BoardPlantOptions::another_servo(3);
    let found = measure(&mut client(&options, Defects::default()), &LIMITS).expect("a good bench");
    let values = |client: &mut Client| {
        let found = found.objects().into_iter().map(|(object, _)| object);
        let objects = found.chain(["607D:1", "607D:2"]).map(names::find);
        let texts = objects.map(|object| client.get(object.expect("an object")));
        let texts = texts.map(|text| text.expect("a value").to_string());
        texts.collect::<Vec<_>>()
    };
    let mut refused = 0;
    for frame in 0.. {
        let buffer = Box::leak(Box::new([0; CAPTURE_VALUES]));
        let node = NativeNode::new(1, NodeId::new(1), &options, buffer).expect("a plant");
        let link = NativeLink::new(node, |_| {});
        let left = Arc::new(AtomicUsize::new(usize::MAX));
        let bus = Resetting {
            link,
            left: Arc::clone(&left),
        };
        let mut client = Client::new(Box::new(bus), 1);
        client.pause(START).expect("no input");
        let old = values(&mut client);
        left.store(frame, Ordering::Relaxed);
        let written = write(&mut client, &found);
        let has_reset = left.swap(0, Ordering::Relaxed) > frame;
        // Resets again: these are the values of the flash.
        let whole = values(&mut client);
        match written {
            Ok(()) => assert!(
                whole.iter().zip(&old).all(|(whole, old)| whole != old),
                "frame {frame}: {whole:?}"
            ),
            Err(error) => {
                assert!(error.to_string().contains("has restarted"), "{error}");
                assert_eq!(whole, old, "frame {frame}");
                refused += 1;
            }
        }
        if !has_reset {
            break;
        }
    }
    // Those between the first and the last write, the first reads, and the save.
    assert!(refused >= 10, "{refused}");
}
