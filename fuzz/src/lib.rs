//! Mutations of files, by which the targets in `tests/` reach past the first byte that a parser looks at.
//!
//! A mutated file is one of the seeds after a few edits: flipped bits, numbers and words that parsers stumble over,
//! parts left out, doubled, moved from another seed, or cut off. Which edits, the fuzzer decides: every engine of
//! `bolero`, coverage-guided ones included, searches among them.

/// An edit: where, which, and a number that it uses.
pub type Edit = (u32, u8, u32);
/// The choice of a seed and the edits on it.
pub type Plan = (u8, Vec<Edit>);

/// Most edits of one file.
const MOST_EDITS: usize = 12;
/// Most bytes of one file.
const MOST_BYTES: usize = 1 << 16;

/// Words that parsers stumble over.
const WORDS: [&str; 36] = [
    "0",
    "-0.0",
    "-1",
    "1e-300",
    "1e300",
    "1e999",
    "-1e999",
    "NaN",
    "nan",
    "inf",
    "null",
    "true",
    "\"\"",
    "\"x\"",
    "[]",
    "{}",
    "[[",
    "{\"a\":",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "0.1",
    "340282350000000000000000000000000000000",
    "1023",
    "262143",
    "524287",
    "1000000000",
    "\n",
    ",",
    "\"",
    "#",
    "\u{feff}",
    "\u{0}",
    "é",
];

/// A file made from the seeds by a plan. Without seeds, and for a plan without edits of the first, it is the seed
/// itself.
pub fn mutated(seeds: &[Vec<u8>], (first, edits): &Plan) -> Vec<u8> {
    let Some(count) = (!seeds.is_empty()).then_some(seeds.len()) else {
        return Vec::new();
    };
    let mut bytes = seeds[usize::from(*first) % count].clone();
    for &(place, kind, number) in edits.iter().take(MOST_EDITS) {
        let at = place as usize % (bytes.len() + 1);
        let length = 1 + number as usize % 24;
        let end = (at + length).min(bytes.len());
        match kind % 10 {
            0 if at < bytes.len() => bytes[at] ^= 1 << (number % 8),
            1 if at < bytes.len() => bytes[at] = number as u8,
            2 => bytes.insert(at, number as u8),
            3 => drop(bytes.drain(at..end)),
            4 => drop(bytes.splice(at..at, word(number))),
            5 | 6 => {
                let token = number_from(&bytes, at);
                drop(bytes.splice(token, word(number)));
            }
            7 => {
                let part = bytes[at..end].to_vec();
                drop(bytes.splice(at..at, part));
            }
            8 => {
                let other = &seeds[number as usize % count];
                let from = (number >> 8) as usize % (other.len() + 1);
                let part = &other[from..(from + length).min(other.len())];
                drop(bytes.splice(at..end, part.iter().copied()));
            }
            9 if number % 4 == 0 => bytes.truncate(at),
            _ => {
                // Binary lengths: four bytes at once.
                let value = if number % 3 == 0 { u32::MAX } else { number };
                for (byte, new) in bytes[at..end.min(at + 4)]
                    .iter_mut()
                    .zip(value.to_le_bytes())
                {
                    *byte = new;
                }
            }
        }
        bytes.truncate(MOST_BYTES);
    }
    bytes
}

fn word(number: u32) -> impl Iterator<Item = u8> {
    WORDS[number as usize % WORDS.len()].bytes()
}

/// The bytes of the first number at or after a place, which is empty where there is none.
fn number_from(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let of_number = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
    let start = bytes[at..].iter().position(u8::is_ascii_digit);
    let start = start.map_or(bytes.len(), |offset| at + offset);
    let length = bytes[start..].iter().position(|byte| !of_number(byte));
    start..length.map_or(bytes.len(), |length| start + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_reach_numbers_and_keep_within_bounds() {
        let seeds = vec![b"{\"rate\": 40000.5, \"n\": 3}".to_vec(), b"t,x\n".to_vec()];
        assert_eq!(mutated(&seeds, &(0, Vec::new())), seeds[0]);
        let replaced = mutated(&seeds, &(0, vec![(3, 5, 3)]));
        assert_eq!(replaced, b"{\"rate\": 1e-300, \"n\": 3}");
        assert!(mutated(&[], &(0, vec![(1, 2, 3)])).is_empty());
        for kind in 0..20 {
            for place in [0, 5, 1000, u32::MAX] {
                for number in [0, 1, 7, 255, u32::MAX] {
                    let edits = vec![(place, kind, number); 30];
                    assert!(mutated(&seeds, &(9, edits)).len() < 2000);
                }
            }
        }
    }
}
