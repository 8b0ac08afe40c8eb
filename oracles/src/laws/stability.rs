//! No mode of the discrete operator grows.
//!
//! Layout: a room of 16 cells between layers of 8 to 32: open, with one wall, a closed right-angled corner, a slanted
//! wall in cut cells, or a slanted wall of an impedance; Courant numbers from 0.2 to the scheme's limit (with an
//! impedance, to the limit of scenes).
//! Formula: the step in `f64` with the weights as both engines have them in `f32` ([`PreciseField`]) starts from noise
//! on a constant. The memory of the layers decays with the rate `alpha`. Slow modes in the corners of the layers and
//! growing modes remain; the largest eigenvalue is that of the step on the space spanned by this state and its images
//! after some steps each (Arnoldi).
//! Bias: a mode that the initial state does not contain is missed; noise contains all.
//! With iwb all waves of two cells along an axis have one frequency and stand still: a large space
//! that hardly decays, in which the values of a small one say nothing. Its numbers are shown.
//! Tolerance: spectral radius at most 1 + 1e-12.

use rayon::prelude::*;

use super::measurement::{Depth, Measurement, schemes};
use fdtd::Error;
use fdtd::field::{FieldSetup, PreciseField};
use fdtd::grid::{Grid, Medium};
use fdtd::pml;
use fdtd::scheme::Scheme;
use fdtd::walls::{Impedance, Wall, WallModel};

/// Cells between the layers.
const ROOM: usize = 16;
/// Cell and step, which matter by the Courant number alone.
const DX_M: f64 = 0.005;
const DT_S: f64 = 1.0 / 120_000.0;
const RHO_KGPM3: f64 = 1.2;
/// Initial free steps, in time constants of the layers' frequency shift.
const DECAYS: f64 = 6.0;
/// Vectors of the space in which the largest eigenvalue is looked for.
const VECTORS: usize = 24;

/// Times that a setup is looked at, each after the decays of the time before, until it does not grow. The values of a
/// small space of an operator that is not normal may lie outside of its spectrum; what grows is there at every look.
const LOOKS: usize = 5;

/// Widths of the layers in cells.
pub const LAYERS: [usize; 4] = [8, 16, 24, 32];

/// Courant numbers of each scheme, room and width of layer when all are measured: each case has its own.
pub const COURANTS: usize = 200;

/// Steps from one vector of the space to the next: a seventh of a radian of the slowest possible mode.
const STRIDE: usize = 400;

/// Walls in the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Room {
    /// Nothing.
    Open,
    /// A straight wall.
    Wall,
    /// Two walls that meet at a right angle.
    Corner,
    /// A slanted wall in cut cells.
    CutCells,
    /// The same of an impedance, in the middle of the air's or far from it by turns.
    Impedance,
}

impl Room {
    /// All rooms.
    pub const ALL: [Self; 5] = [
        Self::Open,
        Self::Wall,
        Self::Corner,
        Self::CutCells,
        Self::Impedance,
    ];

    /// Name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Wall => "one wall",
            Self::Corner => "closed corner",
            Self::CutCells => "cut cells",
            Self::Impedance => "impedance",
        }
    }

    /// The walls, in cells from the room's lower left corner; `turn` varies place, slant and impedance,
    /// `gap` is the distance that a scene must leave between walls and layers.
    fn walls(self, turn: usize, gap: f64, rho_c: f64) -> Vec<Wall> {
        let shift = (turn % 7) as f64 / 7.0;
        let wall = |points: &[[f64; 2]]| Wall {
            points_m: points.to_vec(),
            thickness_m: 2.0,
            impedance: None,
        };
        // Upright and lying, in each half of the room.
        let place = |[x, y]: [f64; 2]| match turn % 4 {
            0 => [x, y],
            1 => [y, x],
            2 => [ROOM as f64 - x, y],
            _ => [y, ROOM as f64 - x],
        };
        let slanted = [[3.0 + shift, 3.0], [6.0 + 3.0 * shift, 13.0]].map(place);
        match self {
            Self::Open => Vec::new(),
            // From one side to the other, as near to the layers as a scene may have it, or free.
            Self::Wall if turn.is_multiple_of(3) => {
                vec![wall(&[[5.0, gap], [5.0, ROOM as f64 - gap]].map(place))]
            }
            // Along a layer, as near as it may be.
            Self::Wall if turn % 3 == 1 => {
                vec![wall(&[[gap + 1.0, 3.0], [gap + 1.0, 13.0]].map(place))]
            }
            Self::Wall => vec![wall(&[[5.0, 3.0], [5.0, 13.0]].map(place))],
            Self::Corner => vec![wall(&[[4.0, 13.0], [4.0, 4.0], [13.0, 4.0]].map(place))],
            Self::CutCells => vec![wall(&slanted)],
            Self::Impedance => {
                let ratio = [0.05, 0.3, 1.0, 4.0, 20.0][turn % 5];
                vec![Wall {
                    impedance: Some(Impedance::Real(ratio * rho_c)),
                    ..wall(&slanted)
                }]
            }
        }
    }

    /// Largest Courant number that a scene with such walls may have.
    pub fn max_courant(self, scheme: Scheme) -> f64 {
        let limit = scheme.max_courant();
        if self != Self::Impedance {
            return limit;
        }
        let enough = |part: &f64| scheme.polynomial(part * limit).allows_impedance();
        let parts = (0..=1000).map(|k| 1.0 - f64::from(k) * 1e-3);
        limit * parts.into_iter().find(enough).unwrap_or(0.0)
    }
}

/// The field at a Courant number, with layers of so many cells and walls in the room; `turn` varies the walls.
pub fn setup(
    scheme: Scheme,
    courant: f64,
    layer_cells: usize,
    room: Room,
    turn: usize,
) -> FieldSetup {
    let side = 2 * layer_cells.next_multiple_of(8) + ROOM;
    let grid = Grid {
        nx: side,
        ny: side,
        dx_m: DX_M,
        dt_s: DT_S,
    };
    let medium = Medium {
        c_mps: courant * DX_M / DT_S,
        rho_kgpm3: RHO_KGPM3,
    };
    let low = layer_cells.next_multiple_of(8) as f64;
    let mut walls = room.walls(
        turn,
        scheme.radius() as f64,
        medium.rho_kgpm3 * medium.c_mps,
    );
    for wall in &mut walls {
        wall.thickness_m *= DX_M;
        for point in &mut wall.points_m {
            *point = point.map(|cells| (low + cells) * DX_M);
        }
    }
    let model = match room {
        Room::CutCells | Room::Impedance => WallModel::CutCells,
        _ => WallModel::Staircase,
    };
    let cells = model.cells(&grid, &walls);
    FieldSetup::new(&grid, &medium, scheme, layer_cells, &cells)
}

/// Growth per step, as spectral radius - 1, of a setup at a Courant number, from noise that `turn` varies.
pub fn growth(setup: FieldSetup, courant: f64, turn: usize) -> f64 {
    let cells = setup.nx * setup.ny;
    let mut field = PreciseField::new(setup);
    // A constant, the mode that layers damp least, with noise of all wavelengths on it.
    let mut noise = 0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(turn as u64 + 1);
    let start: Vec<f64> = (0..cells)
        .map(|_| {
            noise = noise
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            1.0 + (noise >> 40) as f64 / f64::from(1 << 24) - 0.5
        })
        .collect();
    let mut vector = field.vector();
    vector[..cells].copy_from_slice(&start);
    field.set_vector(&vector);
    let settle = (DECAYS / (pml::ALPHA * courant)).ceil() as usize;
    let mut growth = f64::NAN;
    for _ in 0..LOOKS {
        (0..settle).for_each(|_| field.step());
        let start = field.vector();
        let of_stride = log_spectral_radius(start.clone(), |vector| {
            field.set_vector(vector);
            (0..STRIDE).for_each(|_| field.step());
            field.vector()
        });
        growth = (of_stride / STRIDE as f64).exp_m1();
        if growth < 0.0 {
            break;
        }
        field.set_vector(&start);
    }
    growth
}

/// Logarithm of the largest magnitude of the eigenvalues of a linear map, on the Krylov space of `start`.
fn log_spectral_radius(start: Vec<f64>, mut map: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let unit = |mut vector: Vec<f64>| {
        let length = dot(&vector, &vector).sqrt();
        vector.iter_mut().for_each(|x| *x /= length);
        (vector, length)
    };
    let mut basis = vec![unit(start).0];
    let mut hessenberg = vec![[0.0; VECTORS]; VECTORS];
    for column in 0..VECTORS {
        let mut image = map(&basis[column]);
        // Twice, because of rounding errors of the first round.
        for _ in 0..2 {
            for (row, vector) in basis.iter().enumerate() {
                let part = dot(vector, &image);
                hessenberg[row][column] += part;
                image
                    .iter_mut()
                    .zip(vector)
                    .for_each(|(x, v)| *x -= part * v);
            }
        }
        let (vector, length) = unit(image);
        if column + 1 == VECTORS || length < 1e-14 {
            break;
        }
        hessenberg[column + 1][column] = length;
        basis.push(vector);
    }
    // By squaring: H^(2^k) has the norm radius^(2^k), up to a factor that does not matter for large k.
    let mut power: Vec<Vec<f64>> = hessenberg.iter().map(|row| row.to_vec()).collect();
    let mut log = 0.0;
    let mut weight = 1.0;
    for _ in 0..50 {
        let size = power.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        log += weight * size.ln();
        weight *= 0.5;
        let scaled: Vec<Vec<f64>> = power
            .iter()
            .map(|row| row.iter().map(|x| x / size).collect())
            .collect();
        for (row, result) in power.iter_mut().enumerate() {
            for (column, entry) in result.iter_mut().enumerate() {
                *entry = (0..VECTORS)
                    .map(|k| scaled[row][k] * scaled[k][column])
                    .sum();
            }
        }
    }
    log
}

/// The law's measurements.
///
/// # Errors
/// None.
pub fn measure(depth: Depth) -> Result<Vec<Measurement>, Error> {
    let layers = match depth {
        Depth::Quick => &LAYERS[..1],
        Depth::Full => &LAYERS[..],
    };
    let mut cases = Vec::new();
    for scheme in schemes() {
        for &layer in layers {
            cases.extend(Room::ALL.map(|room| (scheme, layer, room)));
        }
    }
    let courants = if depth == Depth::Quick { 1 } else { COURANTS };
    let found = cases
        .into_par_iter()
        .enumerate()
        .map(|(case, (scheme, layer, room))| {
            let limit = room.max_courant(scheme);
            let growths = (0..courants).into_par_iter().map(|k| {
                // Each case its own numbers; with many the limit is among them.
                let part = (k as f64 + (case as f64 * 0.618_034).fract()) / (courants as f64 - 0.5);
                let courant = (0.2 + (limit - 0.2) * part).min(limit);
                let setup = setup(scheme, courant, layer, room, k + case);
                growth(setup, courant, k + case)
            });
            let most = growths.reduce(|| f64::NEG_INFINITY, f64::max);
            let room = room.name();
            let name = format!("{scheme}, layer of {layer}, {room}, {courants} Courant numbers");
            let quantity = "spectral radius - 1";
            match scheme {
                Scheme::Iwb => Measurement::shown(name, quantity, most),
                _ => Measurement::below(name, quantity, most, 1e-12),
            }
        })
        .collect();
    Ok(found)
}
