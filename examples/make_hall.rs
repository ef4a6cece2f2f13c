//! Writes `scenes/hall.obj`: the storage racks of `scenes/hall.json`, some 200,000 triangles.
//!
//! `cargo run --release --example make_hall` (from the project's root)

use std::fmt::Write as _;

use luxmc::validation::studies::wheel::Wheel;

const RACKS: usize = 8;
const BAYS: usize = 19;
const LEVELS: usize = 5;
const PALLETS_PER_BAY: usize = 3;
const CARTONS_PER_PALLET: usize = 7;

/// Writes closed boxes seen from outside.
struct Boxes {
    text: String,
    vertices: usize,
    triangles: usize,
    material: &'static str,
}

impl Boxes {
    fn push(&mut self, material: &'static str, low: [f64; 3], high: [f64; 3]) -> std::fmt::Result {
        if self.material != material {
            self.material = material;
            writeln!(self.text, "usemtl {material}")?;
        }
        for corner in 0..8 {
            let at = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            writeln!(self.text, "v {:.3} {:.3} {:.3}", at(0), at(1), at(2))?;
        }
        for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = quad.map(|corner| self.vertices + corner + 1);
            writeln!(self.text, "f {a} {b} {c} {d}")?;
        }
        self.vertices += 8;
        self.triangles += 12;
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut boxes = Boxes { text: String::new(), vertices: 0, triangles: 0, material: "" };
    let mut wheel = Wheel(1);
    writeln!(boxes.text, "# Storage racks with cartons, in metres; every part is a closed box seen from outside.")?;
    let (bay, depth, level) = (2.8, 1.1, 1.6);
    let steel: Vec<([f64; 3], [f64; 3])> = (0..RACKS)
        .flat_map(|rack| {
            let (x0, y0) = (4.0, 3.0 + 4.6 * rack as f64);
            let posts = (0..=BAYS).flat_map(move |i| {
                let x = x0 + bay * i as f64;
                [y0, y0 + depth - 0.1].map(|y| ([x, y, 0.0], [x + 0.1, y + 0.1, level * LEVELS as f64]))
            });
            let shelves = (0..BAYS).flat_map(move |i| {
                (1..LEVELS).map(move |k| {
                    let (x, z) = (x0 + bay * i as f64 + 0.11, level * k as f64);
                    ([x, y0 + 0.11, z - 0.08], [x + bay - 0.12, y0 + depth - 0.11, z - 0.01])
                })
            });
            posts.chain(shelves).collect::<Vec<_>>()
        })
        .collect();
    for (low, high) in steel {
        boxes.push("Steel", low, high)?;
    }
    for rack in 0..RACKS {
        let y0 = 3.0 + 4.6 * rack as f64;
        for i in 0..BAYS {
            for k in 0..LEVELS {
                for p in 0..PALLETS_PER_BAY {
                    let x = 4.0 + bay * i as f64 + 0.15 + p as f64 * 0.88;
                    for carton in 0..CARTONS_PER_PALLET {
                        let (column, row) = (carton % 2, carton / 2);
                        let (low_x, low_z) = (x + 0.41 * column as f64, level * k as f64 + 0.01 + 0.33 * row as f64);
                        let (inset, back) = (0.02 + 0.03 * wheel.turn(), 0.12 + 0.1 * wheel.turn());
                        let low = [low_x + inset, y0 + back, low_z];
                        let high = [low_x + 0.4 - inset * 0.5, y0 + depth - 0.13, low_z + 0.28 + 0.04 * wheel.turn()];
                        boxes.push("Cardboard", low, high)?;
                    }
                }
            }
        }
    }
    std::fs::write("scenes/hall.obj", &boxes.text)?;
    eprintln!("scenes/hall.obj: {} triangles", boxes.triangles);
    Ok(())
}
