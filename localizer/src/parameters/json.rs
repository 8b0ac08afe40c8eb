//! Parameters as JSON: one flat object without the groups, as in parameter files, `map.json` and results.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::choices::{DirectWave, Integration, Method, Resampling, TimeReference, ToaImage};
use super::{FilterParameters, MeasurementParameters, Parameters, SignalParameters};

/// All fields in the order in which they are written. Those that are missing keep their default; unknown ones are
/// refused.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct FlatParameters {
    sample_rate_hz: f64,
    code_length: usize,
    chip_rate_hz: f64,
    carrier_hz: f64,
    speed_of_sound_mps: f64,
    periods: usize,
    directions: usize,
    cell_m: f64,
    window_half_width_m: f64,
    particles: usize,
    sigma_v_mps: f64,
    sigma_omega_radps: f64,
    bins: usize,
    method: Method,
    time_reference: TimeReference,
    direct_wave: DirectWave,
    direct_wave_time_s: f64,
    min_range_m: f64,
    max_range_m: f64,
    range_pool_m: f64,
    min_speed_mps: f64,
    integration: Integration,
    likelihood_exponent: f64,
    toa_image: ToaImage,
    resampling: Resampling,
    resample_threshold: f64,
    start_sigma_m: f64,
    start_sigma_rad: f64,
    sensor_offset_m: [f64; 2],
    #[serde(skip_serializing_if = "is_zero")]
    sensor_baseline_m: [f64; 2],
    /// Read from old files, where it had a single value; not written.
    #[serde(rename = "motion_model", skip_serializing)]
    _motion_model: MeanSpeed,
}

/// Zero is not written: files of robots with both transducers in one place stay as they were.
fn is_zero(place_m: &[f64; 2]) -> bool {
    *place_m == [0.0; 2]
}

/// The only value of the former field `motion_model`.
#[derive(Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum MeanSpeed {
    #[default]
    MeanSpeed,
}

impl Default for FlatParameters {
    fn default() -> Self {
        Self::from(&Parameters::default())
    }
}

/// The conversions between the groups and the flat object. They name every field of every structure: one that is
/// forgotten does not compile.
macro_rules! conversions {
    ($($group:ident: $structure:ident { $($field:ident),+ $(,)? })+) => {
        impl From<&Parameters> for FlatParameters {
            fn from(parameters: &Parameters) -> Self {
                let Parameters { $($group: $structure { $($field),+ },)+ transmitted: _ } = *parameters;
                Self { $($($field,)+)+ _motion_model: MeanSpeed::MeanSpeed }
            }
        }

        impl From<FlatParameters> for Parameters {
            fn from(flat: FlatParameters) -> Self {
                let FlatParameters { $($($field,)+)+ _motion_model: _ } = flat;
                Self { $($group: $structure { $($field),+ },)+ transmitted: None }
            }
        }
    };
}

conversions! {
    signal: SignalParameters {
        sample_rate_hz,
        code_length,
        chip_rate_hz,
        carrier_hz,
        speed_of_sound_mps,
        sensor_offset_m,
        sensor_baseline_m,
    }
    measurement: MeasurementParameters {
        periods,
        directions,
        cell_m,
        time_reference,
        direct_wave,
        direct_wave_time_s,
        min_range_m,
        max_range_m,
        range_pool_m,
        min_speed_mps,
        toa_image,
    }
    filter: FilterParameters {
        method,
        window_half_width_m,
        particles,
        sigma_v_mps,
        sigma_omega_radps,
        bins,
        integration,
        likelihood_exponent,
        resampling,
        resample_threshold,
        start_sigma_m,
        start_sigma_rad,
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        FlatParameters::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Parameters {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        FlatParameters::deserialize(deserializer).map(Self::from)
    }
}

/// The parameters that differ from `base` in one field, with its name: one for every field.
#[cfg(test)]
pub(crate) fn each_field_changed(base: &Parameters) -> Vec<(String, Parameters)> {
    use serde_json::{Map, Value, json};

    let changed = |name: &str, value: &Value| match (name, value) {
        ("method", _) => json!("toa-only"),
        ("time_reference", _) => json!("start"),
        ("direct_wave", _) => json!("keep"),
        ("integration", _) => json!("euler"),
        ("toa_image", _) => json!("strongest"),
        ("resampling", _) => json!("multinomial"),
        ("sensor_offset_m" | "sensor_baseline_m", _) => json!([0.1, 0.2]),
        (_, Value::Number(number)) if number.is_u64() => json!(number.as_u64().map(|n| n + 1)),
        (_, Value::Number(number)) => json!(number.as_f64().map(|x| 0.9 * x + 0.003)),
        _ => panic!("{name} needs another value here"),
    };
    let mut fields: Map<String, Value> = serde_json::from_value(json!(base)).unwrap();
    // Left out where it is zero.
    fields.insert(
        "sensor_baseline_m".into(),
        json!(base.signal.sensor_baseline_m),
    );
    let other = |name: &String| {
        let mut fields = fields.clone();
        fields[name] = changed(name, &fields[name]);
        serde_json::from_value(Value::Object(fields)).unwrap()
    };
    fields
        .keys()
        .map(|name| (name.clone(), other(name)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Map, Value, json};

    #[test]
    fn every_field_is_read_and_written_by_its_own_name() {
        let fields = |parameters: &Parameters| -> Map<String, Value> {
            let mut fields: Map<String, Value> = serde_json::from_value(json!(parameters)).unwrap();
            // Left out where it is zero.
            fields
                .entry("sensor_baseline_m")
                .or_insert(json!([0.0, 0.0]));
            fields
        };
        let default = fields(&Parameters::default());
        let all = each_field_changed(&Parameters::default());
        assert_eq!(all.len(), 30);
        for (name, parameters) in all {
            assert_ne!(parameters, Parameters::default(), "{name}");
            let differs = |field: &&String| fields(&parameters)[*field] != default[*field];
            assert_eq!(default.keys().filter(differs).collect::<Vec<_>>(), [&name]);
            let text = format!("{{\"{name}\": {}}}", fields(&parameters)[&name]);
            assert_eq!(
                serde_json::from_str::<Parameters>(&text).unwrap(),
                parameters
            );
        }
    }

    #[test]
    fn unknown_fields_are_refused_and_the_former_one_is_read() {
        let read = serde_json::from_str::<Parameters>;
        assert_eq!(read("{}").unwrap(), Parameters::default());
        assert_eq!(
            read(r#"{"motion_model": "mean-speed"}"#).unwrap(),
            Parameters::default()
        );
        assert!(read(r#"{"motion_model": "other"}"#).is_err());
        let message = read("{\n\"period\": 4}").unwrap_err().to_string();
        assert!(
            message.contains("unknown field `period`") && message.contains("line 2"),
            "{message}"
        );
        assert!(read(r#"{"signal": {}}"#).is_err());
    }
}
