//! Setting of a case of a law, drawn by the case's name: conditions, orientation of the layout on the grid, enlargement
//! of the domain, and free places in it.
//!
//! A layout is drawn with its walls above or on the right, say; mirrored and transposed it lies in any of eight ways,
//! and walls in any half. The draw depends on nothing but the names of law and case.

use std::hash::Hasher;

use fnv::FnvHasher;

use super::conditions::{CONDITIONS, Conditions};
use fdtd::motion::MotionState;
use fdtd::scheme::Scheme;

/// Orientation of a layout on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Turn {
    /// Whether x and y are mirrored.
    pub mirrored: [bool; 2],
    /// Whether x and y then change places.
    pub transposed: bool,
}

/// Setting of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Medium and grid.
    pub conditions: Conditions,
    /// Orientation of the layout.
    pub turn: Turn,
    /// Cells that the domain has beyond the layout along its x and y, fewer than 8.
    pub more_cells: [usize; 2],
    /// Free places along x and y, 0 to 1 from one end to the other.
    pub share: [f64; 2],
}

impl Turn {
    /// As drawn.
    pub const NONE: Self = Self {
        mirrored: [false; 2],
        transposed: false,
    };

    /// Of a layout of a size, the point `[x, y]` on the grid.
    pub fn point(self, size: [f64; 2], point: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| match self.mirrored[axis] {
            true => size[axis] - point[axis],
            false => point[axis],
        });
        if self.transposed { [y, x] } else { [x, y] }
    }

    /// A size on the grid.
    pub fn size<T>(self, [x, y]: [T; 2]) -> [T; 2] {
        if self.transposed { [y, x] } else { [x, y] }
    }

    /// The cell of a layout of so many cells that is the cell `[ix, iy]` of the grid.
    pub fn cell_of(self, size: [usize; 2], cell: [usize; 2]) -> [usize; 2] {
        let cell = self.size(cell);
        [0, 1].map(|axis| match self.mirrored[axis] {
            true => size[axis] - 1 - cell[axis],
            false => cell[axis],
        })
    }

    /// Whether left and right change sides.
    pub fn swaps_sides(self) -> bool {
        (self.mirrored[0] != self.mirrored[1]) != self.transposed
    }

    /// A robot's offset `[forward, left]`.
    pub fn offset(self, [forward, left]: [f64; 2]) -> [f64; 2] {
        [forward, if self.swaps_sides() { -left } else { left }]
    }

    /// A robot's pose and speeds in a layout of a size in metres.
    pub fn pose(self, size_m: [f64; 2], pose: &MotionState) -> MotionState {
        let [x_m, y_m] = self.point(size_m, [pose.x_m, pose.y_m]);
        let (sin, cos) = pose.heading_rad.sin_cos();
        let [cos, sin] = self.point([0.0; 2], [cos, sin]);
        let sign = if self.swaps_sides() { -1.0 } else { 1.0 };
        MotionState {
            x_m,
            y_m,
            heading_rad: sin.atan2(cos),
            v_mps: pose.v_mps,
            omega_radps: sign * pose.omega_radps,
        }
    }
}

impl std::fmt::Display for Turn {
    /// Where x and y of the layout point: `+x+y` as drawn, `-y+x` when x points down and y to the right.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = |axis: usize| if self.mirrored[axis] { '-' } else { '+' };
        let [x, y] = self.size(['x', 'y']);
        write!(formatter, "{}{x}{}{y}", sign(0), sign(1))
    }
}

impl Setting {
    /// The papers' grid, the layout as drawn, free places in the middle.
    pub const PAPERS: Self = Self {
        conditions: Conditions::PAPERS,
        turn: Turn::NONE,
        more_cells: [0; 2],
        share: [0.5; 2],
    };

    /// Setting of a case.
    pub fn drawn(law: &str, case: &str) -> Self {
        Self::among(&CONDITIONS, law, case)
    }

    /// Setting of a case with walls of an impedance: among the conditions that the scheme allows for them.
    pub fn before_surfaces(scheme: Scheme, law: &str, case: &str) -> Self {
        let mut allowed = CONDITIONS.to_vec();
        allowed.retain(|conditions| conditions.allows_impedance(scheme));
        Self::among(&allowed, law, case)
    }

    /// Setting of a case that relies on accurate walls of an impedance.
    pub fn before_accurate_surfaces(law: &str, case: &str) -> Self {
        let mut accurate = CONDITIONS.to_vec();
        accurate.retain(Conditions::has_accurate_impedances);
        Self::among(&accurate, law, case)
    }

    fn among(conditions: &[Conditions], law: &str, case: &str) -> Self {
        let mut draw = Draw::new(law, case);
        Self {
            conditions: conditions[draw.below(conditions.len())],
            turn: Turn {
                mirrored: [draw.below(2) == 1, draw.below(2) == 1],
                transposed: draw.below(2) == 1,
            },
            more_cells: [draw.below(8), draw.below(8)],
            share: [0, 1].map(|_| draw.below(1000) as f64 / 999.0),
        }
    }

    /// A place between two ends along x and y, of the papers' grid in metres, in metres here.
    pub fn between(&self, ends: [[f64; 2]; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let [from, to] = ends[axis];
            self.conditions.m(from + self.share[axis] * (to - from))
        })
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let c_mps = self.conditions.medium.c_mps;
        write!(formatter, "{c_mps} m/s {}", self.turn)
    }
}

/// Numbers that follow from two names (FNV-1a, then splitmix64).
struct Draw {
    state: u64,
}

impl Draw {
    fn new(law: &str, case: &str) -> Self {
        let mut hasher = FnvHasher::default();
        for name in [law, "\0", case] {
            hasher.write(name.as_bytes());
        }
        let state = hasher.finish();
        Self { state }
    }

    /// The next number below `count`.
    fn below(&mut self, count: usize) -> usize {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
        ((mixed >> 32) as usize * count) >> 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{HashMap, HashSet};

    #[test]
    fn draws_are_spread_evenly() {
        let mut times = HashMap::new();
        let mut turns = HashMap::new();
        for scheme in Scheme::ALL {
            let mut of_scheme = HashSet::new();
            for number in 0..60 {
                let setting = Setting::drawn("law", &format!("{scheme}, {number} degrees"));
                let c_mps = setting.conditions.medium.c_mps.to_string();
                of_scheme.insert(c_mps.clone());
                *times.entry(c_mps).or_insert(0) += 1;
                *turns.entry(setting.turn).or_insert(0) += 1;
            }
            assert!(of_scheme.len() >= 10, "{scheme}: {of_scheme:?}");
        }
        assert_eq!((times.len(), turns.len()), (CONDITIONS.len(), 8));
        assert!(
            times.values().all(|times| (10..=45).contains(times)),
            "{times:?}"
        );
        assert!(
            turns.values().all(|times| (19..=60).contains(times)),
            "{turns:?}"
        );
    }

    #[test]
    fn the_same_names_draw_the_same() {
        let one = Setting::drawn("law", "case");
        assert_eq!(one, Setting::drawn("law", "case"));
        assert_ne!(one, Setting::drawn("la", "wcase"));
    }

    #[test]
    fn cells_points_and_poses_turn_alike() {
        for number in 0..8 {
            let turn = Turn {
                mirrored: [number & 1 != 0, number & 2 != 0],
                transposed: number & 4 != 0,
            };
            let size = [7, 4];
            let on_grid = turn.point([7.0, 4.0], [2.5, 1.5]);
            let cell = on_grid.map(|x| x as usize);
            assert_eq!(turn.cell_of(size, cell), [2, 1], "{turn}");
            let pose = MotionState {
                x_m: 2.5,
                y_m: 1.5,
                heading_rad: 0.3,
                v_mps: 0.4,
                omega_radps: 0.7,
            };
            let offset_m = [0.2, 0.1];
            let turned = turn.pose([7.0, 4.0], &pose).point(turn.offset(offset_m));
            let point = turn.point([7.0, 4.0], pose.point(offset_m));
            for axis in [0, 1] {
                assert!((turned[axis] - point[axis]).abs() < 1e-12, "{turn}");
            }
        }
        assert_eq!(Turn::NONE.to_string(), "+x+y");
    }
}
