//! Updates: the machine's port to the log in flash and to the boot stage.

use base::ports::{Firmware, FirmwareId, Flaw, Running, Updates};
use bsp_prime::boot_request;

use super::{BoardPorts, Locks};

impl<L: Locks> Updates for BoardPorts<L> {
    fn running(&mut self) -> Running {
        self.updates.running()
    }

    fn confirm(&mut self) {
        self.updates.confirm();
    }

    fn set_policy(&mut self, key: Option<&[u8; 32]>, is_locked: bool) -> Result<(), Flaw> {
        self.updates.set_policy(key.copied(), is_locked)
    }

    fn image_bytes(&mut self) -> u32 {
        self.updates.image_bytes()
    }

    fn read_image(&mut self, at: u32, into: &mut [u8]) -> bool {
        self.updates.read_image(at, into)
    }

    fn begin_look(&mut self) {
        self.updates.begin_look();
    }

    fn look(&mut self, piece: &[u8]) {
        self.updates.look(piece);
    }

    fn end_look(&mut self) -> Result<Firmware, Flaw> {
        self.updates.end_look()
    }

    fn ask_for_install(&mut self, image: FirmwareId) -> bool {
        self.updates.ask_for_install(image)
    }

    fn ask_for_download(&mut self) -> bool {
        boot_request::ask_for_download();
        true
    }

    fn take_download_request(&mut self, may: bool) -> bool {
        self.updates.take_download_request(may)
    }
}
