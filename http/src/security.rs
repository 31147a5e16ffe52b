//! Header lines that every answer has, so that a browser does with it what is meant and nothing else.

/// Content policy of pages: scripts, styles and pictures of this server, connections to it, no frames around
/// it, no forms to elsewhere. `data:` and `blob:` are for pictures that the page makes itself.
pub const CONTENT_POLICY: &str = "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; \
     frame-ancestors 'none'; form-action 'self'";

/// Lines that each answer with a body has: what a file is, its type alone says; no other origin may read or
/// embed it, and no address of ours is told elsewhere.
pub const LINES: [(&str, &str); 5] = [
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("X-Frame-Options", "DENY"),
    ("Content-Security-Policy", CONTENT_POLICY),
];
