//! Kept states.

use std::ptr::{null_mut, without_provenance_mut};

use actuator_fmu::abi::*;
use model_core::scenario;

use crate::host::Host;

fn half_way(host: &Host) {
    host.set("command_deg", 35.0);
    for i in 0..50 {
        host.step(f64::from(i) * 0.003, 0.003);
    }
}

fn to_the_end(host: &Host) -> [u64; 5] {
    host.set("command_deg", -20.0);
    for i in 50..100 {
        host.step(f64::from(i) * 0.003, 0.003);
    }
    host.outputs()
}

#[test]
fn a_kept_state_is_gone_back_to_as_often_as_one_likes() {
    for settings in scenario::choices() {
        let host = Host::initialized(&settings);
        half_way(&host);
        let state = host.keep();
        let first = to_the_end(&host);
        for _ in 0..2 {
            // SAFETY: a component in use by this thread alone, here and below.
            assert_eq!(unsafe { fmi2SetFMUstate(host.c, state) }, Status::Ok);
            assert_eq!(to_the_end(&host), first);
        }
    }
}

#[test]
fn bytes_take_a_state_to_another_instance() {
    for settings in scenario::choices() {
        let host = Host::initialized(&settings);
        half_way(&host);
        let bytes = host.bytes(host.keep());
        let other = Host::new(&settings);
        let state = other.keep_bytes(&bytes).unwrap();
        assert_eq!(unsafe { fmi2SetFMUstate(other.c, state) }, Status::Ok);
        assert_eq!(other.get("command_deg"), 35.0);
        assert_eq!(to_the_end(&other), to_the_end(&host));
    }
}

#[test]
fn bytes_of_another_model_and_garbage_are_refused() {
    let all: Vec<_> = scenario::choices().collect();
    let (one, other) = (Host::initialized(&all[0]), Host::initialized(&all[1]));
    let mut bytes = one.bytes(one.keep());
    let refused = other.keep_bytes(&bytes).unwrap_err();
    assert!(
        refused.ends_with("it is not a state of this FMU"),
        "{refused}"
    );
    bytes[100] ^= 1;
    assert!(one.keep_bytes(&bytes).unwrap_err().contains("damaged"));
    for garbage in [&[][..], &[0xa5; 10_000]] {
        assert!(one.keep_bytes(garbage).is_err());
    }
}

#[test]
fn a_state_that_is_not_kept_is_refused_whatever_its_pointer() {
    let host = Host::initialized(&scenario::choices().next().unwrap());
    let mut state = host.keep();
    let kept = state;
    // SAFETY: as above.
    unsafe {
        assert_eq!(fmi2GetFMUstate(host.c, &mut state), Status::Ok);
        assert_eq!(state, kept, "the same place is used again");
        assert_eq!(fmi2FreeFMUstate(host.c, &mut state), Status::Ok);
        assert_eq!(state, null_mut());
        assert_eq!(fmi2FreeFMUstate(host.c, &mut state), Status::Ok);
        for foreign in [kept, null_mut(), without_provenance_mut(0xdead_beef)] {
            assert_eq!(fmi2SetFMUstate(host.c, foreign), Status::Error);
            let mut size = 0;
            let status = fmi2SerializedFMUstateSize(host.c, foreign, &mut size);
            assert_eq!(status, Status::Error);
        }
        let mut foreign = without_provenance_mut(0xdead_beef);
        assert_eq!(fmi2GetFMUstate(host.c, &mut foreign), Status::Error);
        assert_eq!(fmi2FreeFMUstate(host.c, &mut foreign), Status::Error);
    }
    assert!(
        host.last_message()
            .contains("not one that this instance has saved")
    );
}
