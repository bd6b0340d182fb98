extern crate std;

use std::vec::Vec;

use model_core::{
    control::encoder_word::{EncoderCount, EncoderWord, Magnet},
    excitation::{Excitation, multistep::Multistep},
};

use super::*;
use crate::{
    application::{Request, Samples, tests::Configured},
    command::excitation::Run,
    faults::Fault,
    parameters::BoardParameters,
};

const ONE_SIGNAL: CaptureSettings = CaptureSettings {
    signals: [Some(Signal::Tick), None, None, None, None, None, None, None],
    ..CaptureSettings::DEFAULT
};

fn word() -> EncoderWord {
    EncoderWord::of(EncoderCount::new(0), Magnet::Steady)
}

/// Outputs whose tick is this.
fn outputs(tick: u32) -> Outputs {
    let mut application = Configured::new(BoardParameters::DEFAULT);
    let mut outputs = application.control_period(&Samples::at_rest(word()));
    outputs.telemetry.tick = tick;
    outputs
}

fn values(capture: &Capture<'_>) -> Vec<i32> {
    (0..capture.count())
        .map(|record| capture.value(record, 0).unwrap())
        .collect()
}

#[test]
fn without_a_trigger_it_records_until_the_buffer_is_full() {
    let mut buffer = [0; 5];
    let mut capture = Capture::new(&mut buffer);
    capture.sample(&outputs(99));
    assert_eq!((capture.phase(), capture.count()), (Phase::Idle, 0));
    capture.arm(ONE_SIGNAL);
    for tick in 0..9 {
        capture.sample(&outputs(tick));
    }
    assert_eq!(capture.phase(), Phase::Full);
    assert_eq!(values(&capture), [0, 1, 2, 3, 4]);
}

#[test]
fn every_third_period_is_a_record_with_a_decimation_of_three() {
    let mut buffer = [0; 3];
    let mut capture = Capture::new(&mut buffer);
    capture.arm(CaptureSettings {
        decimation: 3,
        ..ONE_SIGNAL
    });
    for tick in 0..20 {
        capture.sample(&outputs(tick));
    }
    assert_eq!(values(&capture), [0, 3, 6]);
}

#[test]
fn records_from_before_a_fault_are_kept() {
    for (waits, expected) in [(10, [8, 9, 10, 11, 12]), (2, [0, 1, 2, 3, 4])] {
        let mut buffer = [0; 5];
        let mut capture = Capture::new(&mut buffer);
        capture.arm(CaptureSettings {
            trigger: Trigger::Fault,
            before: 2,
            ..ONE_SIGNAL
        });
        for tick in 0..waits {
            capture.sample(&outputs(tick));
            assert_eq!(capture.phase(), Phase::Armed);
        }
        for tick in waits..20 {
            let mut outputs = outputs(tick);
            outputs.fault = Some(Fault::Stall);
            capture.sample(&outputs);
        }
        assert_eq!(values(&capture), expected);
    }
}

#[test]
fn a_fault_present_at_the_start_does_not_trigger_and_pre_trigger_records_may_be_incomplete() {
    let mut buffer = [0; 5];
    let mut capture = Capture::new(&mut buffer);
    let faulty = |tick, fault| {
        let mut outputs = outputs(tick);
        outputs.fault = fault;
        outputs
    };
    capture.sample(&faulty(9, Some(Fault::Stall)));
    capture.arm(CaptureSettings {
        trigger: Trigger::Fault,
        before: u16::MAX,
        ..ONE_SIGNAL
    });
    capture.sample(&faulty(0, Some(Fault::Stall)));
    assert_eq!(capture.phase(), Phase::Armed);
    capture.sample(&faulty(1, None));
    capture.sample(&faulty(2, Some(Fault::Stall)));
    // Of five records four may come from before the trigger, of which there were two.
    assert_eq!(capture.phase(), Phase::Full);
    assert_eq!(values(&capture), [0, 1, 2]);
}

#[test]
fn the_first_record_after_the_trigger_is_tick_0_of_the_excitation() {
    let mut buffer = [0; 20];
    let mut capture = Capture::new(&mut buffer);
    let mut settings = CaptureSettings {
        trigger: Trigger::Excitation,
        decimation: 7,
        ..ONE_SIGNAL
    };
    settings.signals[0] = Some(Signal::Command);
    capture.arm(settings);
    let mut application = Configured::new(BoardParameters::DEFAULT);
    capture.sample(&application.control_period(&Samples::at_rest(word())));
    application.request(Request::Enable).unwrap();
    for _ in 0..5 {
        capture.sample(&application.control_period(&Samples::at_rest(word())));
    }
    assert_eq!(capture.phase(), Phase::Armed);
    let pulse = Multistep::try_pulse(&model_core::excitation::multistep::PulseParameters {
        amplitude_deg: 2.0,
        start_s: 0.0,
        end_s: 0.05,
    });
    let run = Run::new(Excitation::Multistep(pulse.unwrap()), 1);
    application.start_excitation(run).unwrap();
    for _ in 0..30 {
        capture.sample(&application.control_period(&Samples::at_rest(word())));
    }
    // 50 ms are 12.5 control periods.
    assert_eq!(&values(&capture)[..4], [2000, 2000, 0, 0]);
}

#[test]
fn it_is_read_in_pieces_of_any_size() {
    let mut buffer = [0; 13];
    let mut capture = Capture::new(&mut buffer);
    let mut settings = ONE_SIGNAL;
    settings.signals[1] = Some(Signal::Supply);
    capture.arm(settings);
    for tick in 0..6 {
        capture.sample(&outputs(tick));
    }
    assert_eq!((capture.capacity(), capture.width()), (6, 2));
    let all: Vec<i32> = (0..6).flat_map(|tick| [tick, 5998]).collect();
    for size in 1..20 {
        let (mut read, mut piece) = (Vec::new(), std::vec![0; size]);
        loop {
            let count = capture.read(read.len(), &mut piece);
            if count == 0 {
                break;
            }
            read.extend_from_slice(&piece[..count]);
        }
        assert_eq!(read, all);
    }
}

#[test]
fn without_capacity_or_signals_it_is_full_at_once() {
    let mut buffer = [0; 5];
    let mut capture = Capture::new(&mut buffer);
    capture.arm(CaptureSettings::DEFAULT);
    capture.sample(&outputs(0));
    assert_eq!((capture.phase(), capture.count()), (Phase::Full, 0));
    capture.arm(CaptureSettings {
        signals: [None; MAX_SIGNALS],
        ..CaptureSettings::DEFAULT
    });
    capture.sample(&outputs(0));
    assert_eq!((capture.phase(), capture.value(0, 0)), (Phase::Full, None));
}

#[test]
fn every_signal_is_found_by_its_number() {
    for (index, &signal) in Signal::ALL.iter().enumerate() {
        assert_eq!(Signal::of_number(index as u8), Some(signal));
        assert_eq!(signal as usize, index);
        let _ = signal.of(&outputs(7));
    }
}
