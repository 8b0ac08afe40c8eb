//! Planes in space and the reflections in them (2021, eq. (2)).

/// A plane `a x + b y + c z + d = 0` with a unit normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    normal: [f64; 3],
    offset_m: f64,
}

/// An affine map of space, `linear p + shift`: one reflection, or several in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Linear part, `[row][column]`.
    pub linear: [[f64; 3]; 3],
    /// Shift in metres.
    pub shift_m: [f64; 3],
}

impl Plane {
    /// The plane with the given coefficients; `None` where the normal has no direction.
    pub fn new(normal: [f64; 3], offset_m: f64) -> Option<Self> {
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        (length > 0.0 && length.is_finite() && offset_m.is_finite()).then(|| Self {
            normal: normal.map(|n| n / length),
            offset_m: offset_m / length,
        })
    }

    /// True for walls, false for ceilings and floors.
    pub fn is_vertical(&self) -> bool {
        self.normal[2].abs() < 1e-9
    }

    /// `R_j` of eq. (2).
    pub fn reflection(&self) -> Reflection {
        let n = self.normal;
        let mut linear = [[0.0; 3]; 3];
        for (i, row) in linear.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = f64::from(u8::from(i == j)) - 2.0 * n[i] * n[j];
            }
        }
        Reflection {
            linear,
            shift_m: n.map(|n| -2.0 * self.offset_m * n),
        }
    }
}

impl Reflection {
    /// The image of a point.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            (0..3).map(|j| self.linear[i][j] * point[j]).sum::<f64>() + self.shift_m[i]
        })
    }

    /// This reflection first, `next` after it: `R_next R_self`.
    pub fn then(&self, next: &Self) -> Self {
        Self {
            linear: std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..3).map(|k| next.linear[i][k] * self.linear[k][j]).sum())
            }),
            shift_m: next.apply(self.shift_m),
        }
    }
}
