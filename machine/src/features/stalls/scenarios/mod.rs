//! Stalls of motors, and jobs that get over them.

mod recovery;
mod watch;
