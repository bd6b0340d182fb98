//! The control step is computed twice: what changes one of both computations is noticed.

use board_tests::master::{Master, PERIODS};
use board_tests::program::{firmware, run_script};
use virtual_board::run::{Flow, Options, Script, View};

use crate::disturbed::{DURATION_MS, Driving, ENTRIES, Flip, STEP, frames, is_told, motion, run};

/// Words of the device that are disturbed, of those that each control step changes.
const WORDS: usize = 6;

/// Reads the device before three control steps in a row.
struct Reader {
    master: Driving,
    edges: u64,
    images: Vec<Vec<u32>>,
}

impl Script for Reader {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let steps = self.edges / PERIODS;
        if self.edges.is_multiple_of(PERIODS) && (STEP - 3..STEP).contains(&steps) {
            let device = firmware().symbol_containing("init_device");
            let words = device.expect("a variable").step_by(4);
            let image = words.map(|address| view.word(address).expect("memory"));
            self.images.push(image.collect());
        }
        self.edges += 1;
        self.master.at_edge(view)
    }
}

/// The words of the device before three control steps in a row, each with its address.
pub fn device_words() -> Vec<(u64, [u32; 3])> {
    let reader = Reader {
        master: Master::new(frames),
        edges: 0,
        images: Vec::new(),
    };
    let images = run_script(Options::for_ms(4 * STEP), reader).script.images;
    let device = firmware().symbol_containing("init_device");
    let addresses = device.expect("a variable").step_by(4).enumerate();
    let [first, second, third] = images.as_slice() else {
        panic!("{} control steps", images.len());
    };
    addresses
        .map(|(k, address)| (address, [first[k], second[k], third[k]]))
        .collect()
}

/// Addresses of the words of the device that each control step changes.
pub fn changing_words() -> Vec<u64> {
    let changing = |values: &[u32; 3]| values.windows(2).all(|pair| pair[0] != pair[1]);
    let words = device_words().into_iter();
    let changing = words.filter(|(_, values)| changing(values));
    changing.map(|(address, _)| address).collect()
}

/// A flip before this entry of the computation.
fn flip(address: u64, entry: u64) -> Flip {
    Flip {
        address,
        bit: 5,
        before: "device_control",
        entry,
    }
}

#[test]
fn a_flip_before_one_of_both_computations_of_a_control_step_is_told_or_without_effect() {
    let undisturbed = motion(&run(frames, DURATION_MS, None));
    let mut told = [0; 2];
    let changing = changing_words();
    assert!(changing.len() > 2 * WORDS, "{changing:x?}");
    for address in changing.iter().copied().step_by(changing.len() / WORDS) {
        for (computation, told) in told.iter_mut().enumerate() {
            let flip = flip(address, ENTRIES + 1 + computation as u64);
            let disturbed = run(frames, DURATION_MS, Some(flip));
            *told += usize::from(is_told(&disturbed, &undisturbed));
        }
    }
    println!("told of {WORDS}: {told:?}");
    // Some words are written before they are read.
    assert!(told.iter().all(|told| *told > 0), "{told:?}");
}

#[test]
fn a_flip_in_the_copy_from_which_a_control_step_is_repeated_is_told() {
    let copy = firmware().symbol_containing("copy_of_device");
    let last = copy.expect("a variable").end - 1;
    let disturbed = run(frames, DURATION_MS, Some(flip(last, ENTRIES + 1)));
    assert!(is_told(&disturbed, &[]));
}
