//! How the CAN controller joins a bus, returns after bus-off, and orders its frames.

use std::{cell::RefCell, collections::VecDeque, rc::Rc};

use crate::mocks::Port;
use canopen::CanFrame;
use drivers::can::{Activity, CanController, Mode, Overrun, TransmitQueues, receive};
use embedded_can::{Frame as _, Id, StandardId};
use model_core::time::UPDATE_RATE_HZ;

const MS: u32 = UPDATE_RATE_HZ / 1000;

fn frame(id: u16) -> CanFrame {
    let id = Id::Standard(StandardId::new(id).expect("11 bits"));
    CanFrame::new(id, &[]).expect("no data")
}

/// The queues of the frames to be transmitted, which the test fills.
#[derive(Clone, Default)]
struct Queues {
    process_data: Rc<RefCell<VecDeque<CanFrame>>>,
    others: Rc<RefCell<VecDeque<CanFrame>>>,
}

impl TransmitQueues for Queues {
    fn next_process_data(&mut self) -> Option<CanFrame> {
        self.process_data.borrow_mut().pop_front()
    }

    fn next_other(&mut self) -> Option<CanFrame> {
        self.others.borrow_mut().pop_front()
    }
}

struct Bench {
    controller: CanController<Port, Queues>,
    port: Port,
    queues: Queues,
}

fn bench() -> Bench {
    let (port, queues) = (Port::default(), Queues::default());
    Bench {
        controller: CanController::new(port.clone(), 500, queues.clone()),
        port,
        queues,
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
        assert!(bench.controller.update(period), "bus-off is reported");
        let mut ms = 0;
        while bench.port.0.borrow().is_off {
            ms += 1;
            period += MS;
            assert!(!bench.controller.update(period), "bus-off is reported once");
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
    bench.queues.others.borrow_mut().push_back(frame(1));
    bench.controller.fill_mailboxes();
    bench.port.0.borrow_mut().carry();
    assert_eq!(bench.controller.take_transmitted(), 1);
    assert_eq!(back_off(&mut bench), 10);
}

#[test]
fn other_frames_precede_process_data_which_alone_is_discarded() {
    let mut bench = bench();
    for id in 0x180..0x184 {
        bench.queues.process_data.borrow_mut().push_back(frame(id));
    }
    bench.queues.others.borrow_mut().push_back(frame(0x700));
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
    bench.queues.others.borrow_mut().push_back(frame(0x581));
    bench.controller.fill_mailboxes();
    assert_eq!(bench.controller.discard_process_data(), 0);
    assert_eq!(
        boxes(&bench),
        [Some(frame(0x700)), Some(frame(0x581)), None]
    );
}

#[test]
fn lost_frames_are_reported_before_the_next_one() {
    let mut port = Port::default();
    port.0.borrow_mut().has_overrun = true;
    port.0.borrow_mut().received.push_back(frame(5));
    assert_eq!(receive(&mut port), Err(nb::Error::Other(Overrun)));
    assert_eq!(receive(&mut port), Ok(frame(5)));
    assert_eq!(receive(&mut port), Err(nb::Error::WouldBlock));
}
