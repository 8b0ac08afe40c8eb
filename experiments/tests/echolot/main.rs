//! The command line tool and what it is made of, from outside.

mod cache;
mod commands;
mod end_to_end;
mod figures;
mod room;
