use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};

use super::{
    values::{EXCITATION, SIGNALS, TRIGGER},
    *,
};
use crate::{
    application::{BoardState, Outputs, Samples},
    capture::Phase,
    faults::Fault,
};

/// A board and who serves it.
struct Bench<'a> {
    service: Service,
    application: Application,
    capture: Capture<'a>,
}

impl<'a> Bench<'a> {
    fn new(buffer: &'a mut [i32]) -> Self {
        let mut bench = Self {
            service: Service::default(),
            application: Application::new(BoardParameters::DEFAULT),
            capture: Capture::new(buffer),
        };
        bench.step();
        bench
    }

    fn step(&mut self) -> Outputs {
        let word = EncoderWord::of(EncoderCount::new(0), Magnet::Steady);
        let outputs = self.application.step(&Samples::at_rest(word));
        self.capture.sample(&outputs);
        outputs
    }

    fn order(&mut self, order: Order) -> Served {
        let message = Message::Command {
            order: Some(order),
            angle: None,
        };
        let served = self
            .service
            .serve(&mut self.application, &mut self.capture, &message);
        // As the background of a board does.
        if served.start {
            let run = self.service.excitation().run().expect("in their ranges");
            self.application
                .start_excitation(run)
                .expect("the loop is closed");
        }
        served
    }

    fn access(&mut self, operation: Operation, number: u8, index: u16, value: u32) -> Option<u32> {
        let access = Access {
            operation,
            number,
            index,
            value,
        };
        let served = self.service.serve(
            &mut self.application,
            &mut self.capture,
            &Message::Access(access),
        );
        let (answer, is_refused) = served.answer.expect("an answer");
        assert_eq!((answer.operation, answer.number), (operation, number));
        (!is_refused).then_some(answer.value)
    }

    fn read(&mut self, number: u8) -> Option<u32> {
        self.access(Operation::Read, number, 0, 0)
    }

    fn write(&mut self, number: u8, value: u32) -> Option<u32> {
        self.access(Operation::Write, number, 0, value)
    }
}

#[test]
fn a_parameter_is_written_read_and_in_force() {
    let mut bench = Bench::new(&mut []);
    let node_id = BoardParameters::number_of("node_id").unwrap();
    assert_eq!(bench.write(node_id, 7), Some(7));
    assert_eq!(bench.application.parameters().bus.node_id, 7);
    assert_eq!(bench.write(0, 12.5_f32.to_bits()), Some(12.5_f32.to_bits()));
    assert_eq!(bench.write(0, f32::NAN.to_bits()), None);
    assert_eq!(bench.write(node_id, 128), None);
    assert_eq!(bench.read(node_id), Some(7));
    assert_eq!(bench.read(BoardParameters::COUNT), None);
    bench.order(Order::RestoreDefaults);
    assert_eq!(bench.read(node_id), Some(1));
    assert!(bench.order(Order::SaveParameters).save);
}

#[test]
fn protection_limits_and_identity_stay_while_the_bridge_is_driven_and_gains_do_not() {
    let mut bench = Bench::new(&mut []);
    bench.order(Order::Application(Request::Enable));
    assert_eq!(bench.application.state(), BoardState::Enabled);
    for name in ["node_id", "over_current_ma", "stall_ms"] {
        let number = BoardParameters::number_of(name).unwrap();
        let value = bench.read(number).unwrap();
        assert_eq!(bench.write(number, value + 1), None, "{name}");
        assert_eq!(bench.read(number), Some(value));
    }
    let gain = 9.0_f32.to_bits();
    assert_eq!(bench.write(0, gain), Some(gain));
}

#[test]
fn an_excitation_is_set_started_recorded_and_read_out() {
    let mut buffer = [0; 40];
    let mut bench = Bench::new(&mut buffer);
    bench.order(Order::Application(Request::Enable));
    // A pulse of 1 deg for 8 ms.
    for (row, value) in [(0, 0), (1, 1000), (5, 8)] {
        assert_eq!(bench.write(EXCITATION + row, value), Some(value));
    }
    // The command alone, from the excitation on.
    assert_eq!(bench.write(SIGNALS, 5), Some(5));
    assert_eq!(bench.write(SIGNALS + 1, 255), Some(255));
    assert_eq!(bench.write(TRIGGER, 1), Some(1));
    bench.order(Order::StartCapture);
    bench.step();
    assert_eq!(bench.read(192), Some(Phase::Armed as u32));
    bench.order(Order::StartExcitation);
    for _ in 0..20 {
        bench.step();
    }
    bench.order(Order::StopCapture);
    assert_eq!(bench.read(192), Some(Phase::Full as u32));
    assert_eq!((bench.read(193), bench.read(194)), (Some(20), Some(1)));
    let values = [0, 1, 2, 3].map(|index| bench.access(Operation::ReadCapture, 0, index, 0));
    assert_eq!(values, [Some(1000), Some(1000), Some(0), Some(0)]);
    assert_eq!(bench.access(Operation::ReadCapture, 0, 20, 0), None);
}

#[test]
fn settings_out_of_their_range_are_refused() {
    let mut bench = Bench::new(&mut []);
    for (number, value) in [
        (EXCITATION, 10),
        (EXCITATION + 10, 0),
        (SIGNALS, 254),
        (168, 0),
        (168, 1 << 16),
        (TRIGGER, 3),
        (170, 1 << 16),
        (192, 0),
        (250, 0),
    ] {
        assert_eq!(bench.write(number, value), None, "{number}");
    }
    assert_eq!(bench.service, Service::default());
}

#[test]
fn the_history_of_faults_is_read_the_last_one_first() {
    let mut bench = Bench::new(&mut []);
    let word = EncoderWord::of(EncoderCount::new(0), Magnet::Steady);
    let mut samples = Samples::at_rest(word);
    samples.bridge_tripped = true;
    bench.application.step(&samples);
    let number = u32::from(Fault::BridgeTripped.number());
    assert_eq!(bench.read(195), Some(1 << number));
    // Latched in the second control period.
    let record = bench.access(Operation::ReadHistory, 0, 0, 0);
    assert_eq!(record, Some(number << 16 | 2));
    assert_eq!(bench.access(Operation::ReadHistory, 0, 1, 0), None);
}

#[test]
fn the_cause_of_the_reset_and_a_starved_watchdog_are_told() {
    let mut bench = Bench::new(&mut []);
    bench.service = Service::after(ResetCause::Watchdog);
    bench.service.note_starved(5);
    let told = (ResetCause::Watchdog as u32, 5);
    assert_eq!(
        (bench.read(198), bench.read(199)),
        (Some(told.0), Some(told.1))
    );
    assert_eq!(bench.write(198, 0), None);
}
