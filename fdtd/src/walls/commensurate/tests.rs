//! Tests of the weights and masses before walls of a simple slope, by the analysis of one period.

use super::*;
use crate::scheme::Scheme;
use crate::walls::operator::WallOperator;

/// Walls of slopes 1 to 1, 1 to 2 and 1 to 3, to all sides: the errors up to 11 kHz and 70 degrees, as the analysis has them, are small, and half of
/// those with the weights and masses of other walls at most.
#[test]
fn walls_of_a_simple_slope_reflect_as_they_should() {
    let slopes = [
        [1.0, 1.0],
        [-1.0, 1.0],
        [2.0, -1.0],
        [-1.0, -2.0],
        [1.0, -3.0],
    ];
    for (normal, distance) in slopes.into_iter().zip([0.2, 0.3, -0.1, 0.05, 0.25]) {
        let wall = endless(normal, distance);
        let [before, after] = wall.worst(Scheme::O13);
        assert!(
            after < 0.035 && after < 0.5 * before,
            "{normal:?}: {before} {after}"
        );
        // A piece of the endless wall is one of it, and a place nearer to the wall is not.
        let own = &wall.walls.loads()[wall.pieces[0]];
        assert_eq!(wall.place(own), Some(0));
        assert!(wall.is_alike(&wall.walls, own, 0));
        assert!(!wall.is_alike(&half_plane(wall.normal, distance - 0.05), own, 0));
    }
    assert_eq!(period([0.6, 0.8]), None);
}

/// Along the diagonal the search is hardest where the wall passes by the corners of cells: one piece is long, the other small or dropped.
#[test]
fn the_diagonal_reflects_as_it_should_by_the_corners_of_cells() {
    for (scheme, distance) in [
        (Scheme::O13, 0.03),
        (Scheme::D25, 0.0),
        (Scheme::D25, 0.059),
    ] {
        let [_, after] = endless([1.0, 1.0], distance).worst(scheme);
        assert!(after < 0.03, "{scheme}, {distance}: {after}");
    }
}

/// Cells with hardly any air are dropped: those beside them keep the wall's normal, and take over their surface.
#[test]
fn cells_beside_dropped_ones_keep_the_normal() {
    // The wall leaves a triangle of 0.012 by 0.004 cells in one cell of three.
    let normal = [1.0, 3.0].map(|part: f64| part / 10_f64.sqrt());
    let wall = endless([1.0, 3.0], 0.004 * normal[1]);
    let own = |index: &usize| &wall.walls.loads()[*index];
    assert_eq!(wall.pieces.len(), 3);
    let length: f64 = wall.pieces.iter().map(|index| own(index).length).sum();
    assert!((length - 10_f64.sqrt()).abs() < 1e-9, "{length}");
    for load in wall.pieces.iter().map(own) {
        let off = [0, 1].map(|axis| (load.normal[axis] - normal[axis]).abs());
        // Lines are cut a ten-millionth of a cell beside faces.
        assert!(off[0].max(off[1]) < 1e-6, "{load:?}");
    }
}

/// The wall of a simple slope at a distance from the middle of a cell.
fn endless(normal: [f64; 2], distance: f64) -> Endless {
    let length = f64::hypot(normal[0], normal[1]);
    let load = Load {
        impedance: Impedance::Real(1.0),
        length: 1.0,
        cell: [HALF; 2],
        normal: normal.map(|part| part / length),
        distance,
    };
    Endless::new(&load, period(load.normal).expect("a simple slope"))
}

impl Endless {
    /// The largest errors with the weights and masses of other walls, and with its own.
    fn worst(&self, scheme: Scheme) -> [f64; 2] {
        let courant = 340.0 / 120e3 / 0.005;
        let (polynomial, weights) = (scheme.polynomial(courant), scheme.weights(courant));
        let radius = scheme.radius();
        let rows_of = |walls: &WallCells| -> Box<dyn Fn([usize; 2]) -> Row> {
            let operator = WallOperator::new(walls, &weights, &polynomial, radius);
            Box::new(operator.rows(walls.clone(), &weights, &polynomial, radius))
        };
        let (polynomial, footprints) = (&polynomial, &Footprints::new(&polynomial));
        let rows = rows_of(&self.walls);
        let before = self.start(&*rows, polynomial, footprints, FRAME);
        let solution = self.solution(&rows_of, polynomial, footprints);
        let pieces = self
            .pieces
            .iter()
            .zip(solution)
            .map(|(&index, (taps, mass))| {
                let load = &self.walls.loads()[index];
                let cell = |axis: usize, offset: isize| load.cell[axis].strict_add_signed(offset);
                let reach = taps
                    .iter()
                    .map(|&([dx, dy], weight)| ([cell(0, dx), cell(1, dy)], weight));
                let piece = Piece {
                    cell: load.cell,
                    length: load.length,
                    reach: reach.collect(),
                };
                (piece, *mass)
            });
        let pieces: Vec<(Piece, f64)> = pieces.collect();
        let after: Vec<(&Piece, f64)> = pieces.iter().map(|(piece, mass)| (piece, *mass)).collect();
        let wall = (self.normal, self.distance);
        let strip = Strip::new(
            &self.walls,
            &*rows,
            polynomial,
            wall,
            self.period,
            [HALF as isize; 2],
        );
        let after = Pieces::new(&self.walls, &strip, polynomial, &after);
        [before.worst(), after.worst()]
    }
}
