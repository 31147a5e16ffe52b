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

/// Figure that must not be less than its limit.
///
/// Returns what is wrong: less than the limit; or greater than it, so that the limit must be raised, as far
/// as the goal.
pub fn at_least(what: &str, is: usize, limit: usize, goal: usize) -> Option<String> {
    if is < limit {
        Some(format!("{what}: {is}, at least {limit} must be"))
    } else if is > limit && limit < goal {
        Some(format!("{what}: {is} by now: raise its limit from {limit} to {}", is.min(goal)))
    } else {
        None
    }
}

/// Limit of a package: that of its row in the table of what has not reached the goal, else the goal.
pub fn of(table: &[(&str, usize)], package: &str, goal: usize) -> usize {
    table.iter().find(|(name, _)| *name == package).map_or(goal, |(_, limit)| *limit)
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

    #[test]
    fn a_limit_only_grows() {
        assert_eq!(at_least("x", 90, 91, 98).as_deref(), Some("x: 90, at least 91 must be"));
        assert_eq!(at_least("x", 91, 91, 98), None);
        assert_eq!(at_least("x", 99, 91, 98).as_deref(), Some("x: 99 by now: raise its limit from 91 to 98"));
        assert_eq!(at_least("x", 99, 98, 98), None);
    }

    #[test]
    fn a_package_without_a_row_has_the_goal() {
        assert_eq!(of(&[("a", 7)], "a", 3), 7);
        assert_eq!(of(&[("a", 7)], "b", 3), 3);
    }
}
