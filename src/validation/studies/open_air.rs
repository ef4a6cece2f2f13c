//! The two open-air scenes of the light-mesh studies: a garden house on a lawn, and a playground. Both are our own. They are 400
//! units wide, like the scenes of Debelov and Novikov (2009).

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::wheel::Wheel;

/// Closed solids seen from outside, as an OBJ file.
#[derive(Default)]
pub struct Things {
    /// The OBJ text.
    pub text: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of solids.
    pub parts: usize,
    vertices: usize,
}

impl Things {
    /// Starts the next solid. Each solid has its own vertices.
    fn part(&mut self, name: &str) {
        self.parts += 1;
        writeln!(self.text, "o {name}-{}\nusemtl {name}", self.parts).ok();
    }

    fn vertex(&mut self, [x, y, z]: [f64; 3]) -> usize {
        writeln!(self.text, "v {x:.4} {y:.4} {z:.4}").ok();
        self.vertices += 1;
        self.vertices
    }

    fn triangle(&mut self, corners: [usize; 3]) {
        writeln!(self.text, "f {} {} {}", corners[0], corners[1], corners[2]).ok();
        self.triangles += 1;
    }

    fn cuboid(&mut self, name: &str, low: [f64; 3], high: [f64; 3]) {
        self.part(name);
        let first = self.vertices + 1;
        for corner in 0..8 {
            self.vertex([0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] }));
        }
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.triangle([first + a, first + b, first + c]);
            self.triangle([first + a, first + c, first + d]);
        }
    }

    /// A solid of revolution about an axis: rings of given position and radius along the axis, closed by two end points.
    fn turned(&mut self, name: &str, foot: [f64; 3], axis: [f64; 3], rings: &[(f64, f64)], sides: usize) {
        self.part(name);
        let length = axis.iter().map(|part| part * part).sum::<f64>().sqrt();
        let along = axis.map(|part| part / length);
        let helper = if along[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let u = cross(helper, along);
        let size = u.iter().map(|part| part * part).sum::<f64>().sqrt();
        let u = u.map(|part| part / size);
        let v = cross(along, u);
        let low = self.vertex([0, 1, 2].map(|k| foot[k] + along[k] * rings[0].0));
        let first = self.vertices + 1;
        for (place, radius) in rings {
            for side in 0..sides {
                let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
                self.vertex([0, 1, 2].map(|k| foot[k] + along[k] * place + radius * (cos * u[k] + sin * v[k])));
            }
        }
        let top = self.vertex([0, 1, 2].map(|k| foot[k] + along[k] * rings[rings.len() - 1].0));
        let at = |ring: usize, side: usize| first + ring * sides + side % sides;
        for side in 0..sides {
            self.triangle([low, at(0, side + 1), at(0, side)]);
            for ring in 1..rings.len() {
                self.triangle([at(ring - 1, side), at(ring - 1, side + 1), at(ring, side + 1)]);
                self.triangle([at(ring - 1, side), at(ring, side + 1), at(ring, side)]);
            }
            self.triangle([at(rings.len() - 1, side), at(rings.len() - 1, side + 1), top]);
        }
    }

    fn ball(&mut self, name: &str, center: [f64; 3], radius: f64, sides: usize) {
        let rings: Vec<(f64, f64)> = (1..sides / 2)
            .map(|ring| {
                let (sin, cos) = (TAU * ring as f64 / sides as f64).sin_cos();
                (-radius * cos, radius * sin)
            })
            .collect();
        self.turned(name, center, [0.0, 0.0, 1.0], &rings, sides);
    }
}

/// A garden house of about 300 triangles: platform, columns, roof, benches and a low wall.
pub fn gazebo() -> Things {
    let mut all = Things::default();
    all.cuboid("lawn", [0.0, 0.0, -20.0], [400.0, 400.0, 0.0]);
    // A round platform, six columns, a conical roof, benches inside, and a low wall.
    all.turned("stone", [200.0, 200.0, 0.0], [0.0, 0.0, 1.0], &[(0.0, 90.0), (12.0, 90.0)], 12);
    for column in 0..6 {
        let (sin, cos) = (TAU * (column as f64 + 0.5) / 6.0).sin_cos();
        let foot = [200.0 + 70.0 * cos, 200.0 + 70.0 * sin, 12.0];
        all.turned("wood", foot, [0.0, 0.0, 1.0], &[(0.0, 6.0), (90.0, 6.0)], 6);
    }
    all.turned("tiles", [200.0, 200.0, 102.0], [0.0, 0.0, 1.0], &[(0.0, 95.0), (12.0, 95.0), (60.0, 5.0)], 12);
    for bench in [0.0, 1.0, 2.0] {
        let x = 150.0 + 40.0 * bench;
        all.cuboid("wood", [x, 195.0, 12.0], [x + 20.0, 215.0, 26.0]);
    }
    all.cuboid("stone", [40.0, 60.0, 0.0], [60.0, 340.0, 30.0]);
    all
}

/// A playground of about 27,000 triangles: a house, a climbing frame, swings, a slide, benches, toy balls and trees.
pub fn playground() -> Things {
    let mut all = Things::default();
    let mut wheel = Wheel(7);
    all.cuboid("lawn", [0.0, 0.0, -20.0], [400.0, 350.0, 0.0]);
    // A house with a pyramid roof, and a wall along the edge.
    all.cuboid("stone", [30.0, 230.0, 0.0], [130.0, 320.0, 90.0]);
    all.turned("tiles", [80.0, 275.0, 90.0], [0.0, 0.0, 1.0], &[(0.0, 80.0), (50.0, 6.0)], 4);
    all.cuboid("stone", [0.0, 335.0, 0.0], [400.0, 350.0, 40.0]);
    // A climbing frame and swings of round bars, a sandpit, and benches.
    for bar in 0..7 {
        for row in 0..2 {
            let (x, y) = (180.0 + 14.0 * f64::from(bar), 60.0 + 70.0 * f64::from(row));
            all.turned("paint", [x, y, 0.0], [0.0, 0.0, 1.0], &[(0.0, 2.5), (60.0, 2.5)], 12);
        }
        let x = 180.0 + 14.0 * f64::from(bar);
        all.turned("paint", [x, 55.0, 60.0], [0.0, 1.0, 0.0], &[(0.0, 2.5), (80.0, 2.5)], 12);
    }
    for swing in 0..3 {
        let x = 60.0 + 35.0 * f64::from(swing);
        all.turned("paint", [x, 90.0, 0.0], [0.1, 0.0, 1.0], &[(0.0, 3.0), (80.0, 3.0)], 12);
        all.cuboid("wood", [x - 8.0, 100.0, 18.0], [x + 8.0, 108.0, 21.0]);
    }
    for (low, high) in [
        ([280.0, 180.0, 0.0], [360.0, 188.0, 10.0]),
        ([280.0, 252.0, 0.0], [360.0, 260.0, 10.0]),
        ([280.0, 188.0, 0.0], [288.0, 252.0, 10.0]),
        ([352.0, 188.0, 0.0], [360.0, 252.0, 10.0]),
        ([160.0, 180.0, 0.0], [230.0, 196.0, 16.0]),
        ([160.0, 260.0, 0.0], [230.0, 276.0, 16.0]),
    ] {
        all.cuboid("wood", low, high);
    }
    // The steps of a slide.
    for step in 0..8 {
        let x = 300.0 + 8.0 * f64::from(step);
        all.cuboid("paint", [x, 110.0, 0.0], [x + 8.0, 130.0, 8.0 + 8.0 * f64::from(step)]);
    }
    // Toy balls on the lawn.
    for _ in 0..12 {
        let (x, y) = (20.0 + 360.0 * wheel.turn(), 20.0 + 190.0 * wheel.turn());
        all.ball("paint", [x, y, 7.0], 7.0, 16);
    }
    // Trees: a trunk, and balls of leaves.
    for (x, y) in [(40.0, 40.0), (370.0, 40.0), (250.0, 300.0), (340.0, 300.0), (150.0, 30.0)] {
        all.turned("wood", [x, y, 0.0], [0.0, 0.0, 1.0], &[(0.0, 8.0), (50.0, 6.0), (70.0, 4.0)], 16);
        for _ in 0..16 {
            let offset = [0, 1, 2].map(|_| 40.0 * wheel.turn() - 20.0);
            let radius = 9.0 + 6.0 * wheel.turn();
            all.ball("leaves", [x + offset[0], y + offset[1], 85.0 + offset[2]], radius, 18);
        }
    }
    all
}

/// The kind of the two lamps of the open-air scenes.
#[derive(Clone, Copy, Debug)]
pub enum Lamps {
    /// Point lamps.
    Points,
    /// Balls of this radius with the same luminous flux as the points.
    Balls {
        /// The radius in m.
        radius_m: f64,
    },
}

impl Lamps {
    /// The keys of a lamp in the scene file, except its name.
    fn keys(self, place: [i64; 3], intensity_cd: f64) -> String {
        match self {
            Lamps::Points => format!(r#""type": "point", "position": {place:?}, "intensity_cd": {intensity_cd:e}"#),
            Lamps::Balls { radius_m } => {
                let flux_lm = 2.0 * TAU * intensity_cd;
                format!(r#""type": "sphere", "center": {place:?}, "radius": {radius_m}, "luminous_flux_lm": {flux_lm}"#)
            }
        }
    }
}

/// The scene file for solids in an OBJ file, with a grid of `edge`² receivers on a lawn of 400 units by `depth`.
pub fn scene_text(title: &str, file: &str, depth: f64, edge: usize, lamps: Lamps) -> String {
    format!(
        r#"{{
  "version": 1,
  "title": "{title}",
  "materials": {{
    "lawn": {{ "type": "diffuse", "reflectance": 0 }},
    "stone": {{ "type": "diffuse", "reflectance": 0 }},
    "wood": {{ "type": "diffuse", "reflectance": 0 }},
    "tiles": {{ "type": "diffuse", "reflectance": 0 }},
    "paint": {{ "type": "diffuse", "reflectance": 0 }},
    "leaves": {{ "type": "diffuse", "reflectance": 0 }}
  }},
  "geometry": [ {{ "name": "things", "type": "mesh", "file": "{file}", "material": "stone" }} ],
  "luminaires": [
    {{ "name": "lamp 1", {first}, "maintenance_factor": 1 }},
    {{ "name": "lamp 2", {second} }}
  ],
  "receivers": [
    {{ "name": "lawn", "type": "grid", "origin": [1, 1, 0], "u": [398, 0, 0], "v": [0, {across}, 0], "columns": {edge}, "rows": {edge} }}
  ]
}}
"#,
        first = lamps.keys([60, 40, 220], 4e6),
        second = lamps.keys([330, depth as i64 - 60, 260], 3e6),
        across = depth - 2.0,
    )
}
