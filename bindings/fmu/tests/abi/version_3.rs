//! The C interface of FMI 3.0 against that of FMI 2.0.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use actuator_fmu::{abi::*, description, variables};
use model_core::{actuator::Settings, scenario};

use super::{command_deg, host::Host};

type Messages = Mutex<Vec<String>>;

unsafe extern "C" fn log(
    environment: *mut c_void,
    _status: Status,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the pointer is from `instance`, and the strings live during the call.
    let (messages, category, message) = unsafe {
        (
            &*environment.cast::<Messages>(),
            CStr::from_ptr(category),
            CStr::from_ptr(message),
        )
    };
    assert_eq!(category, c"logStatusError");
    let message = message.to_str().unwrap().to_owned();
    messages.lock().unwrap().push(message);
}

fn instance(token: &str, has_events: bool, messages: &Messages) -> *mut Component {
    let token = CString::new(token).unwrap();
    // SAFETY: strings and messages live long enough.
    unsafe {
        fmi3InstantiateCoSimulation(
            c"host".as_ptr(),
            token.as_ptr(),
            null(),
            0,
            1,
            has_events.into(),
            0,
            null(),
            0,
            std::ptr::from_ref(messages).cast_mut().cast(),
            Some(log),
            None,
        )
    }
}

fn reference(settings: &Settings, name: &str) -> u32 {
    let variables = variables::of(settings);
    variables.iter().position(|v| v.name == name).unwrap() as u32
}

fn get(c: *mut Component, reference: u32) -> f64 {
    let mut value = f64::NAN;
    // SAFETY: one reference, one value.
    let status = unsafe { fmi3GetFloat64(c, &reference, 1, &mut value, 1) };
    assert_eq!(status, Status::Ok);
    value
}

fn step(c: *mut Component, point_s: f64, step_s: f64) -> (Status, f64) {
    let (mut flags, mut reached_s) = ([7_u8; 3], f64::NAN);
    let [events, ends, early] = &mut flags;
    // SAFETY: valid pointers.
    let status = unsafe { fmi3DoStep(c, point_s, step_s, 1, events, ends, early, &mut reached_s) };
    assert_eq!(flags, [0; 3]);
    (status, reached_s)
}

#[test]
fn both_versions_give_the_same_bits_for_every_model() {
    for settings in scenario::choices() {
        let messages = Messages::default();
        let c = instance(&description::guid(&settings), false, &messages);
        assert!(!c.is_null(), "{messages:?}");
        let two = Host::initialized(&settings);
        // SAFETY: a component that this thread uses alone, here and below.
        unsafe {
            assert_eq!(
                fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0),
                Status::Ok
            );
            assert_eq!(fmi3ExitInitializationMode(c), Status::Ok);
        }
        let (command, angle) = (
            reference(&settings, "command_deg"),
            reference(&settings, "angle_deg"),
        );
        for number in 0..50 {
            let (value, point_s) = (command_deg(number), f64::from(number) * 0.01);
            // SAFETY: one reference, one value.
            let set = unsafe { fmi3SetFloat64(c, &command, 1, &value, 1) };
            assert_eq!(set, Status::Ok);
            two.set("command_deg", value);
            let (status, reached_s) = step(c, point_s, 0.01);
            assert_eq!((status, reached_s), (Status::Ok, point_s + 0.01));
            assert_eq!(two.step(point_s, 0.01), Status::Ok);
            assert_eq!(get(c, angle).to_bits(), two.get("angle_deg").to_bits());
        }
        let time = variables::of(&settings).len() as u32;
        assert!((get(c, time) - 0.5).abs() < 1e-12);
        // SAFETY: as above; not used again.
        unsafe {
            assert_eq!(fmi3Terminate(c), Status::Ok);
            fmi3FreeInstance(c);
        }
    }
}

#[test]
fn a_saved_state_leads_back() {
    let settings = scenario::choices().next().unwrap();
    let messages = Messages::default();
    let c = instance(&description::guid(&settings), false, &messages);
    let angle = reference(&settings, "angle_deg");
    let mut state: FmuState = null_mut();
    // SAFETY: valid pointers; a component that this thread uses alone.
    unsafe {
        fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0);
        fmi3ExitInitializationMode(c);
        fmi3SetFloat64(c, &reference(&settings, "command_deg"), 1, &40.0, 1);
        step(c, 0.0, 0.1);
        assert_eq!(fmi3GetFMUState(c, &mut state), Status::Ok);
        step(c, 0.1, 0.1);
        let expected = get(c, angle);
        assert_eq!(fmi3SetFMUState(c, state), Status::Ok);
        step(c, 0.1, 0.1);
        assert_eq!(get(c, angle).to_bits(), expected.to_bits());
        assert_eq!(fmi3FreeFMUState(c, &mut state), Status::Ok);
        fmi3FreeInstance(c);
    }
}

#[test]
fn what_the_fmu_does_not_have_is_refused_with_a_reason() {
    let settings = scenario::choices().next().unwrap();
    let messages = Messages::default();
    let reported = || messages.lock().unwrap().last().cloned().unwrap_or_default();
    assert!(instance("{0}", false, &messages).is_null());
    assert!(
        reported().contains("does not belong to a model"),
        "{}",
        reported()
    );
    assert!(instance(&description::guid(&settings), true, &messages).is_null());
    assert!(reported().contains("no event mode"), "{}", reported());
    let c = instance(&description::guid(&settings), false, &messages);
    let two = [0.0; 2];
    // SAFETY: valid pointers; a component that this thread uses alone.
    unsafe {
        assert_eq!(fmi3EnterStepMode(c), Status::Error);
        assert!(reported().contains("fmi3EnterStepMode: there is no event mode"));
        assert_eq!(fmi3GetFloat32(c), Status::Error);
        assert!(reported().contains("no variable is of this type"));
        assert_eq!(fmi3SetFloat64(c, &0, 1, two.as_ptr(), 2), Status::Error);
        assert!(
            reported().contains("nValues is 2, expected 1"),
            "{}",
            reported()
        );
        assert_eq!(fmi3SetFloat64(c, null(), 1, two.as_ptr(), 1), Status::Error);
        assert!(
            reported().contains("valueReferences is null"),
            "{}",
            reported()
        );
        fmi3FreeInstance(c);
        fmi3FreeInstance(null_mut());
    }
}

/// Reports to a host, and when it requests an early end.
struct Updates {
    c: *mut Component,
    angle: u32,
    times_s: Vec<f64>,
    angles_deg: Vec<f64>,
    ask_at_s: f64,
    end_at_s: f64,
}

unsafe extern "C" fn update(
    environment: *mut c_void,
    time_s: f64,
    set_requested: Boolean3,
    get_allowed: Boolean3,
    finished: Boolean3,
    can_return_early: Boolean3,
    early_return: *mut Boolean3,
    early_time_s: *mut f64,
) {
    assert_eq!((set_requested, get_allowed, finished), (0, 1, 1));
    // SAFETY: the pointers are from the test and from `fmi3DoStep`.
    unsafe {
        let updates = &mut *environment.cast::<Updates>();
        updates.times_s.push(time_s);
        updates.angles_deg.push(get(updates.c, updates.angle));
        if time_s >= updates.ask_at_s {
            assert_eq!(can_return_early, 1);
            (*early_return, *early_time_s) = (1, updates.end_at_s);
        }
    }
}

/// A host with updates, initialized, with a command of 60 deg.
fn updated(settings: &Settings, is_early_allowed: bool, updates: &mut Updates) -> *mut Component {
    let token = CString::new(description::guid(settings)).unwrap();
    updates.angle = reference(settings, "angle_deg");
    // SAFETY: strings and updates live long enough; the component is used by this thread alone.
    unsafe {
        updates.c = fmi3InstantiateCoSimulation(
            c"host".as_ptr(),
            token.as_ptr(),
            null(),
            0,
            0,
            0,
            is_early_allowed.into(),
            &updates.angle,
            1,
            std::ptr::from_mut(updates).cast(),
            None,
            Some(update),
        );
        assert!(!updates.c.is_null());
        fmi3EnterInitializationMode(updates.c, 0, 0.0, 0.0, 0, 0.0);
        fmi3ExitInitializationMode(updates.c);
        fmi3SetFloat64(updates.c, &reference(settings, "command_deg"), 1, &60.0, 1);
    }
    updates.c
}

fn updates(ask_at_s: f64, end_at_s: f64) -> Updates {
    Updates {
        c: null_mut(),
        angle: 0,
        times_s: Vec::new(),
        angles_deg: Vec::new(),
        ask_at_s,
        end_at_s,
    }
}

fn step_early(c: *mut Component, point_s: f64, step_s: f64) -> (bool, f64) {
    let (mut flags, mut reached_s) = ([7_u8; 3], f64::NAN);
    let [events, ends, early] = &mut flags;
    // SAFETY: valid pointers.
    let status = unsafe { fmi3DoStep(c, point_s, step_s, 1, events, ends, early, &mut reached_s) };
    assert_eq!((status, flags[0], flags[1]), (Status::Ok, 0, 0));
    (flags[2] == 1, reached_s)
}

#[test]
fn a_long_step_tells_its_progress_and_gives_the_bits_of_short_ones() {
    for settings in scenario::choices() {
        for is_early_allowed in [false, true] {
            let mut reported = updates(f64::INFINITY, 0.0);
            let c = updated(&settings, is_early_allowed, &mut reported);
            assert_eq!(step_early(c, 0.0, 0.55), (false, 0.55));
            assert_eq!(reported.times_s.len(), 5);
            let host = Host::initialized(&settings);
            host.set("command_deg", 60.0);
            for (number, (time_s, angle_deg)) in reported
                .times_s
                .iter()
                .zip(&reported.angles_deg)
                .enumerate()
            {
                assert!((time_s - 0.1 * (number + 1) as f64).abs() < 1e-9);
                host.step(0.1 * number as f64, 0.1);
                assert_eq!(angle_deg.to_bits(), host.get("angle_deg").to_bits());
            }
            host.step(0.5, 0.05);
            assert_eq!(
                get(c, reported.angle).to_bits(),
                host.get("angle_deg").to_bits()
            );
            // SAFETY: not used again.
            unsafe { fmi3FreeInstance(c) };
        }
    }
}

#[test]
fn a_host_ends_a_step_early_now_or_at_a_later_time_and_goes_on_from_there() {
    let settings = scenario::choices().last().unwrap();
    // The requested time, and the one that is reached: one that has passed is now.
    for (end_at_s, reached_s) in [
        (0.0, 0.3),
        (0.3, 0.3),
        (f64::NAN, 0.3),
        (0.333, 0.333),
        (0.45, 0.45),
    ] {
        let mut reported = updates(0.25, end_at_s);
        let c = updated(&settings, true, &mut reported);
        let (is_early, last_s) = step_early(c, 0.0, 1e5);
        assert!(
            is_early && (last_s - reached_s).abs() < 1e-9,
            "{end_at_s} {last_s}"
        );
        reported.ask_at_s = f64::INFINITY;
        assert!(!step_early(c, last_s, 1.0 - last_s).0);
        let host = Host::initialized(&settings);
        host.set("command_deg", 60.0);
        host.step(0.0, 1.0);
        assert_eq!(
            get(c, reported.angle).to_bits(),
            host.get("angle_deg").to_bits()
        );
        // SAFETY: not used again.
        unsafe { fmi3FreeInstance(c) };
    }
    // An end after that of the step changes nothing.
    let mut reported = updates(0.25, 9.0);
    let c = updated(&settings, true, &mut reported);
    assert_eq!(step_early(c, 0.0, 0.5), (false, 0.5));
    // SAFETY: not used again.
    unsafe { fmi3FreeInstance(c) };
}

#[test]
fn a_host_that_wants_to_read_more_than_outputs_within_a_step_is_refused() {
    let settings = scenario::choices().next().unwrap();
    let variables = variables::of(&settings);
    for name in ["command_deg", "delay_s"] {
        let refused = variables::only_outputs(&variables, &[reference(&settings, name)]);
        assert!(refused.unwrap_err().contains(name));
    }
    assert!(variables::only_outputs(&variables, &[u32::MAX]).is_err());
    assert!(variables::only_outputs(&variables, &[reference(&settings, "rate_deg_s")]).is_ok());
}
