//! The racks of the storage hall that `luxmc new hall` makes: some 20,000 triangles.

use std::fmt::Write as _;

const RACKS: usize = 8;
const BAYS: usize = 19;
const LEVELS: usize = 5;
/// Width of a bay, depth of a rack and height of a level in m.
const SIZE_M: [f64; 3] = [2.8, 1.1, 1.6];
/// Position of the first rack, and the distance between racks, in m.
const FIRST_M: [f64; 2] = [4.0, 3.0];
const DISTANCE_M: f64 = 4.6;

/// Closed boxes, seen from outside, as OBJ text.
#[derive(Default)]
struct Boxes {
    text: String,
    vertices: usize,
}

impl Boxes {
    fn push(&mut self, low: [f64; 3], high: [f64; 3]) {
        // Writing to a `String` cannot fail.
        for corner in 0..8 {
            let at = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            writeln!(self.text, "v {:.3} {:.3} {:.3}", at(0), at(1), at(2)).ok();
        }
        for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = quad.map(|corner| self.vertices + corner + 1);
            writeln!(self.text, "f {a} {b} {c} {d}").ok();
        }
        self.vertices += 8;
    }
}

/// Racks of posts and shelves (`Steel`) with a block of goods in every bay (`Cardboard`), in metres.
pub fn hall_obj() -> String {
    let [bay, depth, level] = SIZE_M;
    let mut boxes = Boxes::default();
    boxes.text.push_str("# Storage racks, in metres; every part is a closed box seen from outside.\nusemtl Steel\n");
    let racks = || (0..RACKS).map(|rack| (FIRST_M[0], FIRST_M[1] + DISTANCE_M * rack as f64));
    for (x0, y0) in racks() {
        for i in 0..=BAYS {
            let x = x0 + bay * i as f64;
            for y in [y0, y0 + depth - 0.1] {
                boxes.push([x, y, 0.0], [x + 0.1, y + 0.1, level * LEVELS as f64]);
            }
        }
        for i in 0..BAYS {
            let x = x0 + bay * i as f64 + 0.11;
            for k in 1..LEVELS {
                let z = level * k as f64;
                boxes.push([x, y0 + 0.11, z - 0.08], [x + bay - 0.12, y0 + depth - 0.11, z - 0.01]);
            }
        }
    }
    boxes.text.push_str("usemtl Cardboard\n");
    for (x0, y0) in racks() {
        for i in 0..BAYS {
            for k in 0..LEVELS {
                let (x, z) = (x0 + bay * i as f64 + 0.2, level * k as f64 + 0.01);
                // Goods fill their bays to different heights.
                let height = 0.7 + 0.1 * ((i * 7 + k * 3) % 6) as f64;
                boxes.push([x, y0 + 0.15, z], [x + bay - 0.3, y0 + depth - 0.15, z + height]);
            }
        }
    }
    boxes.text
}
