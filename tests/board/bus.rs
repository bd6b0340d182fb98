//! The node on its bus: boot-up, filters, another bit rate, parameters after a loss of power.

use board_tests::frames::{
    Frame, SAVE, Sent, control, nmt, read, responses, sent, standard, write, write_real,
};
use board_tests::master::{Master, driven};
use board_tests::program::{run_master, run_script};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::Bridge;
use virtual_board::run::{Flow, Options, Script, View};

const BOOT_UP: (u32, bool) = (0x701, false);

/// Instants of the frames with an identifier, ms.
fn times_ms(sent: &[Sent], id: (u32, bool)) -> Vec<u64> {
    let with_id = sent.iter().filter(|sent| sent.frame.raw_id() == id);
    with_id.map(|sent| sent.at_ns / 1_000_000).collect()
}

#[test]
fn the_first_frame_is_the_boot_up_and_a_node_that_is_not_started_sends_nothing_more() {
    let finished = run_master(Options::for_ms(300), |_| Vec::new());
    let sent = sent(&finished);
    assert_eq!(sent.len(), 1, "{sent:?}");
    assert_eq!(sent[0].frame, standard(0x701, &[0]));
    assert!(sent[0].at_ns < 20_000_000, "{} ns", sent[0].at_ns);
}

/// Within 20 ms, as at the power-on: the shaft stops meanwhile.
#[test]
fn a_boot_up_follows_each_reset_at_once_in_motion_too() {
    for (command, target_mdeg) in [(0x81, 0), (0x82, 0), (0x81, 60_000)] {
        let finished = run_master(Options::for_ms(500), move |tick| match tick {
            100 => vec![standard(0, &[command, 1])],
            ..100 => driven(tick, target_mdeg),
            _ => Vec::new(),
        });
        let times = times_ms(&sent(&finished), BOOT_UP);
        assert_eq!(times.len(), 2, "{command:x}: {times:?}");
        assert!(
            times[0] < 20 && (400..420).contains(&times[1]),
            "{command:x}: {times:?}"
        );
    }
}

#[test]
fn telemetry_is_sent_each_tick_and_status_at_50_hz() {
    let finished = run_master(Options::for_ms(2100), |tick| driven(tick, 5_000));
    let sent = sent(&finished);
    for (id, per_second) in [(0x181, 250), (0x281, 250), (0x381, 50)] {
        let times = times_ms(&sent, (id, false));
        let second = times.iter().filter(|ms| (1000..2000).contains(*ms));
        let count = second.count();
        assert!(count.abs_diff(per_second) <= 1, "{id:x}: {count}");
    }
}

/// Moves RPDO 3 to an identifier of 29 bits, while many frames are sent to other nodes.
fn moved(tick: u64) -> Vec<Frame> {
    let foreign = || standard(0x205, &[0; 6]);
    match tick {
        50 => vec![write(0x1402, 1, 0x8000_0401, 4)],
        55 => vec![write(0x1402, 1, 0x2012_3456, 4)],
        20..40 => driven(tick, 0),
        60..200 if tick.is_multiple_of(5) => vec![moved_control(20_000), foreign(), foreign()],
        // The old identifier is ignored.
        200..230 if tick.is_multiple_of(5) => vec![moved_control(20_000), control(0x0f, -20_000)],
        230.. if tick.is_multiple_of(5) => vec![moved_control(20_000)],
        _ => vec![foreign()],
    }
}

/// RPDO 3 with its other identifier.
fn moved_control(mdeg: i32) -> Frame {
    let data = control(0x0f, mdeg).bytes();
    Frame::raw(0x12_3456, true, false, 6, data).expect("a frame")
}

#[test]
fn the_controller_accepts_the_identifiers_of_the_node_after_a_pdo_has_moved() {
    let options = Options {
        probes: vec!["CAN1_RX0".into()],
        ..Options::for_ms(1200)
    };
    let ticks = 1200 / 4;
    let finished = run_master(options, moved);
    let angle = finished.plant.reading().output.angle_deg;
    assert!((angle - 20.0).abs() < 1.0, "{angle} deg");
    let own: usize = (0..ticks)
        .flat_map(moved)
        .filter(|frame| frame.raw_id().0 != 0x205)
        .filter(|frame| frame.bytes() != control(0x0f, -20_000).bytes())
        .count();
    let interrupts = finished.spans["CAN1_RX0"].len();
    assert!(interrupts.abs_diff(own) <= 2, "{interrupts} for {own}");
}

/// A master that changes to another bit rate with the bus.
struct Switching<F> {
    master: Master<F>,
    /// Tick of the change.
    at_tick: u64,
}

impl<F: Fn(u64) -> Vec<Frame> + Send> Script for Switching<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if let Some(tick) = self.master.tick() {
            self.master.port = usize::from(tick >= self.at_tick);
            for number in 0..2 {
                if let Some(port) = view.port(number) {
                    port.is_silent = number != self.master.port;
                }
            }
        }
        self.master.at_edge(view)
    }
}

fn lss(bytes: [u8; 3]) -> Frame {
    let [command, a, b] = bytes;
    standard(0x7e5, &[command, a, b, 0, 0, 0, 0, 0])
}

/// LSS: configuration state, the bit rate of this entry of CiA's table, activation 40 ms later;
/// then an SDO at the new rate.
fn slower(entry: u8, tick: u64) -> Vec<Frame> {
    match tick {
        30 => vec![lss([0x04, 1, 0])],
        35 => vec![lss([0x13, 0, entry])],
        40 => vec![lss([0x15, 40, 0])],
        70 => vec![lss([0x04, 0, 0]), read(0x1018, 1)],
        _ => Vec::new(),
    }
}

#[test]
fn the_bit_rate_changes_by_lss() {
    for (entry, bit_s) in [(2, 500_000), (3, 250_000), (4, 125_000)] {
        let options = Options {
            ports_bit_s: vec![1_000_000, bit_s],
            ..Options::for_ms(400)
        };
        let script = Switching {
            master: Master::new(move |tick| slower(entry, tick)),
            at_tick: 50,
        };
        let finished = run_script(options, script);
        let sent = sent(&finished);
        let configured = sent.iter().filter(|sent| sent.frame.raw_id().0 == 0x7e4);
        let configured: Vec<_> = configured.map(|sent| sent.frame.bytes()).collect();
        assert_eq!(configured, [[0x13, 0, 0, 0, 0, 0, 0, 0]], "{bit_s}");
        let responses = responses(&finished);
        assert_eq!(responses.len(), 1, "{responses:x?}");
        assert_eq!(responses[0][..4], [0x43, 0x18, 0x10, 1]);
    }
}

/// Stores a heartbeat of 60 ms and another gain before the loss of power.
fn stored(tick: u64) -> Vec<Frame> {
    match tick {
        30 => vec![write(0x1017, 0, 60, 2)],
        32 => vec![write_real(0x60FB, 1, 7.25)],
        34 => vec![write(0x1010, 1, SAVE, 4)],
        300 | 600 => vec![read(0x60FB, 1)],
        _ => Vec::new(),
    }
}

#[test]
fn parameters_stored_by_1010h_survive_a_loss_of_power() {
    let options = Options {
        faults: vec![Planned::at_ms(1500, Fault::PowerLoss).for_ms(50)],
        ..Options::for_ms(3000)
    };
    let finished = run_master(options, stored);
    let responses = responses(&finished);
    let value = 7.25_f32.to_le_bytes();
    let [.., before, after] = responses[..] else {
        panic!("{responses:x?}");
    };
    for response in [before, after] {
        assert_eq!(response[4..], value, "{response:x?}");
    }
    let all = times_ms(&sent(&finished), BOOT_UP);
    let late: Vec<_> = all.iter().filter(|ms| **ms > 1700).copied().collect();
    let periods: Vec<_> = late.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(periods.len() > 15, "{all:?}");
    assert!(
        periods.iter().all(|ms| (58..=62).contains(ms)),
        "{periods:?}"
    );
}

#[test]
fn an_nmt_reset_boots_again_with_the_power_off() {
    let finished = run_master(Options::for_ms(1500), |tick| match tick {
        200 => vec![nmt(0x81)],
        201.. => Vec::new(),
        _ => driven(tick, 10_000),
    });
    let boots: Vec<_> = sent(&finished)
        .into_iter()
        .filter(|sent| sent.frame == standard(0x701, &[0]))
        .collect();
    assert_eq!(boots.len(), 2, "{boots:?}");
    // The shaft is brought to rest first.
    let after = boots[1].at_ns + 200_000_000;
    let rows = finished.trace.rows.iter().filter(|row| row.at_ns > after);
    assert!(rows.clone().count() > 300);
    assert!(rows.into_iter().all(|row| row.bridge == Bridge::Coast));
    assert!(finished.resets.is_empty(), "the processor is not reset");
}
