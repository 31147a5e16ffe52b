//! The ledger as a table for a person.

use super::figures::Ledger;

/// Cycles for each instruction of a Cortex-M7, an estimate: half a cycle where two issue at once and
/// everything is in TCM is the ideal; stores to port registers, taken branches and the dozen cycles into and
/// out of an interrupt bring it to 0.8; flash and AXI reads that miss the caches, divisions and
/// double-precision arithmetic to 1.6.
const CYCLES: [f64; 2] = [0.8, 1.6];
/// Keys whose estimate in cycles says something: the costs of steps.
const IN_CYCLES: [&str; 4] = ["emit_per_step_", "feed_per_step_", "solve_per_step_", "per_step_total"];

/// A line for each figure, with its value at the last commit, where that differs.
pub fn print(now: &Ledger, before: Option<&Ledger>) {
    println!("{:<42} {:>12} {:>12} {:>9}  estimated cycles", "key", "now", "committed", "change");
    for (name, value) in now {
        let old = before.and_then(|before| before.get(name));
        let (shown, change) = match old {
            Some(old) if old != value && *old != 0.0 => {
                (format!("{old}"), format!("{:+.1} %", (value / old - 1.0) * 100.0))
            }
            Some(old) => (format!("{old}"), String::new()),
            None => ("new".into(), String::new()),
        };
        println!("{name:<42} {value:>12} {shown:>12} {change:>9}  {}", cycles(name, *value).trim_end());
    }
    let [least, most] = CYCLES;
    println!();
    println!(
        "Instructions are counted, exactly. Cycles are an estimate, {least} to {most} for each instruction (a Cortex-M7 issues up to"
    );
    println!(
        "two a cycle, and waits for interrupt entry, ports, flash and divisions; ARM DDI 0489, Cortex-M7 Technical Reference"
    );
    println!("Manual); only silicon can tell. docs/performance.md says what each key means.");
}

fn cycles(name: &str, instructions: f64) -> String {
    if !IN_CYCLES.iter().any(|key| name.starts_with(key)) {
        return String::new();
    }
    let [least, most] = CYCLES.map(|share| instructions * share);
    format!("{least:.0} to {most:.0}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_costs_of_steps_have_cycles() {
        assert_eq!(cycles("emit_per_step_3", 50.0), "40 to 80");
        assert_eq!(cycles("ram_bytes", 50.0), "");
    }
}
