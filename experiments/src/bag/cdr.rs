//! ROS 2 messages in their serial form (CDR): the few that a recording needs.

/// A header's time in seconds.
pub type Stamp = f64;

/// A pose: place, and quaternion x, y, z, w.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// The header's time.
    pub stamp_s: Stamp,
    /// Place in metres.
    pub place_m: [f64; 3],
    /// Attitude x, y, z, w.
    pub quaternion: [f64; 4],
}

/// Speeds of an odometry message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// Forward, in m/s.
    pub v_mps: f64,
    /// Counter-clockwise, in rad/s.
    pub omega_radps: f64,
}

/// Reads values one after the other; each is aligned to its size, counted from behind the four bytes that tell the byte
/// order.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    little: bool,
}

impl<'a> Cdr<'a> {
    fn new(message: &'a [u8]) -> Option<Self> {
        let (head, bytes) = message.split_at_checked(4)?;
        Some(Self {
            bytes,
            at: 0,
            little: head[1] & 1 == 1,
        })
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let start = self.at.next_multiple_of(N);
        let bytes = self.bytes.get(start..start.checked_add(N)?)?;
        self.at = start + N;
        bytes.try_into().ok()
    }

    fn u32(&mut self) -> Option<u32> {
        let bytes = self.take()?;
        Some(if self.little {
            u32::from_le_bytes(bytes)
        } else {
            u32::from_be_bytes(bytes)
        })
    }

    fn f64(&mut self) -> Option<f64> {
        let bytes = self.take()?;
        let value = if self.little {
            f64::from_le_bytes(bytes)
        } else {
            f64::from_be_bytes(bytes)
        };
        value.is_finite().then_some(value)
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        Some(numbers)
    }

    /// Bytes with their number before them.
    fn sequence(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()? as usize;
        let bytes = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(bytes)
    }

    /// std_msgs/Header.
    fn header(&mut self) -> Option<Stamp> {
        let (seconds, nanoseconds) = (self.u32()? as i32, self.u32()?);
        self.sequence()?;
        Some(f64::from(seconds) + 1e-9 * f64::from(nanoseconds))
    }
}

/// nav_msgs/Odometry.
pub fn odometry(message: &[u8]) -> Option<(Placed, Speeds)> {
    let mut cdr = Cdr::new(message)?;
    let stamp_s = cdr.header()?;
    cdr.sequence()?;
    let placed = Placed {
        stamp_s,
        place_m: cdr.numbers()?,
        quaternion: cdr.numbers()?,
    };
    // The covariance may be anything.
    for _ in 0..36 {
        cdr.take::<8>()?;
    }
    let [v_mps, _, _, _, _, omega_radps] = cdr.numbers()?;
    Some((placed, Speeds { v_mps, omega_radps }))
}

/// geometry_msgs/PoseStamped.
pub fn pose(message: &[u8]) -> Option<Placed> {
    let mut cdr = Cdr::new(message)?;
    Some(Placed {
        stamp_s: cdr.header()?,
        place_m: cdr.numbers()?,
        quaternion: cdr.numbers()?,
    })
}

/// geometry_msgs/TransformStamped.
pub fn transform(message: &[u8]) -> Option<Placed> {
    let mut cdr = Cdr::new(message)?;
    let stamp_s = cdr.header()?;
    cdr.sequence()?;
    Some(Placed {
        stamp_s,
        place_m: cdr.numbers()?,
        quaternion: cdr.numbers()?,
    })
}

/// audio_common_msgs/AudioData.
pub fn audio(message: &[u8]) -> Option<&[u8]> {
    Cdr::new(message)?.sequence()
}

#[cfg(test)]
mod tests {
    use super::super::written::Writer;
    use super::*;

    #[test]
    fn messages_are_read_and_cut_ones_are_not() {
        let pose_text = [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8];
        let written = Writer::default()
            .header(1_716_249_600, 500_000_000)
            .sequence(b"base_link\0")
            .numbers(&pose_text)
            .numbers(&[0.0; 36])
            .numbers(&[0.3, 0.0, 0.0, 0.0, 0.0, -0.2])
            .numbers(&[0.0; 36])
            .message();
        let (placed, speeds) = odometry(&written).unwrap();
        assert_eq!(placed.stamp_s, 1_716_249_600.5);
        assert_eq!(placed.quaternion, [0.0, 0.0, 0.6, 0.8]);
        assert_eq!(
            speeds,
            Speeds {
                v_mps: 0.3,
                omega_radps: -0.2
            }
        );
        let end = written.len() - 36 * 8;
        assert!((0..end).all(|cut| odometry(&written[..cut]).is_none()));
        let written = Writer::default().header(5, 0).numbers(&pose_text).message();
        assert_eq!(pose(&written).unwrap().place_m, [1.0, 2.0, 3.0]);
        let written = Writer::default().sequence(&[1, 2, 3]).message();
        assert_eq!(audio(&written), Some(&[1, 2, 3][..]));
        assert_eq!(audio(&[0, 1, 0, 0, 255, 255, 255, 255, 0]), None);
    }
}
