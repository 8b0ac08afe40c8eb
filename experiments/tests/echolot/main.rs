//! The command line tool and its modules, from outside.

mod cache;
mod commands;
mod end_to_end;
mod example;
mod figures;
mod room;
mod snapshots;
