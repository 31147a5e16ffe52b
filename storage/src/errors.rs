//! Errors that the machine is told when an operation on files fails.

use base::ports::StorageError;
use card::fat;
use embedded_sdmmc::Error;

use crate::device::Card;
use crate::sdmmc_device::Fault;

/// Converts an error of a name.
pub(crate) fn of_name<C: Card>(error: fat::Error<C::Error>) -> StorageError {
    match error {
        fat::Error::Device(error) => C::reason(&error),
        fat::Error::NotFat(_) => StorageError::NoFileSystem,
        fat::Error::Damaged => StorageError::Damaged,
        fat::Error::NotFound => StorageError::NotFound,
        fat::Error::Exists => StorageError::Exists,
        fat::Error::IsDirectory | fat::Error::IsFile | fat::Error::NotEmpty => StorageError::WrongKind,
        fat::Error::ReadOnly => StorageError::ReadOnly,
        fat::Error::BadName | fat::Error::IntoItself => StorageError::BadPath,
        fat::Error::Full => StorageError::Full,
        fat::Error::DirectoryFull => StorageError::DirectoryFull,
    }
}

/// Converts an error of a file's content.
pub(crate) fn of_content<C: Card>(error: Error<Fault<C::Error>>) -> StorageError {
    match error {
        Error::DeviceError(Fault::Card(error)) => C::reason(&error),
        Error::DeviceError(Fault::Outside) | Error::UnterminatedFatChain | Error::BadCluster => StorageError::Damaged,
        Error::EndOfFile | Error::AllocationError => StorageError::Damaged,
        Error::NotFound | Error::BadHandle => StorageError::NotFound,
        Error::InvalidOffset => StorageError::BadPath,
        Error::NotEnoughSpace | Error::DiskFull => StorageError::Full,
        Error::ReadOnly => StorageError::ReadOnly,
        Error::FileAlreadyOpen => StorageError::Busy,
        Error::TooManyOpenDirs | Error::TooManyOpenFiles => StorageError::TooManyOpen,
        Error::FormatError(_) | Error::NoSuchVolume | Error::BadBlockSize(_) => StorageError::NoFileSystem,
        _ => StorageError::Device,
    }
}
