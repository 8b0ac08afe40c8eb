//! The constants of a field, the same for all blocks of steps.

use super::super::setup::FieldSetup;
use super::blocking::{Blocking, Machine};
use super::instructions::InstructionSet;
use super::layout::RowLayout;
use super::pml_memory::{MemoryX, MemoryY};
use super::walls::Walls;
use crate::pml::Profile;

/// The constants of a field, the same for all blocks of steps.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) setup: FieldSetup,
    pub(super) layout: RowLayout,
    pub(super) blocking: Blocking,
    pub(super) memory_x: MemoryX,
    pub(super) memory_y: MemoryY,
    pub(super) high: Profile,
    pub(super) row_decay: Vec<Option<[f32; 3]>>,
    pub(super) walls: Walls,
    pub(super) instructions: InstructionSet,
}

impl Plan {
    pub(super) fn new(setup: FieldSetup, layout: RowLayout, machine: Machine) -> Self {
        Self {
            blocking: Blocking::new(setup.scheme, &layout, machine.first_level_bytes),
            high: setup.layer.mirrored(),
            memory_x: MemoryX::new(setup.layer.width()),
            memory_y: MemoryY::new(setup.layer.cells(), layout.stride),
            row_decay: (0..setup.ny)
                .map(|iy| setup.layer.row(setup.ny, iy))
                .collect(),
            walls: Walls::new(&setup.walls, &setup.surfaces, &layout),
            layout,
            instructions: machine.instructions,
            setup,
        }
    }
}
