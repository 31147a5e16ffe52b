//! Log of an image's writes to chosen registers, in order and with their times.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rigless::emulator::{AccessKind, Host, Settled};
use rigless::session::Session;
use virtual_prime::board::PrimeBoard;
use virtual_prime::vm::Observer;

/// A write to a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    pub at_ns: u64,
    pub address: u64,
    pub value: u64,
}

/// Log of the writes so far, shared with the test.
#[derive(Clone, Debug, Default)]
pub struct WriteLog(Arc<Mutex<Vec<Written>>>);

impl WriteLog {
    /// Takes all writes out of the log.
    pub fn take(&self) -> Vec<Written> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Observer that hands everything on to another observer, and logs the writes to these addresses.
pub struct Listener {
    pub inner: Box<dyn Observer>,
    pub addresses: Vec<Range<u64>>,
    pub log: WriteLog,
}

impl Observer for Listener {
    fn settled(&mut self, session: &mut Session<PrimeBoard>, host: &mut dyn Host, settled: &Settled) {
        if let Settled::Access { access, .. } = settled
            && access.kind == AccessKind::Write
            && self.addresses.iter().any(|range| range.contains(&access.address))
        {
            let written = Written { at_ns: access.virtual_time.0, address: access.address, value: access.value };
            self.log.0.lock().unwrap_or_else(PoisonError::into_inner).push(written);
        }
        self.inner.settled(session, host, settled);
    }

    fn console(&mut self, bytes: &[u8]) {
        self.inner.console(bytes);
    }

    fn verdict(&self) -> Option<String> {
        self.inner.verdict()
    }
}
