//! Laws of physics as measurements of the field, which the tests assert and `echolot validate` prints.
//!
//! Each file measures one kind of law and says layout, formula, known bias and tolerance at its top. A measurement is a
//! number with the range that it may have. Each case draws a medium, a grid and how its layout lies on it
//! ([`setting`]).

pub mod branches;
pub mod conditions;
pub mod corner;
pub mod direct_method;
pub mod dispersion;
pub mod drift;
pub mod echo;
pub mod free_field;
pub mod half_plane;
pub mod impedance;
pub mod layer;
mod measurement;
pub mod rig;
pub mod room;
pub mod round;
pub mod scene_echoes;
pub mod setting;
pub mod silence;
pub mod stability;
pub mod tilted;
pub mod tilted_impedance;

pub use measurement::{Depth, Measurement};

use fdtd::Error;

/// A law: its name and how it is measured.
#[derive(Debug, Clone, Copy)]
pub struct Law {
    /// Name in the table.
    pub name: &'static str,
    /// About how many seconds of one processor it takes, few cases and all: shares of a whole.
    pub effort: [u16; 2],
    /// Measures it.
    pub measure: fn(Depth) -> Result<Vec<Measurement>, Error>,
}

/// All laws, in the table's order.
pub const LAWS: [Law; 21] = [
    Law {
        name: "line source in free field, at rest and moving",
        effort: [1, 2],
        measure: free_field::measure,
    },
    Law {
        name: "direct method: level and sidebands",
        effort: [2, 6],
        measure: direct_method::measure,
    },
    Law {
        name: "echo of a wall: image source",
        effort: [1, 2],
        measure: echo::measure_image,
    },
    Law {
        name: "echo and scatter of a tilted wall",
        effort: [4, 20],
        measure: tilted::measure,
    },
    Law {
        name: "round walls: cylinder and round room",
        effort: [9, 40],
        measure: round::measure,
    },
    Law {
        name: "reflection of an impedance",
        effort: [12, 240],
        measure: impedance::measure,
    },
    Law {
        name: "reflection of R-L-C branches",
        effort: [5, 150],
        measure: branches::measure,
    },
    Law {
        name: "echo of a tilted wall of an impedance",
        effort: [26, 400],
        measure: tilted_impedance::measure,
    },
    Law {
        name: "two parallel walls: time scale 1",
        effort: [2, 2],
        measure: echo::measure_parallel,
    },
    Law {
        name: "right-angled corner: image sources",
        effort: [1, 4],
        measure: corner::measure,
    },
    Law {
        name: "edge of a half plane: Sommerfeld",
        effort: [1, 6],
        measure: half_plane::measure,
    },
    Law {
        name: "echoes of the scene: image sources",
        effort: [2, 6],
        measure: scene_echoes::measure,
    },
    Law {
        name: "absorbing layer",
        effort: [3, 6],
        measure: layer::measure,
    },
    Law {
        name: "no growing mode",
        effort: [10, 1000],
        measure: stability::measure,
    },
    Law {
        name: "silence after a burst",
        effort: [4, 600],
        measure: silence::measure,
    },
    Law {
        name: "modes of a rigid box",
        effort: [1, 1],
        measure: room::measure_modes,
    },
    Law {
        name: "energy between rigid walls",
        effort: [1, 4],
        measure: room::measure_energy,
    },
    Law {
        name: "a million steps without drift",
        effort: [1, 20],
        measure: drift::measure,
    },
    Law {
        name: "reciprocity",
        effort: [1, 3],
        measure: free_field::measure_reciprocity,
    },
    Law {
        name: "dispersion relation",
        effort: [3, 3],
        measure: dispersion::measure,
    },
    Law {
        name: "order of convergence",
        effort: [1, 1],
        measure: room::measure_order,
    },
];
