//! Model exchange: a host that integrates with a fixed step, against co-simulation.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use actuator_fmu::{abi::*, description, variables};
use model_core::actuator::Settings;
use model_core::scenario;

use super::command_deg;
use super::host::{Host, Messages, callbacks};

/// A host with a Runge-Kutta step.
struct Solver<'a> {
    c: *mut Component,
    settings: Settings,
    count: usize,
    messages: &'a Messages,
}

impl<'a> Solver<'a> {
    fn new(settings: &Settings, messages: &'a Messages) -> Option<Self> {
        let guid = CString::new(description::guid(settings)).unwrap();
        let callbacks = callbacks(messages);
        // SAFETY: strings and callbacks live long enough.
        let c = unsafe {
            fmi2Instantiate(
                c"host".as_ptr(),
                MODEL_EXCHANGE,
                guid.as_ptr(),
                null(),
                &callbacks,
                0,
                1,
            )
        };
        (!c.is_null()).then(|| Self {
            c,
            settings: *settings,
            count: variables::of(settings)
                .iter()
                .filter(|v| matches!(v.quantity, variables::Quantity::State(_)))
                .count(),
            messages,
        })
    }

    fn ok(&self, status: Status) {
        assert_eq!(status, Status::Ok, "{:?}", self.messages.lock());
    }

    fn initialize(&self) {
        // SAFETY: a component that this thread uses alone, here and below.
        unsafe {
            self.ok(fmi2SetupExperiment(self.c, 0, 0.0, 0.0, 0, 0.0));
            self.ok(fmi2EnterInitializationMode(self.c));
            self.ok(fmi2ExitInitializationMode(self.c));
        }
    }

    fn reference(&self, name: &str) -> u32 {
        let variables = variables::of(&self.settings);
        variables.iter().position(|v| v.name == name).unwrap() as u32
    }

    fn set(&self, name: &str, value: f64) -> Status {
        // SAFETY: one reference, one value.
        unsafe { fmi2SetReal(self.c, &self.reference(name), 1, &value) }
    }

    fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: as above.
        self.ok(unsafe { fmi2GetReal(self.c, &self.reference(name), 1, &mut value) });
        value
    }

    /// Processes an event; returns the time of the next one.
    fn update(&self) -> f64 {
        let mut info = EventInfo::default();
        // SAFETY: valid pointers.
        unsafe {
            self.ok(fmi2NewDiscreteStates(self.c, &mut info));
            self.ok(fmi2EnterContinuousTimeMode(self.c));
        }
        assert_eq!(info.new_discrete_states_needed, 0);
        match info.next_event_time_defined {
            0 => f64::INFINITY,
            _ => info.next_event_time,
        }
    }

    fn enter_event_mode(&self) {
        // SAFETY: as above.
        unsafe { self.ok(fmi2EnterEventMode(self.c)) };
    }

    fn states(&self) -> Vec<f64> {
        let mut states = vec![f64::NAN; self.count];
        // SAFETY: a place for as many values.
        self.ok(unsafe { fmi2GetContinuousStates(self.c, states.as_mut_ptr(), self.count) });
        states
    }

    fn derivatives(&self, time_s: f64, states: &[f64]) -> Vec<f64> {
        let mut derivatives = vec![f64::NAN; self.count];
        // SAFETY: as many values.
        unsafe {
            self.ok(fmi2SetTime(self.c, time_s));
            self.ok(fmi2SetContinuousStates(self.c, states.as_ptr(), self.count));
            self.ok(fmi2GetDerivatives(
                self.c,
                derivatives.as_mut_ptr(),
                self.count,
            ));
        }
        derivatives
    }

    /// A step; returns whether an event indicator is no longer positive.
    fn step(&self, time_s: f64, step_s: f64) -> bool {
        let start = self.states();
        let at = |slope: &[f64], share: f64| -> Vec<f64> {
            let moved = start.iter().zip(slope);
            moved.map(|(x, dx)| x + share * step_s * dx).collect()
        };
        let a = self.derivatives(time_s, &start);
        let b = self.derivatives(time_s + step_s / 2.0, &at(&a, 0.5));
        let c = self.derivatives(time_s + step_s / 2.0, &at(&b, 0.5));
        let d = self.derivatives(time_s + step_s, &at(&c, 1.0));
        let mean: Vec<f64> = (0..self.count)
            .map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0)
            .collect();
        let end = at(&mean, 1.0);
        let (mut event, mut ends, mut indicators) = (7, 7, vec![f64::NAN; 7]);
        let count = if self.count == 3 { 7 } else { 4 };
        // SAFETY: as many values.
        unsafe {
            self.ok(fmi2SetTime(self.c, time_s + step_s));
            self.ok(fmi2SetContinuousStates(self.c, end.as_ptr(), self.count));
            self.ok(fmi2CompletedIntegratorStep(
                self.c, 1, &mut event, &mut ends,
            ));
            self.ok(fmi2GetEventIndicators(
                self.c,
                indicators.as_mut_ptr(),
                count,
            ));
        }
        assert_eq!((event, ends), (0, 0));
        indicators[..count].iter().any(|z| *z <= 0.0)
    }
}

impl Drop for Solver<'_> {
    fn drop(&mut self) {
        // SAFETY: not used again.
        unsafe { fmi2FreeInstance(self.c) }
    }
}

/// The tick of co-simulation, s.
const STEP_S: f64 = 50e-6;

/// The greatest difference of the angle from co-simulation, deg, with a command every 20 ms.
fn greatest_difference(settings: &Settings, parameters: &[(&str, f64)], scale: f64) -> f64 {
    let messages = Messages::default();
    let solver = Solver::new(settings, &messages).unwrap();
    let cosimulation = Host::new(settings);
    for (name, value) in parameters {
        assert_eq!(solver.set(name, *value), Status::Ok);
        assert_eq!(cosimulation.set(name, *value), Status::Ok);
    }
    cosimulation.initialize(0.0);
    solver.initialize();
    let mut greatest = 0.0_f64;
    let mut next_event_s = 0.0;
    for tick in 0..20_000_u32 {
        let time_s = f64::from(tick) * STEP_S;
        if tick % 400 == 0 || next_event_s <= time_s + 1e-9 {
            if tick > 0 {
                solver.enter_event_mode();
            }
            let value = scale * command_deg(tick / 400);
            assert_eq!(solver.set("command_deg", value), Status::Ok);
            cosimulation.set("command_deg", value);
            next_event_s = solver.update();
        }
        if solver.step(time_s, STEP_S) {
            solver.enter_event_mode();
            next_event_s = solver.update();
        }
        assert_eq!(cosimulation.step(time_s, STEP_S), Status::Ok);
        let difference = solver.get("angle_deg") - cosimulation.get("angle_deg");
        greatest = greatest.max(difference.abs());
    }
    greatest
}

#[test]
fn a_host_that_integrates_with_the_step_of_co_simulation_finds_the_same_angle() {
    // Both take the same Runge-Kutta steps; a limit is left or reached within one of them: 350
    // deg/s times 50 us are 0.02 deg.
    for settings in
        scenario::choices().filter(|s| variables::of(s).iter().any(|v| v.name == "state_angle_deg"))
    {
        for period_s in [0.0, 0.015] {
            let host = ("host_period_s", period_s);
            let within = greatest_difference(&settings, &[host], 0.1);
            assert!(within < 0.02, "{settings:?} {within}");
            let stops = ("position_limit_deg", 30.0);
            let at_stops = greatest_difference(&settings, &[host, stops], 2.0);
            assert!(at_stops < 0.1, "{settings:?} {at_stops}");
        }
    }
}

#[test]
fn the_board_and_calls_in_the_wrong_phase_are_refused() {
    let messages = Messages::default();
    let reported = || messages.lock().unwrap().last().cloned().unwrap_or_default();
    let board = scenario::choices().last().unwrap();
    assert!(Solver::new(&board, &messages).is_none());
    assert!(reported().contains("not continuous"), "{}", reported());
    let settings = scenario::choices().next().unwrap();
    let solver = Solver::new(&settings, &messages).unwrap();
    let c = solver.c;
    let mut info = EventInfo::default();
    // SAFETY: valid pointers; a component that this thread uses alone.
    unsafe {
        assert_eq!(fmi2NewDiscreteStates(c, &mut info), Status::Error);
        assert_eq!(fmi2EnterContinuousTimeMode(c), Status::Error);
        solver.initialize();
        assert_eq!(fmi2DoStep(c, 0.0, 0.01, 1), Status::Error);
        assert_eq!(fmi2SetTime(c, 1.0), Status::Error);
        assert_eq!(fmi2EnterEventMode(c), Status::Error);
        assert_eq!(fmi2NewDiscreteStates(c, null_mut()), Status::Error);
        solver.update();
        assert_eq!(fmi2SetTime(c, f64::NAN), Status::Error);
        assert_eq!(fmi2SetContinuousStates(c, &f64::NAN, 1), Status::Discard);
        assert_eq!(fmi2SetContinuousStates(c, null(), 1), Status::Error);
        assert_eq!(
            fmi2SetContinuousStates(c, [0.0; 2].as_ptr(), 2),
            Status::Error
        );
        assert!(
            reported().contains("2 states, expected 1"),
            "{}",
            reported()
        );
        assert_eq!(fmi2GetDerivatives(c, &mut 0.0, 2), Status::Error);
        assert_eq!(fmi2Terminate(c), Status::Ok);
    }
    // Model exchange refuses a state of co-simulation.
    let host = Host::initialized(&settings);
    let bytes = host.bytes(host.keep());
    let mut state = null_mut();
    // SAFETY: a buffer of this size.
    let status = unsafe { fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), &mut state) };
    assert_eq!(status, Status::Error);
    assert!(
        reported().contains("for CoSimulation, expected ModelExchange"),
        "{}",
        reported()
    );
}

#[test]
fn a_saved_state_leads_back_with_the_commands_in_transit() {
    for settings in
        scenario::choices().filter(|s| variables::of(s).iter().any(|v| v.name == "state_angle_deg"))
    {
        let messages = Messages::default();
        let solver = Solver::new(&settings, &messages).unwrap();
        solver.initialize();
        solver.set("command_deg", 5.0);
        solver.update();
        solver.step(0.0, 0.01);
        solver.enter_event_mode();
        solver.set("command_deg", 20.0);
        assert!((solver.update() - 0.0275).abs() < 1e-12);
        let (mut state, mut size) = (null_mut(), 0);
        let run = || {
            solver.step(0.01, 0.0175);
            solver.enter_event_mode();
            solver.update();
            solver.step(0.0275, 0.01);
            solver.get("angle_deg").to_bits()
        };
        // SAFETY: valid pointers, and a buffer of the requested size.
        unsafe {
            solver.ok(fmi2GetFMUstate(solver.c, &mut state));
            solver.ok(fmi2SerializedFMUstateSize(solver.c, state, &mut size));
            let mut bytes = vec![0; size];
            solver.ok(fmi2SerializeFMUstate(
                solver.c,
                state,
                bytes.as_mut_ptr(),
                size,
            ));
            let expected = run();
            solver.ok(fmi2SetFMUstate(solver.c, state));
            assert_eq!(run(), expected);
            solver.ok(fmi2DeSerializeFMUstate(
                solver.c,
                bytes.as_ptr(),
                size,
                &mut state,
            ));
            solver.ok(fmi2SetFMUstate(solver.c, state));
            assert_eq!(run(), expected);
        }
    }
}
