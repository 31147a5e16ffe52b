//! The ledger as a table for a person.

use super::Ledger;

/// One line a number; with what it was at the last commit, where that differs.
pub fn print(now: &Ledger, before: Option<&Ledger>) {
    println!("{:<32} {:>12} {:>12} {:>8}", "instructions or bytes", "now", "committed", "change");
    for (name, value) in now {
        let old = before.and_then(|before| before.get(name));
        let (shown, change) = match old {
            Some(old) if old != value && *old != 0.0 => {
                (format!("{old}"), format!("{:+.1} %", (value / old - 1.0) * 100.0))
            }
            Some(old) => (format!("{old}"), String::new()),
            None => ("new".into(), String::new()),
        };
        println!("{name:<32} {value:>12} {shown:>12} {change:>8}");
    }
}
