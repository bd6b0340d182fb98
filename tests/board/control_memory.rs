//! What the control step works with does not change unnoticed while the device processes the bus.

use crate::disturbed::{Flip, is_told, motion, run};
use crate::repeated_step::{DURATION_MS, STEP, WORDS, changing_words, frames};

#[test]
fn a_flip_in_the_state_of_the_loop_during_a_call_for_the_bus_is_told() {
    let undisturbed = motion(&run(frames, DURATION_MS, None));
    let mut told = [0; 2];
    for address in changing_words() {
        for (call, told) in told.iter_mut().enumerate() {
            let disturbed = run(
                frames,
                DURATION_MS,
                Some(Flip {
                    address,
                    bit: 5,
                    before: "communicate",
                    entry: 2 * STEP + call as u64,
                }),
            );
            *told += usize::from(is_told(&disturbed, &undisturbed));
        }
    }
    println!("told of {WORDS}: {told:?}");
    // The others are results that nothing uses in the next control step.
    assert!(told.iter().all(|told| *told >= WORDS / 2), "{told:?}");
}
