//! The same run gives the same trace, however busy the machine is.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use board_tests::runs::{run_schedule, to_and_fro};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;

fn hash(seed: u64) -> String {
    let options = Options {
        rig: BoardPlantOptions::realistic(seed),
        faults: vec![Planned::at_ms(900, Fault::Jam).for_ms(200)],
        ..Options::for_ms(2000)
    };
    run_schedule(options, to_and_fro).trace.hash()
}

#[test]
fn twice_in_a_row_and_under_load_the_hash_is_the_same_and_another_seed_has_another() {
    let first = hash(1);
    assert_eq!(hash(1), first);
    let is_over = Arc::new(AtomicBool::new(false));
    let load: Vec<_> = (0..3)
        .map(|_| {
            let is_over = is_over.clone();
            std::thread::spawn(move || {
                while !is_over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            })
        })
        .collect();
    let under_load = hash(1);
    is_over.store(true, Ordering::Relaxed);
    load.into_iter()
        .for_each(|thread| thread.join().expect("it only spins"));
    assert_eq!(under_load, first);
    assert_ne!(hash(2), first);
}
