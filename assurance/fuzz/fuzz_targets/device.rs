//! The whole device, run by bytes and checked in every control period.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    device_fuzzing::run(input);
});
