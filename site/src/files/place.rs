//! Paths of files as visitors name them: below the root `gcodes`, which is the card.
//!
//! A path is made plain once: what two paths would both name has one path. The card's names are the same
//! without regard to case and to blanks and periods at their ends, and long names have short ones beside them
//! (`CONFIG~1.INI`): these are refused, so that nobody comes by one to a file that is kept from him.

use base::paths::{CARD, Path};
use base::secrets::is_secret;
use http::{Role, Status};

use super::refusal::Refusal;

/// Root of all files.
pub const ROOT: &str = "gcodes";
/// Folder of this board's own, which nobody sees.
pub const OWN_FOLDER: &str = "/sd/.velvet";
/// Folder of a page of the user's own.
pub const PAGE_FOLDER: &str = "/sd/www";
/// Longest short name: eight characters, a period, three.
const SHORT_NAME_BYTES: usize = 12;

/// Returns the path on the card of a path that begins with its root.
///
/// # Errors
/// There is no such root, or no file can have the path.
pub fn of(named: &str) -> Result<Path, Refusal> {
    match named.split_once('/').unwrap_or((named, "")) {
        (ROOT, rest) => below(CARD, rest),
        _ => Err(Refusal::new(Status::NotFound, "there is no such root: files are in gcodes")),
    }
}

/// Returns the path on the card of a path below a folder.
///
/// # Errors
/// No file can have the path, or nobody may see it.
pub fn below(folder: &str, rest: &str) -> Result<Path, Refusal> {
    let too_long = Refusal::bad("the path is too long");
    let mut path = Path::try_from(folder).map_err(|_| too_long)?;
    for part in rest.split('/') {
        let name = stripped(part);
        if part.is_empty() {
            continue;
        }
        if name.is_empty() || name.chars().any(|letter| letter.is_control() || "\\\"*:<>?|".contains(letter)) {
            return Err(Refusal::bad("no file can have this name"));
        }
        if is_hidden(name) {
            return Err(Refusal::new(Status::NotFound, "there is no such file"));
        }
        if name.contains('~') && name.len() <= SHORT_NAME_BYTES {
            return Err(Refusal::bad("short names with ~ are not taken, as they may mean another file"));
        }
        path.push('/').and_then(|()| path.push_str(name)).map_err(|_| too_long)?;
    }
    Ok(path)
}

/// Returns a name without what does not count in it.
fn stripped(name: &str) -> &str {
    name.trim_start_matches(' ').trim_end_matches([' ', '.'])
}

fn is(name: &str, known: &str) -> bool {
    name.eq_ignore_ascii_case(known)
}

fn ends_with(name: &str, end: &str) -> bool {
    name.len().checked_sub(end.len()).and_then(|from| name.get(from..)).is_some_and(|rest| is(rest, end))
}

fn begins_with(name: &str, beginning: &str) -> bool {
    name.get(..beginning.len()).is_some_and(|first| is(first, beginning))
}

/// Returns whether nobody is shown an entry of this name: the board's own, and records of passwords and keys.
#[must_use]
pub fn is_hidden(name: &str) -> bool {
    begins_with(name, ".velvet") || is_secret(name)
}

/// Files and folders at the top of the card that only the owner may change beside those of the configuration:
/// pages, buttons, which the owner presses with an owner's rights, firmware, GRBL's settings, and the file
/// that each start plays without anybody asking.
const OWNERS: [&str; 5] = ["www", "macros", "flashme.bin", "grbl-settings", "on_boot.gcode"];

/// Returns whether only the owner may change the file or folder of this path: what the machine is set up by,
/// pages and the like.
#[must_use]
pub fn is_for_owner(path: &str) -> bool {
    let rest = path.get(CARD.len()..).unwrap_or_default().trim_start_matches('/');
    let first = rest.split('/').next().unwrap_or_default();
    OWNERS.into_iter().any(|known| is(first, known))
        || ends_with(first, "config.ini")
        || begins_with(first, "config.")
        || begins_with(first, "config-override")
}

/// Refuses a visitor who may not change the file of this path.
///
/// # Errors
/// The role does not suffice, or the path is that of the card itself.
pub fn admit(path: &str, role: Role) -> Result<(), Refusal> {
    if path.len() <= CARD.len() {
        return Err(Refusal::bad("this is the card itself"));
    }
    if is_for_owner(path) && role < Role::Own {
        return Err(Refusal::new(Status::Forbidden, "this file is for the machine's owner"));
    }
    Ok(())
}

/// Returns a path of the card as visitors name it, without its root.
#[must_use]
pub fn shown(path: &str) -> &str {
    path.get(CARD.len() + 1..).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_made_plain_once() {
        for (named, path) in [
            ("gcodes", "/sd"),
            ("gcodes/", "/sd"),
            ("gcodes/a b.gcode", "/sd/a b.gcode"),
            ("gcodes//x/ y. /z.g", "/sd/x/y/z.g"),
            ("gcodes/Würfel.gcode", "/sd/Würfel.gcode"),
        ] {
            assert_eq!(of(named).as_deref(), Ok(path), "{named}");
        }
    }

    #[test]
    fn nothing_beyond_the_card_and_nothing_hidden_is_named() {
        for named in [
            "",
            "config/x",
            "gcodesx/a",
            "gcodes/../x",
            "gcodes/a/../../x",
            "gcodes/./x",
            "gcodes/a\\b",
            "gcodes/a:b",
            "gcodes/a\nb",
            "gcodes/.velvet/x",
            "gcodes/.VELVET. /x",
            "gcodes/ .velvet",
            "gcodes/netpass",
            "gcodes/NETKEYS",
            "gcodes/previous-netpass",
            "gcodes/NETPASS.",
            "gcodes/CONFIG~1.INI",
            "gcodes/velvet~1",
        ] {
            assert!(of(named).is_err(), "{named}");
        }
        assert!(of(&format!("gcodes/{}", "n".repeat(253))).is_err());
        assert!(of(&format!("gcodes/{}", "n".repeat(252))).is_ok());
    }

    #[test]
    fn what_the_machine_is_set_up_by_is_for_the_owner() {
        for path in [
            "/sd/config.ini",
            "/sd/CONFIG.INI",
            "/sd/new-config.ini",
            "/sd/config.default",
            "/sd/config-override.x",
            "/sd/flashme.bin",
            "/sd/grbl-settings",
            "/sd/On_Boot.gcode",
            "/sd/www",
            "/sd/WWW/index.html",
            "/sd/macros/buttons.json",
            "/sd/Macros",
        ] {
            assert!(
                is_for_owner(path) && admit(path, Role::Operate).is_err() && admit(path, Role::Own).is_ok(),
                "{path}"
            );
        }
        for path in ["/sd/a.gcode", "/sd/parts/config.ini", "/sd/wwwx", "/sd/configuration.g"] {
            assert!(!is_for_owner(path) && admit(path, Role::Operate).is_ok(), "{path}");
        }
        assert!(admit("/sd", Role::Own).is_err());
    }
}
