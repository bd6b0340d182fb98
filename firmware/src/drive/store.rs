//! The parameters in the flash, and the save that is requested or running.

use core::task::Poll;

use canopen::{Abort, ParameterGroup};

use super::stored::StoredParameters;

/// The service that requested a save.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StoreClient {
    /// Object 1010h.
    Save(ParameterGroup),
    /// Object 1011h.
    Restore(ParameterGroup),
    /// Layer setting services.
    Lss,
    /// The registers of the servo bus.
    ServoBus,
}

/// Progress of a save.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Idle,
    /// The flash is to be written.
    Requested(StoreClient),
    /// The flash is being written.
    Running(StoreClient),
    /// The flash is written, successfully or not; the client has not fetched the result.
    Done(StoreClient, bool),
}

/// The stored parameters, and those of the present save.
#[derive(Debug)]
pub(super) struct ParameterStore {
    stored: StoredParameters,
    /// Becomes the stored set when the flash holds it.
    candidate: StoredParameters,
    phase: Phase,
    /// The requester aborted: no client fetches the result.
    is_abandoned: bool,
}

impl ParameterStore {
    pub fn new(stored: StoredParameters) -> Self {
        Self {
            stored,
            candidate: stored,
            phase: Phase::Idle,
            is_abandoned: false,
        }
    }

    /// The content of the flash.
    pub fn stored(&self) -> &StoredParameters {
        &self.stored
    }

    /// Whether this client has requested a save whose result it has not fetched.
    pub fn has_request_of(&self, client: StoreClient) -> bool {
        matches!(
            self.phase,
            Phase::Requested(owner) | Phase::Running(owner) | Phase::Done(owner, _)
                if owner == client
        )
    }

    /// The set to be written to the flash, once.
    pub fn take_request(&mut self) -> Option<&StoredParameters> {
        let Phase::Requested(client) = self.phase else {
            return None;
        };
        self.phase = Phase::Running(client);
        Some(&self.candidate)
    }

    /// The flash is written, successfully or not.
    pub fn finish(&mut self, is_successful: bool) {
        let Phase::Running(client) = self.phase else {
            return;
        };
        if is_successful {
            self.stored = self.candidate;
        }
        self.phase = if self.is_abandoned {
            Phase::Idle
        } else {
            Phase::Done(client, is_successful)
        };
        self.is_abandoned = false;
    }

    /// The SDO client aborted its request; a running save is completed.
    pub fn abandon(&mut self) {
        match self.phase {
            Phase::Idle
            | Phase::Requested(StoreClient::Lss | StoreClient::ServoBus)
            | Phase::Running(StoreClient::Lss | StoreClient::ServoBus)
            | Phase::Done(StoreClient::Lss | StoreClient::ServoBus, _) => {}
            Phase::Done(..) => self.phase = Phase::Idle,
            Phase::Requested(_) | Phase::Running(_) => self.is_abandoned = true,
        }
    }

    /// Changes the stored set, and is ready when the flash holds it. A client calls it repeatedly
    /// with the same change until then; a client that comes during the save of another one waits.
    pub fn save(
        &mut self,
        client: StoreClient,
        change: impl FnOnce(&mut StoredParameters),
    ) -> Poll<Result<(), Abort>> {
        match self.phase {
            Phase::Idle => {
                self.candidate = self.stored;
                change(&mut self.candidate);
                self.phase = Phase::Requested(client);
                Poll::Pending
            }
            Phase::Done(owner, is_successful) if owner == client => {
                self.phase = Phase::Idle;
                Poll::Ready(is_successful.then_some(()).ok_or(Abort::Hardware))
            }
            _ => Poll::Pending,
        }
    }
}
