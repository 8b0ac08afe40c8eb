//! The command line tool and its modules, from outside.

#[cfg(feature = "audio")]
mod audio;
mod bags;
mod bench;
mod cache;
mod code;
mod commands;
mod end_to_end;
mod example;
mod faults;
mod figures;
mod files;
mod inputs;
mod interruption;
mod landmarks;
mod live;
mod memory;
mod report;
mod robot;
mod room;
mod slurm;
mod snapshots;
mod studies;
mod trust;
