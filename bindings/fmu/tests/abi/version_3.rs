//! The C interface of FMI 3.0 against that of FMI 2.0.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use actuator_fmu::{abi::*, abi3::*, description, variables};
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
            null(),
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
    let told = || messages.lock().unwrap().last().cloned().unwrap_or_default();
    assert!(instance("{0}", false, &messages).is_null());
    assert!(told().contains("does not belong to a model"), "{}", told());
    assert!(instance(&description::guid(&settings), true, &messages).is_null());
    assert!(told().contains("no event mode"), "{}", told());
    let c = instance(&description::guid(&settings), false, &messages);
    let two = [0.0; 2];
    // SAFETY: valid pointers; a component that this thread uses alone.
    unsafe {
        assert_eq!(fmi3EnterEventMode(c), Status::Error);
        assert!(told().contains("fmi3EnterEventMode: there is no event mode"));
        assert_eq!(fmi3GetFloat32(c), Status::Error);
        assert!(told().contains("no variable is of this type"));
        assert_eq!(fmi3SetFloat64(c, &0, 1, two.as_ptr(), 2), Status::Error);
        assert!(told().contains("nValues is 2, expected 1"), "{}", told());
        assert_eq!(fmi3SetFloat64(c, null(), 1, two.as_ptr(), 1), Status::Error);
        assert!(told().contains("valueReferences is null"), "{}", told());
        fmi3FreeInstance(c);
        fmi3FreeInstance(null_mut());
    }
}
