//! How the CAN controller joins a bus, returns after bus-off, and orders its frames.

use crate::mocks::Port;
use canopen::CanFrame;
use drivers::can::{
    Activity, CanController, Mode, Overrun, TransmitQueues, receive, receive_checked,
};
use embedded_can::{Frame as _, Id, StandardId};
use heapless::spsc::{Producer, Queue};
use model_core::time::PWM_RATE_HZ;

const MS: u32 = PWM_RATE_HZ / 1000;

fn frame(id: u16) -> CanFrame {
    let id = Id::Standard(StandardId::new(id).expect("11 bits"));
    CanFrame::new(id, &[]).expect("no data")
}

struct Bench {
    controller: CanController<Port>,
    port: Port,
    process_data: Producer<'static, CanFrame, 17>,
    others: Producer<'static, CanFrame, 17>,
}

fn bench() -> Bench {
    let port = Port::default();
    let (process_data, queued_data) = Box::leak(Box::new(Queue::new())).split();
    let (others, queued) = Box::leak(Box::new(Queue::new())).split();
    let queues = TransmitQueues {
        process_data: queued_data,
        others: queued,
    };
    Bench {
        controller: CanController::new(port.clone(), 500, queues),
        port,
        process_data,
        others,
    }
}

impl Bench {
    fn mode(&self) -> Option<Mode> {
        self.port.0.borrow().joined.map(|(_, mode)| mode)
    }

    fn sees(&mut self, activity: Activity, period: u32) {
        self.port.0.borrow_mut().activity = Some(activity);
        self.controller.update(period);
    }

    fn goes_off(&mut self) {
        self.port.0.borrow_mut().is_off = true;
    }
}

#[test]
fn it_listens_until_a_valid_frame_or_a_quiet_time() {
    let mut bench = bench();
    assert_eq!(bench.mode(), Some(Mode::Listening));
    bench.sees(Activity::Error, 8 * MS);
    bench.sees(Activity::None, 17 * MS);
    assert_eq!(
        bench.mode(),
        Some(Mode::Listening),
        "an error restarts the time"
    );
    bench.sees(Activity::None, 18 * MS);
    assert_eq!(bench.mode(), Some(Mode::Full));

    let mut bench = self::bench();
    bench.sees(Activity::Frame, 1);
    assert_eq!(bench.mode(), Some(Mode::Full));
    assert_eq!(
        bench.port.0.borrow().joined.map(|(rate, _)| rate),
        Some(500)
    );
    bench.controller.set_bit_rate(125, 2);
    assert_eq!(bench.port.0.borrow().joined, Some((125, Mode::Listening)));
}

#[test]
fn the_time_off_the_bus_doubles_until_a_frame_is_transmitted() {
    let mut bench = bench();
    let mut period = 0;
    bench.sees(Activity::Frame, period);
    let mut back_off = |bench: &mut Bench| {
        bench.goes_off();
        assert!(bench.controller.update(period), "bus-off is told");
        let mut ms = 0;
        while bench.port.0.borrow().is_off {
            ms += 1;
            period += MS;
            assert!(!bench.controller.update(period), "bus-off is told once");
        }
        assert_eq!(bench.mode(), Some(Mode::Listening));
        // Nothing is heard.
        period += 10 * MS;
        bench.controller.update(period);
        assert_eq!(bench.mode(), Some(Mode::Full));
        ms
    };
    let times: Vec<u32> = (0..9).map(|_| back_off(&mut bench)).collect();
    assert_eq!(times, [10, 20, 40, 80, 160, 320, 640, 1280, 1280]);
    bench.others.enqueue(frame(1)).expect("room");
    bench.controller.fill_mailboxes();
    bench.port.0.borrow_mut().carry();
    assert_eq!(bench.controller.take_transmitted(), 1);
    assert_eq!(back_off(&mut bench), 10);
}

#[test]
fn other_frames_precede_process_data_which_alone_is_discarded() {
    let mut bench = bench();
    for id in 0x180..0x184 {
        bench.process_data.enqueue(frame(id)).expect("room");
    }
    bench.others.enqueue(frame(0x700)).expect("room");
    bench.controller.fill_mailboxes();
    let boxes = |bench: &Bench| bench.port.0.borrow().mailboxes;
    assert_eq!(
        boxes(&bench),
        [0x700, 0x180, 0x181].map(|id| Some(frame(id)))
    );
    assert_eq!(
        bench.controller.discard_process_data(),
        4,
        "two in mailboxes, two waiting"
    );
    assert_eq!(boxes(&bench), [Some(frame(0x700)), None, None]);
    assert_eq!(bench.controller.discard_process_data(), 0);
    // Mailboxes that held process data hold another frame now.
    bench.others.enqueue(frame(0x581)).expect("room");
    bench.controller.fill_mailboxes();
    assert_eq!(bench.controller.discard_process_data(), 0);
    assert_eq!(
        boxes(&bench),
        [Some(frame(0x700)), Some(frame(0x581)), None]
    );
}

#[test]
fn lost_frames_are_told_before_the_next_one() {
    let mut port = Port::default();
    port.0.borrow_mut().has_overrun = true;
    port.0.borrow_mut().received.push_back(frame(5));
    assert_eq!(receive(&mut port), Err(nb::Error::Other(Overrun)));
    assert_eq!(receive(&mut port), Ok(frame(5)));
    assert_eq!(receive(&mut port), Err(nb::Error::WouldBlock));
}

#[test]
fn a_frame_whose_two_readings_differ_in_any_bit_is_not_intact() {
    let read = |disturbance| {
        let mut port = Port::default();
        port.0.borrow_mut().received.push_back(frame(5));
        port.0.borrow_mut().disturbance = disturbance;
        receive_checked(&mut port).unwrap().intact::<Port>()
    };
    assert_eq!(read([0; 4]), Some(frame(5)));
    for bit in 0..128 {
        let mut disturbance = [0; 4];
        disturbance[bit / 32] = 1 << (bit % 32);
        assert_eq!(read(disturbance), None, "bit {bit}");
    }
}
