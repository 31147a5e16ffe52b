//! Application of unified diffs, to the letter.

use std::fs;
use std::path::Path;

/// Applies every file's hunks of a patch, as `git diff` writes them, below `root`. Text before the first file
/// is a comment.
///
/// # Errors
/// Which line of the patch does not fit, and what stands there instead.
pub fn apply(patch: &str, root: &Path) -> Result<(), String> {
    let mut lines = patch.lines().enumerate().peekable();
    while let Some((number, line)) = lines.next() {
        let Some(old) = line.strip_prefix("--- ") else { continue };
        let (_, new) = lines.next().ok_or_else(|| format!("line {}: a file without a new name", number + 1))?;
        let name = new.strip_prefix("+++ b/").ok_or_else(|| format!("line {}: `{new}` names no file", number + 2))?;
        let place = root.join(name);
        let before = if old == "/dev/null" { String::new() } else { super::read(&place)? };
        let mut hunks = Vec::new();
        while let Some((at, header)) = lines.next_if(|(_, line)| line.starts_with("@@ ")) {
            let begins = first_line(header).ok_or_else(|| format!("line {}: `{header}`", at + 1))?;
            // The line `diff --git` ends a hunk: the next file's own header would look like a line taken out.
            let mut body = Vec::new();
            while let Some((at, line)) = lines.next_if(|(_, line)| line.starts_with([' ', '+', '-'])) {
                body.push((at + 1, line));
            }
            hunks.push((begins, body));
        }
        let after = patched(&before, &hunks).map_err(|reason| format!("{name}: {reason}"))?;
        if let Some(folder) = place.parent() {
            fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        }
        super::write(&place, &after)?;
    }
    Ok(())
}

/// Returns the line at which a hunk begins in the old file: the number after the minus of `@@ -12,7 +12,9
/// @@`. A new file begins at 0.
fn first_line(header: &str) -> Option<usize> {
    let old = header.strip_prefix("@@ -")?;
    old[..old.find([',', ' '])?].parse().ok()
}

type Hunk<'a> = (usize, Vec<(usize, &'a str)>);

fn patched(before: &str, hunks: &[Hunk<'_>]) -> Result<String, String> {
    let old: Vec<&str> = before.lines().collect();
    let mut new: Vec<&str> = Vec::new();
    let mut at = 0;
    for (begins, body) in hunks {
        let start = begins.saturating_sub(1);
        new.extend(old.get(at..start).ok_or_else(|| format!("there is no line {begins}"))?);
        at = start;
        for &(number, line) in body {
            let (kind, text) = line.split_at(1);
            if kind == "+" {
                new.push(text);
                continue;
            }
            let found = old.get(at).copied().unwrap_or("the end of the file");
            if found != text {
                return Err(format!("line {} is `{found}`, and line {number} of the patch wants `{text}`", at + 1));
            }
            at += 1;
            if kind == " " {
                new.push(text);
            }
        }
    }
    new.extend(old.get(at..).unwrap_or_default());
    Ok(new.join("\n") + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(lines: &[&'static str]) -> Vec<(usize, &'static str)> {
        lines.iter().map(|&line| (1, line)).collect()
    }

    #[test]
    fn hunks_replace_add_and_take_out() {
        let hunks = [(1, body(&[" a", "-b", "+B", " c"])), (4, body(&["-d", " e", "+f"]))];
        assert_eq!(patched("a\nb\nc\nd\ne\ng\n", &hunks).as_deref(), Ok("a\nB\nc\ne\nf\ng\n"));
        assert_eq!(patched("", &[(0, body(&["+new", "+file"]))]).as_deref(), Ok("new\nfile\n"));
    }

    #[test]
    fn a_hunk_that_does_not_fit_is_refused() {
        for hunk in [(1, body(&[" b"])), (2, body(&["-a"])), (9, body(&[" a"])), (2, body(&[" b", " c"]))] {
            assert!(patched("a\nb\n", &[hunk]).is_err());
        }
    }

    #[test]
    fn several_files_are_patched_below_the_root() {
        let root = std::env::temp_dir().join(format!("emulator-patch-{}", std::process::id()));
        fs::create_dir_all(&root).expect("a folder");
        fs::write(root.join("old.rs"), "one\ntwo\n").expect("a file");
        let patch = "Why.\n\ndiff --git a/old.rs b/old.rs\n--- a/old.rs\n+++ b/old.rs\n@@ -1,2 +1,2 @@\n-one\n+1\n two\n\
                     diff --git a/in/new.rs b/in/new.rs\nnew file mode 100644\n--- /dev/null\n+++ b/in/new.rs\n@@ -0,0 +1 @@\n+made\n";
        assert_eq!(apply(patch, &root), Ok(()));
        assert_eq!(fs::read_to_string(root.join("old.rs")).as_deref().ok(), Some("1\ntwo\n"));
        assert_eq!(fs::read_to_string(root.join("in/new.rs")).as_deref().ok(), Some("made\n"));
        assert!(apply(patch, &root).is_err(), "it is applied already");
        fs::remove_dir_all(root).expect("the folder is ours");
    }
}
