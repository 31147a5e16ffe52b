//! Input of a look ahead: the file's dialect, its bytes, the files of subroutines.

use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use jobs::player::{FileLines, Lookup, Step, TOO_DEEP, sub_path};
use preflight::forecast::{Answer, ForecastFiles, Forecaster, SharedForecast, Wanted};

/// Looks up the dialect that the file is written in; `None`: not yet known.
pub(super) fn look(
    lookup: &mut Lookup,
    file: Option<FileHandle>,
    forecast: &SharedForecast,
    forecaster: &mut dyn Forecaster,
    storage: &mut impl Storage,
) -> Option<()> {
    let known = match lookup.step(file?, storage) {
        Ok(Step::Reading | Step::Waiting) => return None,
        Ok(Step::Known(dialect)) => dialect,
        Err(error) => {
            forecast.fail(error.text());
            return Some(());
        }
    };
    forecaster.read_as(known);
    if let Err(error) = forecast.lines(|lines| lines.restart(storage)) {
        forecast.fail(error.text());
    }
    Some(())
}

/// Brings the input that the work waits for.
///
/// # Errors
/// Errors of the card.
pub(super) fn bring(
    wanted: &Wanted,
    files: &mut ForecastFiles,
    forecast: &SharedForecast,
    storage: &mut impl Storage,
) -> Result<Answer, StorageError> {
    let is_there = match wanted {
        Wanted::More => forecast.lines(|lines| lines.fill(storage))?,
        Wanted::At(place) => forecast.lines(|lines| lines.go_to(*place, storage)).map(|()| true)?,
        Wanted::Call(name) => {
            let folder = files.path.rfind('/').and_then(|end| files.path.get(..end)).unwrap_or_default();
            if files.callers.is_full() {
                return Ok(Answer::Failed(TOO_DEEP));
            }
            match storage.open(&sub_path(folder, name), OpenMode::Beside) {
                Ok(file) => {
                    let caller = forecast.lines(|lines| core::mem::replace(lines, FileLines::new(file)));
                    // Room for the caller has been checked.
                    let _ = files.callers.push(caller);
                    true
                }
                Err(_) => false,
            }
        }
        Wanted::Caller => match files.callers.pop() {
            Some(caller) => {
                let done = forecast.lines(|lines| core::mem::replace(lines, caller));
                // The file was only read.
                let _ = storage.close(done.file());
                true
            }
            None => false,
        },
        // Another moment has their answers.
        Wanted::Macro(..) | Wanted::MacroLine | Wanted::Called(_) | Wanted::Line(..) => false,
    };
    Ok(if is_there { Answer::Here } else { Answer::None })
}
