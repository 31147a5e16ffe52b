//! Files of the card that hold secrets of the network: the password's record and the keys of programs. The
//! machine reads them, and shows them to nobody: not as a listing, a job, a copy or a download.

use card::fat::stripped;

use crate::ports::{FileHandle, OpenMode, Storage, StorageError};

/// Path of the password's record. The name is its own short name (8.3), so the file has no second one.
pub const PASSWORD_PATH: &str = "/sd/netpass";
/// Path of the keys of programs, likewise.
pub const KEYS_PATH: &str = "/sd/netkeys";

/// Returns whether a path is that of a secret, or of a companion that is there while one is replaced. The
/// names belong to the machine in every folder, so no way of writing a path leads around this.
#[must_use]
#[inline(never)]
pub fn is_secret(path: &str) -> bool {
    let name = stripped(path.trim_matches('"').rsplit(['/', '\\']).next().unwrap_or_default());
    [PASSWORD_PATH, KEYS_PATH].iter().filter_map(|path| path.rsplit('/').next()).any(|secret| {
        let end = name.len().checked_sub(secret.len()).and_then(|at| name.get(at..));
        end.is_some_and(|end| end.eq_ignore_ascii_case(secret))
    })
}

/// Opens a file whose name somebody has given, to read it.
///
/// # Errors
/// [`StorageError::Secret`], and those of the storage.
#[inline(never)]
pub fn open_to_show(storage: &mut impl Storage, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
    if is_secret(path) {
        return Err(StorageError::Secret);
    }
    storage.open(path, mode)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_is_one_however_its_path_is_written() {
        for path in [
            "/sd/netpass",
            "netpass",
            "NETPASS",
            "\"netpass\"",
            "/sd/NetKeys",
            "/sd/netkeys.",
            "netpass. .",
            "/sd/previous-netpass",
            "/sd/draft-netkeys",
            "folder/../netpass",
            "folder\\netpass",
        ] {
            assert!(is_secret(path), "{path}");
        }
        for path in ["", "/", "/sd/netpass.gcode", "/sd/netpasses", "/sd/key", "/sd/netpass/x", "n\u{E9}tpass"] {
            assert!(!is_secret(path), "{path}");
        }
    }
}
