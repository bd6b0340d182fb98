//! A host that uses the C interface as C would.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use actuator_fmu::{abi::*, description, variables};
use model_core::actuator::Settings;

/// The messages to the logger, by instance.
pub type Messages = Mutex<Vec<String>>;

/// Without its variable arguments, which no message has: the calling convention of variadic
/// functions is that of others for fixed arguments on all platforms where tests run.
unsafe extern "C" fn log(
    environment: *mut c_void,
    name: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the pointer is from `Host`, and the strings live during the call.
    let (messages, [name, category, message]) = unsafe {
        (
            &*environment.cast::<Messages>(),
            [name, category, message].map(|text| CStr::from_ptr(text).to_str().unwrap()),
        )
    };
    assert_eq!((name, category), ("host", "logStatusError"));
    messages
        .lock()
        .unwrap()
        .push(format!("{status:?} {message}"));
}

pub fn callbacks(messages: &Messages) -> CallbackFunctions {
    // SAFETY: see `log`.
    let logger = unsafe {
        std::mem::transmute::<
            unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char),
            Logger,
        >(log)
    };
    CallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: std::ptr::from_ref(messages).cast_mut().cast(),
    }
}

/// An instance and its messages.
pub struct Host {
    pub c: *mut Component,
    names: Vec<&'static str>,
    messages: Box<Messages>,
}

impl Host {
    pub fn new(settings: &Settings) -> Self {
        let messages = Box::<Messages>::default();
        let guid = CString::new(description::guid(settings)).unwrap();
        let callbacks = callbacks(&messages);
        // SAFETY: strings and callbacks live long enough.
        let c = unsafe {
            fmi2Instantiate(
                c"host".as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                null(),
                &callbacks,
                0,
                1,
            )
        };
        assert!(!c.is_null(), "{:?}", messages.lock());
        let names = variables::of(settings).iter().map(|v| v.name).collect();
        Self { c, names, messages }
    }

    /// One that is ready to step.
    pub fn initialized(settings: &Settings) -> Self {
        let host = Self::new(settings);
        host.initialize(0.0);
        host
    }

    pub fn initialize(&self, start_s: f64) {
        // SAFETY: a component in use by this thread alone, here and in all that follows.
        unsafe {
            assert_eq!(
                fmi2SetupExperiment(self.c, 0, 0.0, start_s, 0, 0.0),
                Status::Ok
            );
            assert_eq!(fmi2EnterInitializationMode(self.c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(self.c), Status::Ok);
        }
    }

    pub fn reference(&self, name: &str) -> u32 {
        self.names.iter().position(|n| *n == name).unwrap() as u32
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        // SAFETY: one reference, one value.
        unsafe { fmi2SetReal(self.c, &self.reference(name), 1, &value) }
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: one reference, one value.
        let status = unsafe { fmi2GetReal(self.c, &self.reference(name), 1, &mut value) };
        assert_eq!(status, Status::Ok, "{}", self.last_message());
        value
    }

    /// The outputs that every model has, as bits.
    pub fn outputs(&self) -> [u64; 5] {
        [
            "angle_deg",
            "rate_deg_s",
            "duty_pct",
            "angle_meas_deg",
            "rate_meas_deg_s",
        ]
        .map(|name| self.get(name).to_bits())
    }

    pub fn step(&self, point_s: f64, step_s: f64) -> Status {
        // SAFETY: a component in use by this thread alone.
        unsafe { fmi2DoStep(self.c, point_s, step_s, 1) }
    }

    pub fn keep(&self) -> FmuState {
        let mut state = null_mut();
        // SAFETY: a place for a state.
        assert_eq!(unsafe { fmi2GetFMUstate(self.c, &mut state) }, Status::Ok);
        state
    }

    pub fn bytes(&self, state: FmuState) -> Vec<u8> {
        let mut size = 0;
        // SAFETY: valid pointers to the size, then to a buffer of this size.
        unsafe {
            assert_eq!(
                fmi2SerializedFMUstateSize(self.c, state, &mut size),
                Status::Ok
            );
            let mut bytes = vec![0; size];
            let status = fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr(), size);
            assert_eq!(status, Status::Ok);
            bytes
        }
    }

    pub fn keep_bytes(&self, bytes: &[u8]) -> Result<FmuState, String> {
        let mut state = null_mut();
        // SAFETY: valid pointers to a buffer of this size and to a state.
        let status =
            unsafe { fmi2DeSerializeFMUstate(self.c, bytes.as_ptr(), bytes.len(), &mut state) };
        match status {
            Status::Ok => Ok(state),
            _ => Err(self.last_message()),
        }
    }

    pub fn last_message(&self) -> String {
        self.messages
            .lock()
            .unwrap()
            .last()
            .cloned()
            .unwrap_or_default()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: not used again.
        unsafe { fmi2FreeInstance(self.c) }
    }
}
