//! The queues between the tasks.
//!
//! The task of the CANopen device has an end of each: it notices when one is not intact.

use canopen::CanFrame;
use drivers::can::{ReceivedFrame, TransmitQueues};
use firmware::drive::{StoredParameters, UpdateOrder};
use task_queues::{Channel as _, Consumer, Producer, channel};

use super::{background::StepReport, parameter_store::SaveResult, update_result::UpdateResult};

channel!(
    /// Received frames: more than the bus carries between two calls of the device, in 3 ms at
    /// 1 Mbit/s.
    pub ReceivedFrames: [ReceivedFrame; 64]
);
channel!(
    /// EMCY, heartbeats, SDO responses: frames that must not be lost. A bus of 1 Mbit/s carries as
    /// many in 2 ms, so that urgent frames of the next call wait no longer. A block of the SDO
    /// server, 127 frames, continues as there is room.
    pub OtherFrames: [CanFrame; 16]
);
channel!(
    /// TPDOs, which are discarded when they have waited too long; as many as of the other frames.
    pub ProcessData: [CanFrame; 16]
);
channel!(
    /// Reports of control steps for the background task.
    pub StepReports: [StepReport; 2]
);
channel!(
    /// A set of parameters to be saved.
    pub ToSave: [&'static mut StoredParameters; 1]
);
channel!(
    /// The result of a save.
    pub SaveResults: [SaveResult; 1]
);
channel!(
    /// An order of an update.
    pub UpdateOrders: [UpdateOrder<'static>; 1]
);
channel!(
    /// The result of an order.
    pub UpdateResults: [UpdateResult; 1]
);

/// The ends of the task of the CANopen device.
pub struct DeviceEnds {
    pub received: Consumer<ReceivedFrames>,
    pub to_transmit: Producer<OtherFrames>,
    pub process_data: Producer<ProcessData>,
    pub reports: Producer<StepReports>,
    pub to_save: Producer<ToSave>,
    pub save_results: Consumer<SaveResults>,
    pub to_update: Producer<UpdateOrders>,
    pub update_results: Consumer<UpdateResults>,
}

impl DeviceEnds {
    /// Whether no position of a queue has changed.
    pub fn are_intact(&self) -> bool {
        self.received.is_intact()
            && self.to_transmit.is_intact()
            && self.process_data.is_intact()
            && self.reports.is_intact()
            && self.to_save.is_intact()
            && self.save_results.is_intact()
            && self.to_update.is_intact()
            && self.update_results.is_intact()
    }
}

/// The ends of the tasks of the CAN controller.
pub struct ControllerEnds {
    pub process_data: Consumer<ProcessData>,
    pub others: Consumer<OtherFrames>,
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

/// The ends of the background task.
pub struct BackgroundEnds {
    pub reports: Consumer<StepReports>,
    pub to_save: Consumer<ToSave>,
    pub saved: Producer<SaveResults>,
    pub update_orders: Consumer<UpdateOrders>,
    pub updated: Producer<UpdateResults>,
}

/// All ends.
pub struct Ends {
    pub device: DeviceEnds,
    pub controller: ControllerEnds,
    pub background: BackgroundEnds,
    /// The end of the reception.
    pub receiver: Producer<ReceivedFrames>,
}

/// The ends of each task.
///
/// # Safety
/// At most one call.
pub unsafe fn ends() -> Ends {
    // SAFETY: one call for each queue, as this function is called once.
    let (
        (receiver, received),
        (to_transmit, others),
        (process_data, waiting_process_data),
        (reports, waiting_reports),
        (to_save, waiting_to_save),
        (saved, save_results),
        (to_update, update_orders),
        (updated, update_results),
    ) = unsafe {
        (
            ReceivedFrames::split(),
            OtherFrames::split(),
            ProcessData::split(),
            StepReports::split(),
            ToSave::split(),
            SaveResults::split(),
            UpdateOrders::split(),
            UpdateResults::split(),
        )
    };
    Ends {
        device: DeviceEnds {
            received,
            to_transmit,
            process_data,
            reports,
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
            reports: waiting_reports,
            to_save: waiting_to_save,
            saved,
            update_orders,
            updated,
        },
        receiver,
    }
}
