//! Everything that a host can do wrong without breaking the rules of C.

use std::ffi::{CStr, CString, c_char};
use std::ptr::{null, null_mut};

use actuator_fmu::{abi::*, description};
use model_core::scenario;

use crate::host::{Host, Messages, callbacks};

fn bench() -> Host {
    Host::initialized(&scenario::choices().last().unwrap())
}

/// The message of a refused instantiation.
fn refused(
    name: *const c_char,
    kind: i32,
    guid: *const c_char,
    resources: Option<&CStr>,
) -> String {
    let messages = Messages::default();
    let callbacks = callbacks(&messages);
    let resources = resources.map_or(null(), CStr::as_ptr);
    // SAFETY: null, or strings that live long enough.
    let c = unsafe { fmi2Instantiate(name, kind, guid, resources, &callbacks, 0, 0) };
    assert!(c.is_null());
    messages.into_inner().unwrap().concat()
}

#[test]
fn an_instantiation_that_does_not_fit_gives_null_and_says_why() {
    let settings = scenario::choices().next().unwrap();
    let guid = CString::new(description::guid(&settings)).unwrap();
    let (name, guid) = (c"host".as_ptr(), guid.as_ptr());
    let wrong = c"{8c4e810f-3df3-4a00-8276-176fa3c9f000}".as_ptr();
    let message = refused(name, CO_SIMULATION, wrong, None);
    assert!(
        message.contains("{8c4e810f-3df3-4a00-8276-176fa3c9f000}"),
        "{message}"
    );
    assert!(refused(name, CO_SIMULATION, wrong, Some(c"file:///nowhere")).contains("nowhere"));
    assert!(refused(name, CO_SIMULATION, null(), None).contains("fmuGUID is null"));
    assert!(refused(name, 2, guid, None).contains("fmuType is 2, expected 0 or 1"));
    // SAFETY: null is allowed.
    unsafe {
        assert!(fmi2Instantiate(name, 1, guid, null(), null(), 0, 0).is_null());
        fmi2FreeInstance(null_mut());
    }
}

#[test]
fn calls_out_of_order_are_refused_and_change_nothing() {
    let host = Host::new(&scenario::choices().next().unwrap());
    let c = host.c;
    // SAFETY: a component in use by this thread alone, here and below.
    unsafe {
        assert_eq!(fmi2DoStep(c, 0.0, 0.01, 1), Status::Error);
        assert_eq!(
            host.last_message(),
            "Error fmi2DoStep: not allowed in phase Instantiated, expected [Stepping]"
        );
        assert_eq!(fmi2ExitInitializationMode(c), Status::Error);
        assert_eq!(fmi2Terminate(c), Status::Error);
        assert_eq!(fmi2GetReal(c, &0, 1, &mut 0.0), Status::Error);
        host.initialize(0.0);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Error);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Error);
        assert_eq!(host.step(0.0, 0.01), Status::Ok);
        assert_eq!(fmi2Terminate(c), Status::Ok);
        assert_eq!(host.step(0.01, 0.01), Status::Error);
        assert_eq!(host.set("command_deg", 1.0), Status::Error);
        assert_eq!(host.get("command_deg"), 0.0);
        assert_eq!(fmi2Reset(c), Status::Ok);
    }
    host.initialize(0.0);
    assert_eq!(host.step(0.0, 0.01), Status::Ok);
}

#[test]
fn a_value_that_is_no_number_is_refused_by_the_name_of_its_variable() {
    let host = bench();
    for (name, value) in [
        ("command_deg", f64::NAN),
        ("command_deg", f64::INFINITY),
        ("load_torque_nm", f64::NEG_INFINITY),
        ("angle_deg", 1.0),
        ("delay_s", 1.0),
    ] {
        assert_eq!(host.set(name, value), Status::Error);
        assert!(
            host.last_message().contains(name),
            "{}",
            host.last_message()
        );
    }
    assert_eq!(host.get("command_deg"), 0.0);
}

#[test]
fn of_several_values_all_are_taken_or_none() {
    let host = Host::new(&scenario::choices().last().unwrap());
    let references = ["position_gain", "delay_s"].map(|name| host.reference(name));
    // SAFETY: two references, two values.
    let status = unsafe { fmi2SetReal(host.c, references.as_ptr(), 2, [9.0, -1.0].as_ptr()) };
    assert_eq!(status, Status::Error);
    assert!(
        host.last_message().contains("delay_s is -1"),
        "{}",
        host.last_message()
    );
    host.initialize(0.0);
    assert_eq!(host.get("position_gain"), 8.0);
}

#[test]
fn parameters_at_odds_keep_the_initialization_from_ending_until_mended() {
    let host = bench();
    // SAFETY: as above.
    unsafe {
        fmi2Reset(host.c);
        fmi2EnterInitializationMode(host.c);
        host.set("position_min_deg", 10.0);
        host.set("position_max_deg", -10.0);
        assert_eq!(fmi2ExitInitializationMode(host.c), Status::Error);
        assert!(
            host.last_message().contains("position_m"),
            "{}",
            host.last_message()
        );
        host.set("position_max_deg", 20.0);
        assert_eq!(fmi2ExitInitializationMode(host.c), Status::Ok);
    }
}

#[test]
fn a_step_that_is_no_time_is_refused_and_takes_none() {
    let host = bench();
    for step_s in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e300] {
        assert_eq!(host.step(0.0, step_s), Status::Error);
        assert!(host.last_message().contains("communicationStepSize"));
    }
    for point_s in [0.01, -0.01, f64::NAN, f64::INFINITY] {
        assert_eq!(host.step(point_s, 0.01), Status::Error);
        assert!(host.last_message().contains("currentCommunicationPoint"));
    }
    assert_eq!(host.step(0.0, 0.01), Status::Ok);
}

#[test]
fn no_step_leads_beyond_the_stop_time() {
    let host = Host::new(&scenario::choices().next().unwrap());
    // SAFETY: as above.
    unsafe {
        assert_eq!(
            fmi2SetupExperiment(host.c, 0, 0.0, 1.0, 1, 0.5),
            Status::Error
        );
        assert_eq!(
            fmi2SetupExperiment(host.c, 0, 0.0, f64::NAN, 0, 0.0),
            Status::Error
        );
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 1.0, 1, 1.5), Status::Ok);
        fmi2EnterInitializationMode(host.c);
        fmi2ExitInitializationMode(host.c);
    }
    assert_eq!(host.step(1.0, 0.5), Status::Ok);
    assert_eq!(host.step(1.5, 0.001), Status::Error);
}

#[test]
fn references_and_types_that_are_none_and_null_pointers_are_refused() {
    let host = bench();
    let c = host.c;
    let seed = host.reference("seed");
    // SAFETY: counts fit the pointers, or the pointers are null.
    unsafe {
        assert_eq!(fmi2GetReal(c, &u32::MAX, 1, &mut 0.0), Status::Error);
        assert!(host.last_message().contains("4294967295"));
        assert_eq!(fmi2GetReal(c, &seed, 1, &mut 0.0), Status::Error);
        assert_eq!(fmi2GetInteger(c, &0, 1, &mut 0), Status::Error);
        assert_eq!(fmi2GetInteger(c, &seed, 1, &mut 0), Status::Ok);
        assert_eq!(fmi2GetReal(c, null(), 1, &mut 0.0), Status::Error);
        assert_eq!(fmi2GetReal(c, &0, 1, null_mut()), Status::Error);
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), Status::Ok);
        assert_eq!(fmi2SetReal(c, &0, usize::MAX, &0.0), Status::Error);
        assert_eq!(fmi2GetString(c, &0, 1, null_mut()), Status::Error);
        assert_eq!(fmi2GetFMUstate(c, null_mut()), Status::Error);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, null()), Status::Error);
        assert_eq!(
            fmi2SetDebugLogging(c, 1, 1, &c"logAll".as_ptr()),
            Status::Error
        );
        assert_eq!(
            fmi2SetDebugLogging(c, 1, 1, &c"logStatusError".as_ptr()),
            Status::Ok
        );
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 0.01, 1), Status::Error);
        assert_eq!(fmi2CancelStep(c), Status::Error);
        assert_eq!(fmi2GetStatus(c, 0, null_mut()), Status::Discard);
        assert_eq!(
            fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, null_mut()),
            Status::Error
        );
    }
}

#[test]
fn the_seed_and_the_switching_are_parameters_of_their_own_types() {
    let host = Host::new(&scenario::choices().last().unwrap());
    let (seed, switched) = (host.reference("seed"), host.reference("pwm_switched"));
    let (mut integer, mut boolean) = (0, 0);
    // SAFETY: one reference, one value.
    unsafe {
        assert_eq!(fmi2SetInteger(host.c, &seed, 1, &-1), Status::Error);
        assert_eq!(fmi2SetInteger(host.c, &seed, 1, &7), Status::Ok);
        assert_eq!(fmi2SetBoolean(host.c, &switched, 1, &2), Status::Ok);
        host.initialize(0.0);
        assert_eq!(fmi2SetInteger(host.c, &seed, 1, &8), Status::Error);
        assert_eq!(fmi2GetInteger(host.c, &seed, 1, &mut integer), Status::Ok);
        assert_eq!(
            fmi2GetBoolean(host.c, &switched, 1, &mut boolean),
            Status::Ok
        );
    }
    assert_eq!((integer, boolean), (7, 1));
}

#[test]
fn the_greatest_numbers_there_are_leave_numbers() {
    for settings in scenario::choices() {
        let host = Host::initialized(&settings);
        host.set("command_deg", f64::MAX);
        if settings == scenario::choices().last().unwrap() {
            host.set("load_torque_nm", -f64::MAX);
        }
        assert_eq!(host.step(0.0, 0.05), Status::Ok);
        assert!(
            host.outputs()
                .iter()
                .all(|bits| f64::from_bits(*bits).is_finite())
        );
    }
}
