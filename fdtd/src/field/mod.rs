//! The sound field: the definition of one step, and the two engines that take it.
//!
//! One step at every cell, in this order of operations (all of them fused multiply-adds, so that both engines, any
//! thread count and any instruction set give the same bytes):
//! 1. the plain stencil of the scheme,
//! 2. the layer along y,
//! 3. the layers along x,
//! 4. the corrections and surfaces at walls,
//! 5. the source's injections,
//! 6. zero in solid cells,
//! 7. the receiver reads.
//!
//! *Subnormal numbers.* Ahead of the first wave front the field falls off through all magnitudes to zero. Some
//! processors take a hundred cycles for every operation on a number below the normal range, which slows down the first
//! thousands of steps (`docs/findings/subnormal-numbers.md`). A step that is [`StepForcing::flush`] therefore sets to
//! zero what is below [`FLUSH_BELOW_PA`]: in the layers' memory before 2, in the pressure after 3, and once more after
//! 4 in the cells that 4 changed and in the surfaces' memory; [`flushes_subnormals`] says when that must be. It is part
//! of the step, not of an engine or a processor's mode. The numbers set to zero are far below the last digit of the
//! signal, whose roundings change nevertheless. Long drives, to which the start is nothing, go without
//! ([`crate::simulation`]).
//!
//! [`ReferenceField`] does this row by row in plain order and is the oracle of [`FastField`], which advances several
//! steps at once in cache (see [`fast`]).

pub mod fast;
pub mod probe;
pub mod reference;
mod setup;
mod stencil;
mod step;

pub use fast::FastField;
pub use reference::{PreciseField, ReferenceField};
pub use setup::FieldSetup;
pub use step::{FLUSH_BELOW_PA, Field, FieldState, Injection, StepForcing, flushes_subnormals};
