//! Limits on the way to a goal: a figure may only come nearer, and its limit is brought along.

/// Figure that must not be greater than its limit.
///
/// Returns what is wrong: greater than the limit; or less than it, so that the limit must be lowered, as far
/// as the goal.
pub fn at_most(what: &str, is: usize, limit: usize, goal: usize) -> Option<String> {
    if is > limit {
        Some(format!("{what}: {is}, at most {limit} may be"))
    } else if is < limit && limit > goal {
        Some(format!("{what}: {is} by now: lower its limit from {limit} to {}", is.max(goal)))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_only_shrinks() {
        assert_eq!(at_most("x", 5, 4, 3).as_deref(), Some("x: 5, at most 4 may be"));
        assert_eq!(at_most("x", 4, 4, 3), None);
        assert_eq!(at_most("x", 2, 4, 3).as_deref(), Some("x: 2 by now: lower its limit from 4 to 3"));
        assert_eq!(at_most("x", 2, 3, 3), None);
    }
}
