//! Owen-scrambled Sobol points: quasi-random variates for the first decisions of a walk, a gathering ray or a chain.
//!
//! Sobol's sequence fills every elementary box evenly. Owen's nested scrambling (1995, "Randomly permuted (t,m,s)-nets and
//! (t,s)-sequences") keeps this property and makes every point uniform. Estimates stay unbiased, and independent scrambles give their
//! error. The scramble is hashed after Laine and Karras (2011, "Stratified sampling for stochastic transparency"). Each bit is flipped by a
//! function of the bits above it and of the seed.

use serde::{Deserialize, Serialize};

use rand_philox::splitmix64;

/// Number of dimensions of the points. Later decisions use plain random numbers.
pub const DIMENSIONS: u32 = 16;

/// Primitive polynomials and first direction numbers of dimensions 2 to 16 (Joe and Kuo, 2008, "Constructing Sobol
/// sequences with better two-dimensional projections"): degree, inner coefficients, m₁ … m_s.
const POLYNOMIALS: [(usize, u32, [u32; 6]); DIMENSIONS as usize - 1] = [
    (1, 0, [1, 0, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0, 0]),
    (4, 4, [1, 3, 5, 13, 0, 0]),
    (5, 2, [1, 1, 5, 5, 17, 0]),
    (5, 4, [1, 1, 5, 5, 5, 0]),
    (5, 7, [1, 1, 7, 11, 19, 0]),
    (5, 11, [1, 1, 5, 1, 1, 0]),
    (5, 13, [1, 1, 1, 3, 11, 0]),
    (5, 14, [1, 3, 5, 5, 31, 0]),
    (6, 1, [1, 3, 3, 9, 7, 49]),
    (6, 13, [1, 1, 1, 15, 21, 21]),
    (6, 16, [1, 3, 1, 13, 27, 49]),
];

const BITS: usize = 32;
/// An index is processed four bits at a time. The table holds the contribution of each value of each nibble with its bits reversed, because
/// the scrambling needs the highest digit in the lowest bit.
const NIBBLES: usize = 8;
const TABLE: [[[u32; 16]; NIBBLES]; DIMENSIONS as usize] = nibble_table();

const fn direction_numbers(dimension: usize) -> [u32; BITS] {
    let mut numbers = [0u32; BITS];
    let mut bit = 0;
    if dimension == 0 {
        while bit < BITS {
            numbers[bit] = 1 << (BITS - 1 - bit);
            bit += 1;
        }
        return numbers;
    }
    let (degree, coefficients, first) = POLYNOMIALS[dimension - 1];
    while bit < BITS {
        numbers[bit] = if bit < degree {
            first[bit] << (BITS - 1 - bit)
        } else {
            let mut number = numbers[bit - degree] ^ (numbers[bit - degree] >> degree);
            let mut term = 1;
            while term < degree {
                if (coefficients >> (degree - 1 - term)) & 1 == 1 {
                    number ^= numbers[bit - term];
                }
                term += 1;
            }
            number
        };
        bit += 1;
    }
    numbers
}

const fn nibble_table() -> [[[u32; 16]; NIBBLES]; DIMENSIONS as usize] {
    let mut table = [[[0u32; 16]; NIBBLES]; DIMENSIONS as usize];
    let mut dimension = 0;
    while dimension < DIMENSIONS as usize {
        let numbers = direction_numbers(dimension);
        let mut nibble = 0;
        while nibble < NIBBLES {
            let mut value = 1;
            while value < 16 {
                // The contribution of the value without its lowest bit is already in the table.
                let lowest = (value as u32).trailing_zeros() as usize;
                table[dimension][nibble][value] =
                    table[dimension][nibble][value & (value - 1)] ^ numbers[4 * nibble + lowest].reverse_bits();
                value += 1;
            }
            nibble += 1;
        }
        dimension += 1;
    }
    table
}

/// One scrambled point. Its coordinates are drawn one after the other.
#[derive(Clone, Copy, Debug)]
pub struct QuasiPoint {
    index: u32,
    key: u64,
    dimension: u32,
    /// Number of the branch, and the dimension at which it began. Branch 0 is the point itself.
    branch: u32,
    branch_start: u32,
}

/// Flag in `branch` of a point that is confined to a square instead of branched.
const CONFINED: u32 = 1 << 31;

/// One of 4ᵏ squares of the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Square {
    level: u8,
    column: u8,
    row: u8,
}

impl Square {
    /// The unit square itself.
    pub const WHOLE: Square = Square { level: 0, column: 0, row: 0 };

    /// Returns one of 4ᵏ squares, counted row by row, with k = `level` at most 8.
    pub fn of(level: u32, place: usize) -> Square {
        Square { level: level as u8, column: (place & ((1 << level) - 1)) as u8, row: (place >> level) as u8 }
    }

    /// Returns its quarters.
    pub fn quarters(self) -> [Square; 4] {
        std::array::from_fn(|place| Square {
            level: self.level + 1,
            column: 2 * self.column + (place & 1) as u8,
            row: 2 * self.row + (place >> 1) as u8,
        })
    }

    /// Returns how often the sides of the unit square were halved.
    pub fn level(self) -> u32 {
        u32::from(self.level)
    }

    /// Returns the area; the unit square has 1.
    #[inline]
    pub fn area(self) -> f64 {
        1.0 / f64::from(1u32 << (2 * self.level))
    }

    /// Returns a number that identifies the square, below 2¹⁶ for squares of at most six halvings.
    #[inline]
    pub fn code(self) -> u64 {
        u64::from(self.level) << 12 | u64::from(self.row) << 6 | u64::from(self.column)
    }
}

impl QuasiPoint {
    /// Returns point `index` of the sequence scrambled by a key. Past 2³² points the sequence starts again with another scramble.
    #[inline]
    pub fn new(key: u64, index: u64) -> QuasiPoint {
        let lap = index >> 32;
        let key = if lap == 0 { key } else { splitmix64(key ^ splitmix64(lap)) };
        QuasiPoint { index: index as u32, key, dimension: 0, branch: 0, branch_start: 0 }
    }

    /// Returns the corresponding point of another sequence, with its own scramble and order.
    ///
    /// The order is shuffled so that runs of 2ᵏ points stay together. Without the shuffle all first coordinates would be the same function
    /// of each other, and pairs of them would never fill their square.
    /// Source: Burley, "Practical hash-based Owen scrambling", 2020.
    #[inline]
    pub fn of_sequence(&self, sequence: u64) -> QuasiPoint {
        let key = splitmix64(self.key ^ splitmix64(!sequence));
        let index = scrambled(self.index.reverse_bits(), splitmix64(!key)).reverse_bits();
        QuasiPoint { index, key, dimension: 0, ..*self }
    }

    /// Returns a branch of the point. Its coordinates from here on are shifted digit by digit, by the same digits for all points of a
    /// sequence, which keeps the sequence's evenness. Among four branches, two have their first coordinate in each half. The second and
    /// third coordinates have one branch in each quarter of their square.
    #[inline]
    pub fn branch(&self, branch: u32) -> QuasiPoint {
        QuasiPoint { branch, branch_start: self.dimension, ..*self }
    }

    /// Returns the point with its next two coordinates confined to a square.
    #[inline]
    pub fn confined(&self, square: Square) -> QuasiPoint {
        let (level, row, column) = (u32::from(square.level), u32::from(square.row), u32::from(square.column));
        let branch = if level == 0 { 0 } else { CONFINED | level << 16 | row << 8 | column };
        QuasiPoint { branch, branch_start: self.dimension, ..*self }
    }

    /// Returns a coordinate of a branch or of a confined point.
    #[inline]
    fn altered(&self, dimension: u32, coordinate: u32) -> u32 {
        if self.branch & CONFINED == 0 {
            return coordinate ^ self.shift(dimension);
        }
        let level = self.branch >> 16 & 0xFF;
        match dimension - self.branch_start {
            0 => (self.branch & 0xFF) << (32 - level) | coordinate >> level,
            1 => (self.branch >> 8 & 0xFF) << (32 - level) | coordinate >> level,
            _ => coordinate,
        }
    }

    /// Returns the digits by which a coordinate of a branch is shifted.
    #[inline]
    fn shift(&self, dimension: u32) -> u32 {
        let random = splitmix64(self.key ^ splitmix64(u64::from(self.branch) << 32 | u64::from(dimension))) as u32;
        let branch = self.branch;
        let [digits, count] = match dimension - self.branch_start {
            0 => [(branch ^ branch >> 1) & 1, 1],
            1 => [branch & 1, 1],
            2 => [branch >> 1 & 1, 1],
            _ => [0, 0],
        };
        if count == 0 { random } else { digits << 31 | random >> 1 }
    }

    /// Returns the next coordinate as 32 bits; `None` after the last dimension.
    #[inline]
    pub fn next_coordinate(&mut self) -> Option<u32> {
        let dimension = self.dimension;
        if dimension >= DIMENSIONS {
            return None;
        }
        self.dimension += 1;
        let seed = splitmix64(self.key.wrapping_add(u64::from(dimension).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let coordinate = scrambled(reversed_sobol(self.index, dimension as usize), seed).reverse_bits();
        Some(if self.branch == 0 { coordinate } else { self.altered(dimension, coordinate) })
    }
}

/// Returns the coordinate of point `index` in a dimension, as a fraction of 2³² with its bits reversed: the highest digit in the lowest
/// bit.
#[inline]
fn reversed_sobol(index: u32, dimension: usize) -> u32 {
    let table = &TABLE[dimension];
    let of_nibble = |nibble: usize| table[nibble][(index >> (4 * nibble) & 15) as usize];
    let low = (of_nibble(0) ^ of_nibble(1)) ^ (of_nibble(2) ^ of_nibble(3));
    if index >> 16 == 0 {
        return low;
    }
    low ^ (of_nibble(4) ^ of_nibble(5)) ^ (of_nibble(6) ^ of_nibble(7))
}

/// Scrambles digits nested and uniformly. The highest digit is in the lowest bit. A multiplication by an even number makes every bit depend
/// only on the digits above it.
#[inline]
fn scrambled(reversed: u32, seed: u64) -> u32 {
    let (add, multiply) = (seed as u32, (seed >> 32) as u32 | 1);
    let mut bits = reversed;
    bits ^= bits.wrapping_mul(0x3D20_ADEA);
    bits = bits.wrapping_add(add);
    bits = bits.wrapping_mul(multiply);
    bits ^= bits.wrapping_mul(0x0552_6C56);
    bits ^ bits.wrapping_mul(0x53A2_2864)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::chi_square_p;

    fn coordinates(key: u64, index: u64) -> [f64; DIMENSIONS as usize] {
        let mut point = QuasiPoint::new(key, index);
        std::array::from_fn(|_| f64::from(point.next_coordinate().expect("a dimension is left")) / 4_294_967_296.0)
    }

    #[test]
    fn coordinates_of_two_sequences_fill_their_square() {
        // 1,024 pairs of first coordinates in 16 cells of 64 each: 64 ± 40 (5 standard deviations) for three keys. The planted fault,
        // another scramble in the same order, fills only four cells.
        let cells = |key: u64, other: &dyn Fn(&QuasiPoint) -> QuasiPoint| {
            let mut counts = [0u32; 16];
            for index in 0..1024 {
                let mut point = QuasiPoint::new(key, index);
                let mut turned = other(&point);
                let [a, b] = [&mut point, &mut turned].map(|point| point.next_coordinate().expect("the first") >> 30);
                counts[(4 * a + b) as usize] += 1;
            }
            counts
        };
        for key in [0, 1, 99] {
            let counts = cells(key, &|point| point.of_sequence(3));
            assert!(counts.iter().all(|count| (24..=104).contains(count)), "{counts:?}");
            let faulty = cells(key, &|point| QuasiPoint { key: splitmix64(key + 7), ..*point });
            assert_eq!(faulty.iter().filter(|count| **count == 0).count(), 12, "{faulty:?}");
        }
    }

    #[test]
    fn every_dimension_fills_equal_strata_once_and_the_first_two_all_elementary_boxes() {
        for key in [0, 1, 99] {
            let points: Vec<_> = (0..256).map(|index| coordinates(key, index)).collect();
            for dimension in 0..DIMENSIONS as usize {
                let mut seen = [false; 256];
                points.iter().for_each(|point| seen[(point[dimension] * 256.0) as usize] = true);
                assert!(seen.iter().all(|seen| *seen), "dimension {dimension}");
            }
            for split in 0..=8 {
                let (columns, rows) = (f64::from(1 << split), f64::from(256 >> split));
                let mut seen = [false; 256];
                points.iter().for_each(|point| {
                    seen[((point[0] * columns) as usize) * rows as usize + (point[1] * rows) as usize] = true;
                });
                assert!(seen.iter().all(|seen| *seen), "{columns} × {rows}");
            }
        }
    }

    #[test]
    fn each_point_alone_is_uniform_over_the_scrambles() {
        // χ² over 64 bins, N = 64,000 scrambles, α = 1e-4 per test, and again for counts that are too even. The planted fault, a point that
        // is not scrambled for one key in 50, must be rejected.
        let p_values = |faulty: bool| {
            [(0u64, 0), (5, 1), (77, 4), ((1u64 << 32) + 3, 9)].map(|(index, dimension)| {
                let mut counts = [0.0; 64];
                for key in 0..64_000u64 {
                    let value = if faulty && key % 50 == 0 {
                        f64::from(reversed_sobol(index as u32, dimension).reverse_bits()) / 4_294_967_296.0
                    } else {
                        coordinates(splitmix64(key), index)[dimension]
                    };
                    counts[(value * 64.0) as usize] += 1.0;
                }
                chi_square_p(&counts, &[1000.0; 64])
            })
        };
        let [right, wrong] = [false, true].map(p_values);
        assert!(right.iter().all(|p| (1e-4..1.0 - 1e-4).contains(p)), "{right:?}");
        assert!(wrong.iter().all(|p| *p < 1e-4), "{wrong:?}");
    }

    #[test]
    fn a_smooth_integral_converges_faster_than_chance() {
        // ∫ Π (1 + (x_d − ½)/(d + 1)) over six dimensions is 1. RMS over 64 scrambles of 1,024 points: plain random numbers give 0.009.
        let rms = |count: u64| {
            let squares = (0..64u64).map(|key| {
                let sum: f64 = (0..count)
                    .map(|index| {
                        let point = coordinates(splitmix64(key), index);
                        (0..6).map(|d| 1.0 + (point[d] - 0.5) / (d as f64 + 1.0)).product::<f64>()
                    })
                    .sum();
                (sum / count as f64 - 1.0).powi(2)
            });
            (squares.sum::<f64>() / 64.0).sqrt()
        };
        let (few, many) = (rms(64), rms(1024));
        assert!(many < 4e-4, "{many}");
        assert!((few / many).ln() / 16f64.ln() > 1.2, "{few} {many}");
    }
}
