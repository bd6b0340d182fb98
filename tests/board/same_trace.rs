//! The same run gives the same trace, independently of the load of the machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use board_tests::master::{driven, to_and_fro};
use board_tests::program::run_master;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;

fn hash(seed: u64) -> String {
    let options = Options {
        plant: BoardPlantOptions::realistic(seed),
        faults: vec![Planned::at_ms(900, Fault::Jam).for_ms(200)],
        ..Options::for_ms(2000)
    };
    let finished = run_master(options, |tick| driven(tick, to_and_fro(tick)));
    finished.trace.hash()
}

#[test]
fn the_hash_is_reproducible_under_load_and_depends_on_the_seed() {
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
