//! Possible inputs of a user: files of the corpus with a few changes.

use crate::random::Random;

/// Numbers at the limits of what a program expects.
const HARD_NUMBERS: [&str; 26] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-3",
    "1e-5",
    "1e-6",
    "1e-9",
    "1e-12",
    "1e-38",
    "1e-300",
    "5e-324",
    "1e3",
    "1e6",
    "1e9",
    "1e15",
    "1e16",
    "1e38",
    "1e300",
    "1e308",
    "1e999",
    "4294967296",
    "9007199254740993",
    "0.9999999",
];
/// Texts for the same purpose in JSON, OBJ and photometric files.
const HARD_WORDS: [&str; 16] = [
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "NaN",
    "inf",
    "-",
    ",",
    "\n",
    "\0",
    "f 1 1 1\n",
    "TILT=INCLUDE",
    "\"room\"",
    "\u{feff}",
    "é",
];

/// The same for the four bytes of a number in binary files: floats and counts that programs do not expect.
const HARD_WORDS_OF_BITS: [u32; 14] = [
    0,
    1,
    0x8000_0000, // −0, or −2³¹
    0x3f80_0000, // 1
    0x0000_0001, // the smallest float
    0x7f7f_ffff, // the largest
    0x7f80_0000, // infinity
    0xff80_0000,
    0x7fc0_0000, // NaN
    0x5368_d4a5, // 10¹²
    0x322b_cc77, // 10⁻⁸
    0x7fff_ffff,
    0xffff_ffff,
    0x0010_0000,
];

/// Changes a file in one to four places. Most changes are of numbers, because other changes are soon refused.
pub fn mutate(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(4) {
        // Files of binary numbers are not text.
        let is_binary = std::str::from_utf8(&bytes).is_err();
        match random.below(16) {
            0..=9 if is_binary => change_bits(&mut bytes, random),
            0 => change_name(&mut bytes, random),
            1..=10 => change_number(&mut bytes, random),
            11 => flip(&mut bytes, random),
            12 => remove(&mut bytes, random),
            13 => repeat(&mut bytes, random),
            14 => insert_word(&mut bytes, random),
            _ => cut_off(&mut bytes, random),
        }
    }
    bytes
}

/// Positions of all numbers.
fn numbers(bytes: &[u8]) -> Vec<(usize, usize)> {
    let is_part = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let length = bytes[at..].iter().take_while(|byte| is_part(**byte)).count();
        if bytes[at..at + length].iter().any(u8::is_ascii_digit) {
            found.push((at, at + length));
        }
        at += length.max(1);
    }
    found
}

fn change_number(bytes: &mut Vec<u8>, random: &mut Random) {
    let found = numbers(bytes);
    if found.is_empty() {
        return;
    }
    let (from, to) = found[random.below(found.len())];
    let old: f64 = std::str::from_utf8(&bytes[from..to]).ok().and_then(|text| text.parse().ok()).unwrap_or(1.0);
    let new = match random.below(4) {
        0 => format!("{}", old * (random.unit() * 2.0 - 0.5)),
        1 => format!("{}", old * 10f64.powi(random.below(13) as i32 - 6)),
        2 => format!("{}", old + random.below(3) as f64 - 1.0),
        _ => HARD_NUMBERS[random.below(HARD_NUMBERS.len())].to_owned(),
    };
    bytes.splice(from..to, new.into_bytes());
}

/// Replaces four bytes that may be a number by another number.
fn change_bits(bytes: &mut [u8], random: &mut Random) {
    if bytes.len() < 4 {
        return;
    }
    let at = random.below(bytes.len() - 3);
    // Most files store their numbers at multiples of two.
    let at = if random.below(4) == 0 { at } else { at & !1 };
    let old = f32::from_le_bytes(std::array::from_fn(|byte| bytes[at + byte]));
    let new = match random.below(4) {
        0 => (old * (random.unit() as f32 * 2.0 - 0.5)).to_le_bytes(),
        1 => (old * 10f32.powi(random.below(13) as i32 - 6)).to_le_bytes(),
        2 => HARD_WORDS_OF_BITS[random.below(HARD_WORDS_OF_BITS.len())].to_le_bytes(),
        _ => HARD_WORDS_OF_BITS[random.below(HARD_WORDS_OF_BITS.len())].to_be_bytes(),
    };
    bytes[at..at + 4].copy_from_slice(&new);
}

/// Replaces a name by another one that the file contains: another material, another kind, another key.
fn change_name(bytes: &mut Vec<u8>, random: &mut Random) {
    let quotes: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at] == b'"').collect();
    let names = quotes.len() / 2;
    if names == 0 {
        return;
    }
    let place = |random: &mut Random| {
        let name = 2 * random.below(names);
        quotes[name]..quotes[name + 1] + 1
    };
    let other = bytes[place(random)].to_vec();
    let place = place(random);
    bytes.splice(place, other);
}

fn flip(bytes: &mut [u8], random: &mut Random) {
    if !bytes.is_empty() {
        let at = random.below(bytes.len());
        bytes[at] ^= 1 << random.below(8);
    }
}

fn part(bytes: &[u8], random: &mut Random) -> std::ops::Range<usize> {
    let from = random.below(bytes.len().max(1));
    from..(from + 1 + random.below(64)).min(bytes.len())
}

fn remove(bytes: &mut Vec<u8>, random: &mut Random) {
    let part = part(bytes, random);
    bytes.drain(part);
}

fn repeat(bytes: &mut Vec<u8>, random: &mut Random) {
    let part = bytes[part(bytes, random)].to_vec();
    let at = random.below(bytes.len() + 1);
    for _ in 0..1 + random.below(50) {
        bytes.splice(at..at, part.iter().copied());
    }
}

fn insert_word(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len() + 1);
    bytes.splice(at..at, HARD_WORDS[random.below(HARD_WORDS.len())].bytes());
}

fn cut_off(bytes: &mut Vec<u8>, random: &mut Random) {
    bytes.truncate(random.below(bytes.len() + 1));
}
