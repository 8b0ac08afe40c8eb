//! How much memory there is, so that what does not fit is refused before it is asked for.

use crate::error::Error;

/// Memory in bytes that this process may use: the machine's, its control group's, or the limit of its address space,
/// whichever is least.
pub fn limit_bytes() -> u64 {
    // An unknown system says nothing; the allocation will.
    let machine = sysinfo::System::new().map_or(u64::MAX, |mut system| {
        system.refresh_memory();
        let group = system
            .cgroup_limits()
            .map_or(u64::MAX, |limits| limits.total_memory);
        match system.total_memory().min(group) {
            0 => u64::MAX,
            bytes => bytes,
        }
    });
    machine.min(address_space_bytes())
}

/// Limit of the address space of this process, less what code and threads take of it.
#[cfg(unix)]
fn address_space_bytes() -> u64 {
    const TAKEN: u64 = 256 << 20;
    let limit = rustix::process::getrlimit(rustix::process::Resource::As);
    limit
        .current
        .map_or(u64::MAX, |bytes| bytes.saturating_sub(TAKEN))
}

#[cfg(not(unix))]
fn address_space_bytes() -> u64 {
    u64::MAX
}

/// Refuses what does not fit into memory: `bytes` for `what`, which the value of `field` determines.
///
/// # Errors
/// [`Error::Invalid`] with the field.
pub(crate) fn check(field: &str, what: &str, bytes: f64) -> Result<(), Error> {
    let limit = limit_bytes() as f64;
    if bytes <= limit {
        return Ok(());
    }
    let problem = format!(
        "{what} would take {:.1} GB of memory, there are {:.1} GB",
        bytes * 1e-9,
        limit * 1e-9
    );
    Err(Error::invalid(
        "parameters",
        field,
        problem,
        "give a smaller number",
    ))
}
