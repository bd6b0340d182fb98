//! Commissioning: the wiring is checked, the motor is measured, and what was found is saved.

mod commanded;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use canopen::cob_id::{HEARTBEAT, SDO_RESPONSE};
use host_sim::can::client::{Client, ClientError, MONITORED};
use host_sim::commission::{
    CommissionError, Findings, Kept, LEAST_RANGE_MDEG, Limits, Step, centre, find, page, write,
};
use host_sim::table::{Cell, Table};
use serde::Deserialize;
use serde_json::{Value, json};

use super::Context;
use crate::core::{Core, Task};
use crate::guarded::{Guard, GuardedLink};
use commanded::Reporting;

/// Least, usual and greatest value.
type Bounds = [u16; 3];

/// Highest mean current, % of the rated current.
const CURRENT_PCT: Bounds = [1, 100, 200];

/// Highest rate of the runs, deg/s.
const RATE_DEG_S: Bounds = [40, 120, 2000];

/// Greatest range of the angle, mdeg: two turns are reached in the time of a run.
const GREATEST_RANGE_MDEG: i64 = 720_000;

/// What is to be commissioned, and within which limits.
#[derive(Debug, Deserialize)]
pub struct Order {
    node: u8,
    /// Without it the stops are found.
    range_deg: Option<(f64, f64)>,
    current_pct: u16,
    rate_deg_s: u16,
    /// Whether what was found is written and saved.
    saves: bool,
    /// Whether the middle of the range becomes position 0 then.
    centres: bool,
}

/// The limits of the fields of a page.
pub fn limits() -> Value {
    let of = |[min, default, max]: Bounds| json!({ "min": min, "default": default, "max": max });
    json!({
        "current_pct": of(CURRENT_PCT), "rate_deg_s": of(RATE_DEG_S),
        "range_deg": [f64::from(LEAST_RANGE_MDEG) * 1e-3, GREATEST_RANGE_MDEG as f64 * 1e-3],
    })
}

impl Order {
    fn limits(&self) -> Result<Limits, String> {
        for (name, value, [min, _, max]) in [
            ("current", self.current_pct, CURRENT_PCT),
            ("rate", self.rate_deg_s, RATE_DEG_S),
        ] {
            if !(min..=max).contains(&value) {
                return Err(format!("the {name} is {value}, expected {min} to {max}"));
            }
        }
        Ok(Limits {
            range_mdeg: self.range_deg.map(range).transpose()?,
            permille: self.current_pct * 10,
            rate_mdeg_s: i32::from(self.rate_deg_s) * 1000,
        })
    }
}

fn range((low, high): (f64, f64)) -> Result<(i32, i32), String> {
    // A cast of what no object holds ends at the limits of the type.
    let [low_mdeg, high_mdeg] = [low, high].map(|deg| (deg * 1e3).round() as i32);
    let width = i64::from(high_mdeg) - i64::from(low_mdeg);
    if (LEAST_RANGE_MDEG.into()..=GREATEST_RANGE_MDEG).contains(&width) {
        return Ok((low_mdeg, high_mdeg));
    }
    Err(format!(
        "the range is {low} to {high} deg, expected {} to {} deg from its lower end to its upper end",
        LEAST_RANGE_MDEG / 1000,
        GREATEST_RANGE_MDEG / 1000
    ))
}

/// Commissions an actuator. No other transfer with it comes in between; a stop, the loss of the
/// page and a cancelled task end it, and the actuator then has its parameters of before.
pub fn commission(context: Context, order: Order) {
    let limits = match order.limits() {
        Ok(limits) => limits,
        Err(why) => return context.reply.result(Err(why)),
    };
    let Order {
        node,
        saves,
        centres,
        ..
    } = order;
    let (page, reply) = (context.page, context.reply.clone());
    let guard = context.core.guard(node);
    let is_free = context.core.with_node(node, |node| {
        let is_free = node.commissioned_by.is_none() && !node.is_stopping;
        if is_free {
            node.commissioned_by = Some((page, guard.clone()));
        }
        is_free
    });
    if is_free != Some(true) {
        return reply.result(Err("the actuator is stopping or being commissioned".into()));
    }
    let begun = context.core.spawn(move |core, task| {
        let (done, ended) = mpsc::channel();
        let run = Run {
            core: Arc::clone(core),
            task,
            node,
            guard,
            limits,
            saves,
            centres,
        };
        let begun = core.at_node(node, move |_| {
            let _ = done.send(run.answer());
        });
        let answer = match begun {
            Ok(()) => ended.recv().unwrap_or_else(|error| Err(error.to_string())),
            Err(busy) => Err(busy.to_string()),
        };
        core.with_node(node, |node| node.commissioned_by = None);
        let shown = match &answer {
            Ok(findings) => findings.clone(),
            Err(error) => json!({ "error": error }),
        };
        core.pages
            .tell_all(&json!({ "event": "commission", "node": node, "answer": shown }));
        reply.result(answer);
    });
    if begun.is_err() {
        let core = &context.core;
        core.with_node(node, |node| node.commissioned_by = None);
    }
    context.reply.busy(begun.map(drop));
}

/// A commissioning under way.
struct Run {
    core: Arc<Core>,
    task: Task,
    node: u8,
    guard: Guard,
    limits: Limits,
    saves: bool,
    centres: bool,
}

impl Run {
    fn answer(&self) -> Result<Value, String> {
        self.core.log("info", Some(self.node), "is commissioned");
        let answer = self.commission().map_err(|(error, restored)| {
            let why = match *error {
                // The error is that of the transfer that was under way.
                _ if self.guard.is_stopped() => "stopped".to_owned(),
                CommissionError::Client(ClientError::Interrupted) => "ended on request".to_owned(),
                error => error.to_string(),
            };
            match restored {
                Ok(()) => format!("{why}. The actuator has the parameters of before."),
                Err(error) => format!(
                    "{why}. The parameters of before could not be restored; a restart of the \
                     actuator restores them: {error}"
                ),
            }
        });
        match &answer {
            Ok(_) => self
                .core
                .log("info", Some(self.node), "has been commissioned"),
            Err(why) => {
                let text = format!("is not commissioned: {why}");
                self.core.log("warning", Some(self.node), &text);
            }
        }
        answer
    }

    /// # Errors
    /// What has ended it, and whether the parameters of before are in force.
    fn commission(&self) -> Result<Value, (Box<CommissionError>, Result<(), String>)> {
        let ended = |error: CommissionError, restored| (Box::new(error), restored);
        let kept = Kept::of(&mut self.client()).map_err(|error| ended(error.into(), Ok(())))?;
        let findings = joined(|| self.find(&kept));
        let restored = self.end(&kept).map_err(|error| error.to_string());
        if let Err(error) = &restored {
            let text = format!("keeps parameters of the commissioning: {error}");
            self.core.log("fault", Some(self.node), &text);
        }
        let is_ended = self.guard.is_stopped() || self.task.end().load(Ordering::Relaxed);
        let mut findings = match findings {
            Ok(findings) if restored.is_ok() && !is_ended => findings,
            Ok(_) => return Err(ended(ClientError::Interrupted.into(), restored)),
            Err(error) => return Err(ended(error, restored)),
        };
        if self.saves {
            let written = self.write(&mut findings);
            written.map_err(|error| {
                let restored = self.end(&kept);
                ended(error, restored.map_err(|error| error.to_string()))
            })?;
        }
        let tables = findings.tables(self.saves);
        let origin = format!(
            "Made with Studio of version {}, for actuator {}",
            env!("CARGO_PKG_VERSION"),
            self.node
        );
        let page = page(&findings, &origin, self.saves).render();
        Ok(json!({
            "saved": self.saves, "range_mdeg": findings.range_mdeg, "doubts": findings.doubts(),
            "tables": tables.iter().map(shown).collect::<Vec<_>>(), "page": page,
        }))
    }

    /// The last steps: the origin if it is wanted, and the write.
    fn write(&self, findings: &mut Findings) -> Result<(), CommissionError> {
        if self.centres {
            self.report("makes the middle of the range position 0");
            self.supervised(|client| centre(client, &self.limits, findings))?;
        }
        self.report("writes and saves what was found");
        write(&mut self.client(), findings)
    }

    /// Leaves the drive off and the actuator with the parameters of before. What a stop has ended
    /// has left a transfer, and the actuator without the heartbeat that it monitors.
    fn end(&self, kept: &Kept) -> Result<(), ClientError> {
        let mut client = self.client();
        // Without a transfer the actuator ignores it, and without a bus all that follows fails.
        let _ = client.sdo().abort(0x1016, 2);
        client.write(MONITORED, "0")?;
        self.await_stop();
        client.quick_stop()?;
        kept.restore(&mut client)
    }

    /// A client that no stop ends, without the responses to earlier ones.
    fn client(&self) -> Client {
        let response = SDO_RESPONSE + u32::from(self.node);
        Client::new(Box::new(self.core.hub.link(response..=response)), self.node)
    }

    /// Waits while a stop is repeated, whose responses are not those of a client. A drive that does
    /// not stop refuses what follows.
    fn await_stop(&self) {
        const PATIENCE: Duration = Duration::from_secs(10);
        let end = Instant::now() + PATIENCE;
        let is_stopping = || self.core.with_node(self.node, |node| node.is_stopping) == Some(true);
        while is_stopping() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn find(&self, kept: &Kept) -> Result<Findings, CommissionError> {
        self.supervised(|client| find(client, &self.limits, (kept, true), |step| self.report(step)))
    }

    /// Does what enables the drive. The heartbeats of other clients are received too: this one
    /// needs a node-ID of its own.
    fn supervised<T>(
        &self,
        motion: impl FnOnce(&mut Client) -> Result<T, CommissionError>,
    ) -> Result<T, CommissionError> {
        let first = SDO_RESPONSE + u32::from(self.node);
        let link = self.core.hub.link(first..=HEARTBEAT + 127);
        let link = GuardedLink::new(link, self.guard.clone());
        let (core, task, node) = (Arc::clone(&self.core), self.task.number, self.node);
        let link = Reporting::new(link, move |text| report(&core, task, node, text));
        let mut client = Client::new(Box::new(link), self.node);
        let interrupt: Arc<AtomicBool> = self.task.end();
        let done = client.supervised(Arc::clone(&interrupt), motion, Client::quick_stop);
        match done {
            // A transfer that fails because the drive has been switched off is its consequence.
            Err(_) if interrupt.load(Ordering::Relaxed) => Err(ClientError::Interrupted.into()),
            done => done,
        }
    }

    fn report(&self, text: &str) {
        report(&self.core, self.task.number, self.node, text);
    }
}

/// Does it in a thread of its own: the thread of the node outlives its panic, which is an error.
fn joined<T: Send>(
    work: impl FnOnce() -> Result<T, CommissionError> + Send,
) -> Result<T, CommissionError> {
    std::thread::scope(|scope| scope.spawn(work).join()).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(CommissionError::Refused {
            step: Step::Program,
            why: format!(
                "it has failed: {}",
                text.unwrap_or("the reason is not known")
            ),
        })
    })
}

/// A table, whose cells are texts.
fn shown(table: &Table) -> Value {
    let columns = table.columns.iter().zip(table.numeric_columns());
    let columns = columns.map(|(column, is_number)| {
        json!({ "name": column.name, "unit": column.unit, "number": is_number })
    });
    let texts = |row: &Vec<Cell>| row.iter().map(Cell::to_string).collect::<Vec<_>>();
    json!({
        "caption": table.caption, "columns": columns.collect::<Vec<_>>(),
        "rows": table.rows.iter().map(texts).collect::<Vec<_>>(),
    })
}

/// Shows on all pages what is done.
fn report(core: &Core, task: u64, node: u8, text: &str) {
    core.pages.tell_all(&json!({
        "event": "commission", "node": node, "task": task, "at_s": core.now_s(), "text": text,
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(range_deg: Option<(f64, f64)>, current_pct: u16, rate_deg_s: u16) -> Order {
        Order {
            node: 1,
            range_deg,
            current_pct,
            rate_deg_s,
            saves: false,
            centres: false,
        }
    }

    #[test]
    fn a_panic_is_an_error() {
        for work in [
            || -> Result<(), CommissionError> { panic!("index {}", 7) },
            || -> Result<(), CommissionError> { panic!("index 7") },
        ] {
            let error = joined(work).expect_err("it panics").to_string();
            assert_eq!(error, "commissioning: it has failed: index 7");
        }
        assert!(joined(|| Ok(())).is_ok());
    }

    #[test]
    fn limits_are_those_of_the_fields_at_their_ends() {
        let limits = order(Some((-20.0, 20.0)), 200, 40).limits().unwrap();
        assert_eq!(limits.range_mdeg, Some((-20_000, 20_000)));
        assert_eq!((limits.permille, limits.rate_mdeg_s), (2000, 40_000));
        assert!(order(None, 1, 2000).limits().unwrap().range_mdeg.is_none());
    }

    #[test]
    fn what_is_beyond_the_limits_is_refused_by_name() {
        for (order, why) in [
            (order(None, 0, 120), "the current is 0, expected 1 to 200"),
            (
                order(None, 201, 120),
                "the current is 201, expected 1 to 200",
            ),
            (order(None, 100, 39), "the rate is 39, expected 40 to 2000"),
            (
                order(Some((0.0, 39.9)), 100, 120),
                "the range is 0 to 39.9 deg, expected 40",
            ),
            (
                order(Some((45.0, -45.0)), 100, 120),
                "the range is 45 to -45 deg",
            ),
            (
                order(Some((-1e300, 1e300)), 100, 120),
                "expected 40 to 720 deg",
            ),
        ] {
            let refusal = order.limits().unwrap_err();
            assert!(refusal.contains(why), "{refusal}");
        }
    }
}
