//! The queues between the tasks.

use canopen::CanFrame;
use drivers::can::TransmitQueues;
use firmware::drive::{StoredParameters, UpdateOrder};
use heapless::spsc::{Consumer, Producer, Queue};

use super::{background::StepReport, parameter_store::SaveResult, update_result::UpdateResult};

/// Received frames: more than the bus carries between two communication cycles, in 3 ms at 1 Mbit/s.
const RECEIVED: usize = 64 + 1;

/// EMCY, heartbeats, SDO responses: frames that must not be lost. A bus of 1 Mbit/s carries as many
/// in 2 ms, so that urgent frames of the next cycle wait no longer. A block of the SDO server, 127
/// frames, continues as there is room. As many TPDOs, which are discarded when they have waited too
/// long.
const TO_TRANSMIT: usize = 16 + 1;

/// Reports of control periods for the log.
const REPORTS: usize = 2 + 1;

/// One message.
const ONE: usize = 1 + 1;

/// The memory of all queues.
pub struct Queues {
    received: Queue<CanFrame, RECEIVED>,
    others: Queue<CanFrame, TO_TRANSMIT>,
    process_data: Queue<CanFrame, TO_TRANSMIT>,
    reports: Queue<StepReport, REPORTS>,
    to_save: Queue<&'static mut StoredParameters, ONE>,
    save_results: Queue<SaveResult, ONE>,
    update_orders: Queue<UpdateOrder<'static>, ONE>,
    update_results: Queue<UpdateResult, ONE>,
}

/// The received frames, from the interrupt of the reception.
pub type ReceivedFrames = Producer<'static, CanFrame, RECEIVED>;

/// The reports of control periods, from the loop.
pub type StepReports = Producer<'static, StepReport, REPORTS>;

/// The ends of the communication.
pub struct CommEnds {
    pub received: Consumer<'static, CanFrame, RECEIVED>,
    pub to_transmit: Producer<'static, CanFrame, TO_TRANSMIT>,
    pub process_data: Producer<'static, CanFrame, TO_TRANSMIT>,
    pub to_save: Producer<'static, &'static mut StoredParameters, ONE>,
    pub save_results: Consumer<'static, SaveResult, ONE>,
    pub to_update: Producer<'static, UpdateOrder<'static>, ONE>,
    pub update_results: Consumer<'static, UpdateResult, ONE>,
}

/// The ends of the tasks of the CAN controller.
pub struct ControllerEnds {
    process_data: Consumer<'static, CanFrame, TO_TRANSMIT>,
    others: Consumer<'static, CanFrame, TO_TRANSMIT>,
}

impl TransmitQueues for ControllerEnds {
    #[inline]
    fn next_process_data(&mut self) -> Option<CanFrame> {
        self.process_data.dequeue()
    }

    #[inline]
    fn next_other(&mut self) -> Option<CanFrame> {
        self.others.dequeue()
    }
}

/// The sets of parameters to be saved, for the background task.
pub type ToSave = Consumer<'static, &'static mut StoredParameters, ONE>;

/// The ends of the background task.
pub struct BackgroundEnds {
    pub reports: Consumer<'static, StepReport, REPORTS>,
    pub to_save: ToSave,
    pub saved: Producer<'static, SaveResult, ONE>,
    pub update_orders: Consumer<'static, UpdateOrder<'static>, ONE>,
    pub updated: Producer<'static, UpdateResult, ONE>,
}

/// All ends.
pub struct Ends {
    pub comm: CommEnds,
    pub controller: ControllerEnds,
    pub background: BackgroundEnds,
    pub receiver: ReceivedFrames,
    pub reporter: StepReports,
}

impl Queues {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            received: Queue::new(),
            others: Queue::new(),
            process_data: Queue::new(),
            reports: Queue::new(),
            to_save: Queue::new(),
            save_results: Queue::new(),
            update_orders: Queue::new(),
            update_results: Queue::new(),
        }
    }

    /// The ends of each task.
    pub fn split(&'static mut self) -> Ends {
        let (receiver, received) = self.received.split();
        let (to_transmit, others) = self.others.split();
        let (process_data, waiting_process_data) = self.process_data.split();
        let (reporter, reports) = self.reports.split();
        let (to_save, waiting_to_save) = self.to_save.split();
        let (saved, save_results) = self.save_results.split();
        let (to_update, update_orders) = self.update_orders.split();
        let (updated, update_results) = self.update_results.split();
        Ends {
            comm: CommEnds {
                received,
                to_transmit,
                process_data,
                to_save,
                save_results,
                to_update,
                update_results,
            },
            controller: ControllerEnds {
                process_data: waiting_process_data,
                others,
            },
            background: BackgroundEnds {
                reports,
                to_save: waiting_to_save,
                saved,
                update_orders,
                updated,
            },
            receiver,
            reporter,
        }
    }
}
