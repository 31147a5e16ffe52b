//! Writing and closing files: gathered bytes, and failed writes.

use base::ports::{FileHandle, Storage as _, StorageError};
use embedded_sdmmc::{Error, TimeSource};

use super::{CardStorage, Content, Open};
use crate::device::Card;
use crate::errors::of_content;
use crate::sdmmc_device::Fault;

impl<C: Card, T: TimeSource + Clone> CardStorage<'_, C, T> {
    /// Writes what has been gathered, of whatever file.
    pub(super) fn settle_gathered(&mut self) -> Result<(), StorageError> {
        let Some(file) = self.gathered.file() else { return Ok(()) };
        let Ok(raw) = self.written_or_none(file) else { return Ok(()) };
        let done = self.manager.write(raw, self.gathered.of(file));
        self.gathered.forget();
        self.wrote(file, done)
    }

    /// Handles the result of a write of whole or last blocks.
    pub(super) fn wrote(
        &mut self,
        file: FileHandle,
        done: Result<(), Error<Fault<C::Error>>>,
    ) -> Result<(), StorageError> {
        let Err(error) = done else { return Ok(()) };
        if let Ok(written) = self.written(file) {
            written.has_failed = true;
        }
        // An earlier write that failed unseen may be the reason.
        self.is_kept()?;
        match error {
            Error::DiskFull | Error::NotEnoughSpace => Err(self.why_full()),
            error => Err(of_content::<C>(error)),
        }
    }

    pub(super) fn write_on(&mut self, file: FileHandle, mut bytes: &[u8]) -> Result<(), StorageError> {
        let raw = self.written(file)?.raw;
        if self.gathered.file().is_some_and(|other| other != file) {
            // An error of that file is told when the file is written again, or closed.
            let _other = self.settle_gathered();
        }
        // The last free cluster would be taken for an empty file and then lost, as finding no further one is
        // an error there.
        let is_empty = self.manager.file_length(raw).map_err(of_content::<C>)? == 0;
        if is_empty && self.gathered.of(file).is_empty() && !self.names(|volume, device| volume.has_free(device, 2))? {
            return Err(StorageError::Full);
        }
        while !bytes.is_empty() {
            let offset = self.manager.file_offset(raw).map_err(of_content::<C>)?;
            let Self { manager, gathered, .. } = self;
            let (whole, taken) = gathered.take(file, offset, bytes);
            if let Some(block) = whole {
                let done = manager.write(raw, block);
                gathered.forget();
                self.wrote(file, done)?;
            }
            bytes = bytes.get(taken..).unwrap_or(&[]);
        }
        Ok(())
    }

    /// Whether so many bytes lie in the cluster that is written, and have room among what waits: then nothing
    /// is read for them.
    pub(super) fn has_room_for(&mut self, file: FileHandle, bytes: usize) -> bool {
        let gathered = self.gathered.of(file).len();
        let Ok(raw) = self.written_or_none(file) else { return false };
        let Ok(offset) = self.manager.file_offset(raw) else { return false };
        let Ok(cluster) = self.names(|volume, _| Ok(volume.cluster_bytes() as usize)) else { return false };
        let in_cluster = offset as usize % cluster;
        let fits = in_cluster > 0 && in_cluster + gathered + bytes <= cluster;
        // The last block of them may be written twice.
        fits && self.card(|card| card.has_room(bytes.div_ceil(512) + 1))
    }

    pub(super) fn close_content(&mut self, open: &Open) -> Result<(), StorageError> {
        let Content::Written(written) = &open.content else { return Ok(()) };
        let rest = self.gathered.of(open.handle);
        let done = if rest.is_empty() { Ok(()) } else { self.manager.write(written.raw, rest) };
        if !rest.is_empty() {
            self.gathered.forget();
        }
        let has_failed = written.has_failed || done.is_err();
        let closed = self.manager.close_file(written.raw).and(done).map_err(of_content::<C>);
        let closed = if closed.is_err() { self.is_kept().map(drop).and(closed) } else { closed };
        self.manager.device(|sdmmc| sdmmc.release(open.place));
        if has_failed {
            // The bytes that were written stay; the clusters that were taken for the rest are given back.
            self.names(|volume, device| volume.trim(device, open.place))?;
        }
        closed
    }

    /// Finds the reason for a lack of room, which `embedded-sdmmc` does not tell.
    pub(super) fn why_full(&self) -> StorageError {
        match self.names(|volume, device| volume.has_free(device, 1)) {
            Ok(true) => StorageError::Device,
            Ok(false) => StorageError::Full,
            Err(error) => error,
        }
    }
}
