//! Colours: the palette of Okabe and Ito, which colour-blind readers can distinguish, and a ramp of even lightness
//! steps for images.

use plotters::style::RGBColor;

/// Black: the truth, frames, walls.
pub const BLACK: RGBColor = RGBColor(0, 0, 0);
/// Blue: the Doppler method.
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Orange: the ToA-only method.
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// Vermillion: wheel odometry, single reflections.
pub const VERMILLION: RGBColor = RGBColor(213, 94, 0);
/// Bluish green.
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
/// Sky blue.
pub const SKY: RGBColor = RGBColor(86, 180, 233);
/// Reddish purple.
pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
/// Grey for the background.
pub const GREY: RGBColor = RGBColor(130, 130, 130);
/// Light grey for grid lines and areas.
pub const LIGHT: RGBColor = RGBColor(222, 222, 222);

/// A colour as pages write it.
pub fn css(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Colour of the ramp at `share` (0 to 1): dark violet over blue and green to light yellow, computed in the OKLCh space
/// so that lightness rises evenly (prints well in grey).
pub fn ramp(share: f64) -> RGBColor {
    let share = if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let lightness = 0.20 + 0.73 * share;
    let hue = (310.0 - 205.0 * share).to_radians();
    let chroma = 0.07 + 0.28 * share * (1.0 - share) + 0.05 * share;
    oklch(lightness, chroma.min(0.155), hue)
}

/// An OKLCh colour in sRGB, cut to its gamut.
fn oklch(lightness: f64, chroma: f64, hue_rad: f64) -> RGBColor {
    let (a, b) = (chroma * hue_rad.cos(), chroma * hue_rad.sin());
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let red = 4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s;
    let green = -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s;
    let blue = -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s;
    let byte = |linear: f64| {
        let value = linear.clamp(0.0, 1.0);
        let shown = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * shown).round() as u8
    };
    RGBColor(byte(red), byte(green), byte(blue))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_gets_lighter_all_the_way() {
        let luma = |share: f64| {
            let RGBColor(r, g, b) = ramp(share);
            0.2126 * f64::from(r).powf(2.2)
                + 0.7152 * f64::from(g).powf(2.2)
                + 0.0722 * f64::from(b).powf(2.2)
        };
        for step in 0..100 {
            assert!(
                luma(f64::from(step) / 100.0) <= luma(f64::from(step + 1) / 100.0) + 1.0,
                "{step}"
            );
        }
        assert!(luma(1.0) > 10.0 * luma(0.0));
        assert_eq!(ramp(f64::NAN), ramp(0.0));
    }
}
