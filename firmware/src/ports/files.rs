//! Files: the machine's storage port.

use base::ports::{
    CardEvent, CardFacts, DirectoryEntry, FileHandle, FreeSpace, LIST_CHUNK, OpenMode, Storage, StorageError,
};
use base::watchdog::Reporter;
use bsp_prime::sd::CardService;
use heapless::Vec;
use rtic::Mutex;

use super::BoardPorts;
use crate::lock_free::REPORTS;

impl<M, H, S, T, K: Mutex<T = &'static mut CardService>> Storage for BoardPorts<M, H, S, T, K> {
    fn between_steps(&mut self) {
        REPORTS.report(Reporter::Executor);
    }

    fn forget_card(&mut self) {
        self.storage.forget_card();
    }

    fn mount(&mut self) -> Result<(), StorageError> {
        self.storage.mount()
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        self.storage.open(path, mode)
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        self.storage.read(file, buffer)
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        self.storage.write(file, bytes)
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        self.storage.seek(file, offset_bytes)
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        self.storage.size(file)
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        self.storage.close(file)
    }

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        self.storage.list(path, skip, entries)
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.storage.remove(path)
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        self.storage.make_directory(path)
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        self.storage.rename(from, to)
    }

    fn read_ahead(&mut self, file: FileHandle) {
        self.storage.read_ahead(file);
    }

    fn is_at_hand(&mut self, file: FileHandle) -> bool {
        self.storage.is_at_hand(file)
    }

    fn card_facts(&mut self) -> Option<CardFacts> {
        self.storage.card_facts()
    }

    fn count_free(&mut self, free: &mut FreeSpace) -> Result<bool, StorageError> {
        self.storage.count_free(free)
    }

    fn take_event(&mut self) -> Option<CardEvent> {
        self.storage.take_event()
    }

    fn is_ready(&mut self) -> bool {
        self.storage.is_ready()
    }

    fn is_kept(&mut self) -> Result<bool, StorageError> {
        self.storage.is_kept()
    }
}
