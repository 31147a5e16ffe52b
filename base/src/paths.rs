//! Names of files: the card's place, making names absolute, and parsing the words of commands.

use core::fmt::Write as _;

use card::fat::{is_legal_name, stripped};
use heapless::String;

use crate::failure::{Failure, Texts};
use crate::ports::{PATH_BYTES, StorageError};

/// Absolute path of a file.
pub type Path = String<PATH_BYTES>;
/// Mount point of the card, and the current directory at boot.
pub const CARD: &str = "/sd";
/// Path of the configuration.
pub const CONFIG_PATH: &str = "/sd/config.ini";
/// Path of the saved settings.
pub const OVERRIDE_PATH: &str = "/sd/config-override";

/// Makes a name relative to a directory absolute. There is nothing but the card: `/x` is its file x, as
/// `/sd/x` is. A path that does not fit becomes empty, which no file has.
pub fn absolute(directory: &str, name: &str) -> Path {
    let name = name.trim().trim_matches('"');
    let mut path = Path::new();
    let base = if name.starts_with('/') { "" } else { directory };
    for part in base.split('/').chain(name.split('/')) {
        let fits = match part {
            "" | "." => true,
            ".." => {
                let end = path.rfind('/').unwrap_or(0);
                path.truncate(end);
                true
            }
            part => {
                let is_card = !path.is_empty() || part.eq_ignore_ascii_case(CARD.trim_start_matches('/'));
                let on_card = is_card || path.push_str(CARD).is_ok();
                on_card && path.push('/').is_ok() && path.push_str(part).is_ok()
            }
        };
        if !fits {
            return Path::new();
        }
    }
    if path.is_empty() {
        // The card's three characters fit.
        let _ = path.push_str(CARD);
    }
    path
}

/// Returns `/sd/config-override`, or `/sd/config-override.abc` for a named set of settings (M500, M501,
/// M504).
///
/// # Errors
/// When no file can have this name.
pub fn override_path(texts: &Texts, set: Option<&str>) -> Result<Path, Failure> {
    let set = set.map_or("", str::trim);
    // Periods at the end do not count in a name: with them, one set would be another.
    if !set.is_empty() && (!is_legal_name(set) || stripped(set) != set) {
        return Err(Failure::refused(&"a set of settings cannot have this name: no file can"));
    }
    let mut path = Path::new();
    let point = if set.is_empty() { "" } else { "." };
    let written = write!(path, "{OVERRIDE_PATH}{point}{set}");
    written.map_err(|_| texts.about_file(CARD, StorageError::BadPath.text()))?;
    Ok(path)
}

/// Splits a command into words, divided by blanks. Quoted text is one word: names may have blanks.
pub fn words(arguments: &str) -> impl Iterator<Item = &str> {
    let mut rest = arguments;
    core::iter::from_fn(move || {
        rest = rest.trim_ascii_start();
        let (word, behind) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => rest.split_once([' ', '\t']).unwrap_or((rest, "")),
        };
        let is_word = !rest.is_empty();
        rest = behind;
        is_word.then_some(word)
    })
}

/// Splits `"motion control" rest`, `[motion control] rest` or `planner rest` into both parts.
pub fn quoted(text: &str) -> (&str, &str) {
    let text = text.trim();
    let split = match (text.strip_prefix('"'), text.strip_prefix('[')) {
        (Some(rest), _) => rest.split_once('"'),
        (_, Some(rest)) => rest.split_once(']'),
        _ => text.split_once([' ', '\t']),
    };
    let (first, rest) = split.unwrap_or((text, ""));
    (first, rest.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_a_name_together() {
        let of = |text| words(text).collect::<std::vec::Vec<_>>();
        assert_eq!(of(" a.g  \"with space.g\" b.g "), ["a.g", "with space.g", "b.g"]);
        assert_eq!(of("\"never closed.g"), ["never closed.g"]);
        assert_eq!(of("\"\" x"), ["", "x"]);
        assert!(of("  ").is_empty());
    }

    #[test]
    fn every_path_is_on_the_card() {
        for (directory, name, expected) in [
            ("/sd", "x.g", "/sd/x.g"),
            ("/sd", "/x.g", "/sd/x.g"),
            ("/sd", "/sd/x.g", "/sd/x.g"),
            ("/sd", "/SD/x.g", "/SD/x.g"),
            ("/sd", "", "/sd"),
            ("/sd", "/", "/sd"),
            ("/sd", "..", "/sd"),
            ("/sd/parts", "../x.g", "/sd/x.g"),
            ("/sd/parts", "../../../x.g", "/sd/x.g"),
            ("/sd", "\"with space.g\"", "/sd/with space.g"),
            ("/sd", "sd/x.g", "/sd/sd/x.g"),
        ] {
            assert_eq!(absolute(directory, name), expected, "{name} in {directory}");
        }
        assert_eq!(absolute("/sd", &"x".repeat(PATH_BYTES - 4)).len(), PATH_BYTES);
        assert_eq!(absolute("/sd", &"x".repeat(PATH_BYTES - 3)), "", "cut, it would be another file's name");
    }

    #[test]
    fn a_section_with_a_blank_is_quoted() {
        assert_eq!(quoted("\"motion control\" max_speed = 3"), ("motion control", "max_speed = 3"));
        assert_eq!(quoted("planner planner_queue_size 64"), ("planner", "planner_queue_size 64"));
        assert_eq!(quoted("[motion control] max_speed = 3"), ("motion control", "max_speed = 3"));
        assert_eq!(quoted("  player "), ("player", ""));
    }

    #[test]
    fn sets_of_settings_have_names_that_files_can_have() {
        assert_eq!(override_path(&Texts::new(), None).unwrap(), OVERRIDE_PATH);
        assert_eq!(override_path(&Texts::new(), Some("  ")).unwrap(), OVERRIDE_PATH);
        assert_eq!(override_path(&Texts::new(), Some(" abs ")).unwrap(), "/sd/config-override.abs");
        for name in ["a/b", "a.", "..", "a:b"] {
            assert!(override_path(&Texts::new(), Some(name)).is_err(), "{name}");
        }
        assert!(override_path(&Texts::new(), Some(&"x".repeat(PATH_BYTES))).is_err());
    }
}
