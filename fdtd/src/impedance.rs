//! Impedance of the surface of a wall: one number, or branches of resistance, inertance and compliance.

use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Ratio of pressure to normal velocity into a locally reacting surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Impedance {
    /// The same at all frequencies, in Pa s/m, above 0.
    Real(f64),
    /// Branches in parallel: they share the pressure, and their velocities add.
    Branches(Vec<Branch>),
}

/// A branch of an impedance, `R + i omega L + s/(i omega)`, at least one of them above 0. A panel of a mass before an
/// air gap is a branch with all three.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Resistance R in Pa s/m, 0 or more.
    pub resistance_pasm: f64,
    /// Inertance L in kg/m^2, 0 or more: mass per area.
    pub inertance_kgpm2: f64,
    /// Stiffness s in Pa/m, 0 or more: the inverse of the compliance.
    pub stiffness_papm: f64,
}

impl Impedance {
    /// Value at a frequency in hertz, in Pa s/m.
    pub fn at(&self, frequency_hz: f64) -> Complex<f64> {
        match self {
            Self::Real(impedance_pasm) => Complex::new(*impedance_pasm, 0.0),
            Self::Branches(branches) => {
                let admittance: Complex<f64> = branches
                    .iter()
                    .map(|branch| branch.at(frequency_hz).inv())
                    .sum();
                admittance.inv()
            }
        }
    }

    /// All parameters in a fixed order, for fingerprints.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Real(impedance_pasm) => vec![*impedance_pasm],
            Self::Branches(branches) => branches.iter().flat_map(Branch::numbers).collect(),
        }
    }

    /// The branches; those that are pure resistances are merged into one, which comes last.
    pub(crate) fn branches(&self) -> Vec<Branch> {
        let branches = match self {
            Self::Real(impedance_pasm) => return vec![Branch::resistance(*impedance_pasm)],
            Self::Branches(branches) => branches,
        };
        let mut found = Vec::new();
        let mut resistance: Option<f64> = None;
        for branch in branches {
            if branch.inertance_kgpm2 == 0.0 && branch.stiffness_papm == 0.0 {
                let own = branch.resistance_pasm;
                resistance = Some(resistance.map_or(own, |other| own / (1.0 + own / other)));
            } else {
                found.push(*branch);
            }
        }
        found.extend(resistance.map(Branch::resistance));
        found
    }
}

impl Branch {
    /// A pure resistance in Pa s/m.
    pub fn resistance(resistance_pasm: f64) -> Self {
        Self {
            resistance_pasm,
            inertance_kgpm2: 0.0,
            stiffness_papm: 0.0,
        }
    }

    /// A branch that resonates at a frequency in hertz, where inertance and compliance have the reactances plus and
    /// minus `reactance_pasm`; resistance and reactance in Pa s/m.
    pub fn resonance(frequency_hz: f64, resistance_pasm: f64, reactance_pasm: f64) -> Self {
        let omega = TAU * frequency_hz;
        Self {
            resistance_pasm,
            inertance_kgpm2: reactance_pasm / omega,
            stiffness_papm: reactance_pasm * omega,
        }
    }

    /// Impedance at a frequency in hertz, in Pa s/m.
    pub fn at(&self, frequency_hz: f64) -> Complex<f64> {
        let omega = TAU * frequency_hz;
        let reactance = omega * self.inertance_kgpm2 - self.stiffness_papm / omega;
        Complex::new(self.resistance_pasm, reactance)
    }

    fn numbers(&self) -> [f64; 3] {
        [
            self.resistance_pasm,
            self.inertance_kgpm2,
            self.stiffness_papm,
        ]
    }
}
