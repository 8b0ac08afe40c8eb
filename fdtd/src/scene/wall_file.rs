//! Walls of a scene file and their surfaces.

use crate::walls::{Branch, Impedance, Wall};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A wall along a polyline, rigid unless it has an impedance, absorbs, or has branches.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Wall")]
pub(super) struct WallFile {
    /// Corner points `[x, y]` of the middle line in metres; the first again at the end closes the wall.
    points_m: Vec<[f64; 2]>,
    /// Thickness in metres.
    #[serde(default = "default_thickness_m")]
    thickness_m: f64,
    /// Impedance of the surface in Pa s/m, above 0; rigid when neither this nor `absorption` nor `branches` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    impedance_pasm: Option<f64>,
    /// Part of the energy that the surface absorbs at normal incidence, 0 to 1, instead of `impedance_pasm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    absorption: Option<f64>,
    /// Branches in parallel that make up the impedance of the surface over frequency, instead of `impedance_pasm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<BranchFile>")]
    branches: Option<Vec<BranchFile>>,
}

/// A branch of an impedance, `R + i omega L + 1/(i omega C)`; what is left out is not in it.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Branch")]
struct BranchFile {
    /// Resistance R in Pa s/m, 0 or more.
    #[serde(default)]
    resistance_pasm: f64,
    /// Inertance L in kg/m^2 (Pa s^2/m), 0 or more: mass per area.
    #[serde(default)]
    inertance_kgpm2: f64,
    /// Compliance C in m/Pa, above 0; none is no spring.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64")]
    compliance_mppa: Option<f64>,
}

fn default_thickness_m() -> f64 {
    0.02
}

/// Largest resistance and inertance, in their units; stiffness in Pa/m may be as large squared. Far beyond any wall,
/// and within the range of the arithmetic.
const MOST: f64 = 1e9;

/// Field, problem and remedy.
type Refusal = [String; 3];

fn refuse<T>(field: impl Into<String>, problem: String, remedy: &str) -> Result<T, Refusal> {
    Err([field.into(), problem, remedy.to_string()])
}

impl WallFile {
    /// The wall in air of `rho c` in Pa s/m; or field, problem and remedy.
    pub(super) fn into_wall(self, characteristic_pasm: f64) -> Result<Wall, Refusal> {
        Ok(Wall {
            impedance: self.impedance(characteristic_pasm)?,
            points_m: self.points_m,
            thickness_m: self.thickness_m,
        })
    }

    /// The surface's impedance, `None` when it is rigid.
    fn impedance(&self, characteristic_pasm: f64) -> Result<Option<Impedance>, Refusal> {
        let real = self.impedance_pasm(characteristic_pasm)?;
        let Some(branches) = &self.branches else {
            return Ok(real.map(Impedance::Real));
        };
        let given = [
            ("impedance_pasm", self.impedance_pasm),
            ("absorption", self.absorption),
        ];
        if let Some((other, _)) = given.iter().find(|(_, value)| value.is_some()) {
            let problem = format!("is given beside {other}");
            return refuse("branches", problem, "give one of them");
        }
        if branches.is_empty() {
            let remedy = "give one or more, or leave the list out for a rigid wall";
            return refuse("branches", "holds no branch".to_string(), remedy);
        }
        let branches = branches.iter().enumerate().map(|(index, branch)| {
            let inside = |[field, problem, remedy]: Refusal| {
                [format!("branches[{index}]{field}"), problem, remedy]
            };
            branch.resolve().map_err(inside)
        });
        Ok(Some(Impedance::Branches(
            branches.collect::<Result<_, _>>()?,
        )))
    }

    /// The surface's impedance in Pa s/m where it is the same at all frequencies.
    fn impedance_pasm(&self, characteristic_pasm: f64) -> Result<Option<f64>, Refusal> {
        match (self.impedance_pasm, self.absorption) {
            (None, None) => Ok(None),
            (Some(_), Some(_)) => refuse(
                "absorption",
                "is given beside impedance_pasm".to_string(),
                "give one of them",
            ),
            // Written so that NaN is refused.
            (Some(impedance_pasm), None) => {
                if impedance_pasm > 0.0 && impedance_pasm.is_finite() {
                    return Ok(Some(impedance_pasm));
                }
                let problem = format!("{impedance_pasm} Pa s/m is no impedance of a passive wall");
                refuse(
                    "impedance_pasm",
                    problem,
                    "give a number above 0, or none for a rigid wall",
                )
            }
            (None, Some(absorption)) => {
                if !(0.0..=1.0).contains(&absorption) {
                    let problem = format!("{absorption} is no part of the energy");
                    return refuse("absorption", problem, "give a number from 0 to 1");
                }
                // Harder than air: the reflection factor is positive.
                let factor = (1.0 - absorption).sqrt();
                let impedance_pasm = characteristic_pasm * (1.0 + factor) / (1.0 - factor);
                Ok(impedance_pasm.is_finite().then_some(impedance_pasm))
            }
        }
    }
}

impl BranchFile {
    /// The branch; or field after its place in the list, problem and remedy.
    fn resolve(&self) -> Result<Branch, Refusal> {
        for (field, value, unit) in [
            (".resistance_pasm", self.resistance_pasm, "Pa s/m"),
            (".inertance_kgpm2", self.inertance_kgpm2, "kg/m^2"),
        ] {
            if !(0.0..=MOST).contains(&value) {
                let problem = format!("{value:?} {unit} is out of range");
                return refuse(field, problem, &format!("give a number from 0 to {MOST:e}"));
            }
        }
        let compliances = MOST.powi(-2)..=MOST;
        if let Some(value) = self.compliance_mppa
            && !compliances.contains(&value)
        {
            let problem = format!("{value:?} m/Pa is out of range");
            let (least, most) = (compliances.start(), compliances.end());
            let remedy = format!("give a number from {least:e} to {most:e}, or none for no spring");
            return refuse(".compliance_mppa", problem, &remedy);
        }
        let branch = Branch {
            resistance_pasm: self.resistance_pasm,
            inertance_kgpm2: self.inertance_kgpm2,
            stiffness_papm: self.compliance_mppa.map_or(0.0, f64::recip),
        };
        if branch == Branch::resistance(0.0) {
            let remedy = "give one or more of resistance_pasm, inertance_kgpm2 and compliance_mppa";
            return refuse("", "resists nothing".to_string(), remedy);
        }
        Ok(branch)
    }
}
