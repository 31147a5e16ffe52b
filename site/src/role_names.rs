//! Roles by the names that the API has for them.

use http::Role;

/// Returns the name of a role.
pub const fn name(role: Role) -> &'static str {
    match role {
        Role::Nobody => "Nobody",
        Role::Watch => "Watch",
        Role::Operate => "Operate",
        Role::Own => "Own",
    }
}

/// Returns the role that a key may have, by its name: any but that of nobody.
pub fn of_key(text: &str) -> Option<Role> {
    [Role::Watch, Role::Operate, Role::Own].into_iter().find(|role| name(*role) == text)
}
