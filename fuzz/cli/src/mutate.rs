//! Inputs that somebody may give: files of the corpus with a few places changed.

use crate::random::Random;

/// Numbers that stand at the edges of what a program expects.
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
/// Texts that do the same in JSON, OBJ and photometric files.
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

/// Changes a file in one to four places; mostly numbers, since other changes are soon refused.
pub fn mutate(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(4) {
        match random.below(16) {
            0..=10 => change_number(&mut bytes, random),
            11 => flip(&mut bytes, random),
            12 => remove(&mut bytes, random),
            13 => repeat(&mut bytes, random),
            14 => insert_word(&mut bytes, random),
            _ => cut_off(&mut bytes, random),
        }
    }
    bytes
}

/// Places of all numbers.
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
