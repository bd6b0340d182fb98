//! The whole chain: a client on the serial line of the communication board, and actuator boards on
//! its bus.

use std::thread;

use firmware::drive::StoredParameters;
use firmware::store::{Stored, first_page};
use virtual_board::can::Sent;
use virtual_board::flash::Sector;
use virtual_board::run::{
    Attachments, CommFinished, CommOptions, Finished, Options, Script, SerialScript, SharedBus,
    run_comm, run_with,
};

use crate::comm::{POLL_NS, comm_firmware};
use crate::program::firmware;

/// Address and contents of the flash with these parameters saved.
///
/// # Panics
/// If the chip has no sector for it.
pub fn saved<S: Stored>(set: &S) -> (u64, Vec<u8>) {
    let sector = Sector::of_number(12).expect("the first of bank 2");
    let words = first_page(set);
    let bytes = words.as_ref().iter().flat_map(|word| word.to_le_bytes());
    (sector.base, bytes.collect())
}

/// The results of a run of the chain.
pub struct Chain<S, D> {
    /// The actuator boards.
    pub actuators: Vec<Finished<S>>,
    /// The communication board.
    pub comm: CommFinished<D>,
    /// Frames that were on the bus; senders: the actuators in their order, then the communication
    /// board.
    pub log: Vec<Sent>,
}

/// Runs actuators with node-IDs from 1 on, each with its script, and the communication board with
/// its own; asserts that the emulation had no gap.
///
/// # Panics
/// If it had one, or a run fails.
pub fn run_chain<S, D>(options: &Options, scripts: Vec<S>, client: D) -> Chain<S, D>
where
    S: Script + 'static,
    D: SerialScript + 'static,
{
    let bus = SharedBus::new(Vec::new(), scripts.len() + 1);
    let mut connections = bus.connections().into_iter();
    let mut threads = Vec::new();
    for (node_id, (script, connection)) in (1..).zip(scripts.into_iter().zip(&mut connections)) {
        let mut parameters = StoredParameters::DEFAULT;
        parameters.board.bus.node_id = node_id;
        let options = Options {
            contents: vec![saved(&parameters)],
            ..options.clone()
        };
        let attachments = Attachments {
            bus: Some(connection),
            ..Attachments::default()
        };
        threads.push(thread::spawn(move || {
            run_with(firmware(), options, script, attachments).expect("the run succeeds")
        }));
    }
    let options = CommOptions {
        bus: connections.next().expect("a connection for each board"),
        poll_ns: POLL_NS,
        until_ns: options.until_ns,
        interrupt: None,
    };
    let comm = run_comm(comm_firmware(), options, client).expect("the run succeeds");
    assert!(comm.gaps.is_empty(), "{}", comm.gaps);
    let actuators = threads
        .into_iter()
        .map(|thread| thread.join().expect("no panic"));
    let actuators: Vec<Finished<S>> = actuators.collect();
    for finished in &actuators {
        assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    }
    Chain {
        actuators,
        comm,
        log: bus.take_log(),
    }
}
