//! Loops that may run as functions of their own.
//!
//! A tile's sweep is inlined into one large function for each instruction set and scheme. With sixteen vector registers the compiler then
//! keeps hardly a pointer or a weight of an inner loop in a register, but loads them from the stack for every vector; in a small
//! function it keeps them.

use super::vector::Vector;

/// A loop, with all that it needs.
pub(super) trait Task {
    /// Runs it.
    ///
    /// # Safety
    /// What the maker of the task has to promise, and the instruction set must be there.
    unsafe fn run(self);
}

/// Runs a task of the engine of vectors `V`: inline where there are many registers.
///
/// # Safety
/// As [`Task::run`].
#[inline(always)]
pub(super) unsafe fn run<V: Vector, T: Task>(task: T) {
    // SAFETY: the caller's promise.
    unsafe {
        if V::MANY {
            task.run();
        } else {
            V::apart(task);
        }
    }
}
