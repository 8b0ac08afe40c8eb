//! The command line tool `echolot`.

fn main() {}
