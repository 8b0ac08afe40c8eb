//! Numbers that one step can be taken with.

/// Arithmetic that the stencils need: `f32` in the reference engine, eight of them in the fast one. All operations
/// round like IEEE `f32`, lane by lane, therefore both give the same bytes.
pub(crate) trait Number: Copy {
    fn splat(value: f32) -> Self;
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    /// `self * factor + term`, rounded once.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `self * factor - term`, rounded once.
    fn mul_sub(self, factor: Self, term: Self) -> Self;
}

/// A number of rows in plain loops: `f32`, or `f64` for the spectrum of the step.
pub(crate) trait Real: Number + Default + Send {
    /// Whether its magnitude is below `bound`.
    fn is_below(self, bound: f32) -> bool;
}

impl Real for f32 {
    #[inline(always)]
    fn is_below(self, bound: f32) -> bool {
        self.abs() < bound
    }
}

impl Real for f64 {
    #[inline(always)]
    fn is_below(self, bound: f32) -> bool {
        self.abs() < f64::from(bound)
    }
}

macro_rules! number {
    ($float:ty) => {
        impl Number for $float {
            #[inline(always)]
            fn splat(value: f32) -> Self {
                Self::from(value)
            }
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                self + other
            }
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                self - other
            }
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                self * other
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                <$float>::mul_add(self, factor, term)
            }
            #[inline(always)]
            fn mul_sub(self, factor: Self, term: Self) -> Self {
                <$float>::mul_add(self, factor, -term)
            }
        }
    };
}
number!(f32);
number!(f64);
