//! The digest of a scene. It shows whether two runs computed the same scene.

use std::collections::HashMap;
use std::fmt::Write;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::bodies::Body;
use super::{Emission, Luminaire, Scene};

/// Receives text and bytes for the digest.
struct Sink(Sha256);

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text);
        Ok(())
    }
}

impl Sink {
    /// Adds the bytes of `count` values. The count separates each list from the next one.
    fn bytes<const N: usize>(&mut self, name: &str, count: usize, values: impl Iterator<Item = [u8; N]>) {
        self.text(format_args!("{name} {count}:"));
        values.for_each(|value| self.0.update(value));
    }

    fn text(&mut self, text: std::fmt::Arguments) {
        // A digest accepts any text, so writing cannot fail.
        self.write_fmt(text).ok();
    }
}

impl Scene {
    /// Returns the SHA-256 of everything that results depend on, in hexadecimal digits. It covers every bit of every number: geometry,
    /// materials, luminaires and receivers as they were read. These do not count: the path and layout of the file, its title, its
    /// warnings, and what reports show.
    pub fn digest(&self) -> String {
        let Scene {
            title: _,
            project: _,
            energy: _,
            unreported: _,
            path: _,
            warnings: _,
            materials,
            vertices_m,
            triangles,
            divisions,
            triangle_surfaces,
            surfaces,
            bodies,
            luminaires,
            receivers,
        } = self;
        let mut sink = Sink(Sha256::new());
        sink.text(format_args!("{materials:?}{surfaces:?}"));
        let corners = || vertices_m.iter().flat_map(|vertex| vertex.to_array());
        sink.bytes("vertices", vertices_m.len(), corners().map(f64::to_le_bytes));
        sink.bytes("triangles", triangles.len(), triangles.iter().flatten().map(|vertex| vertex.to_le_bytes()));
        sink.bytes("divisions", divisions.len(), divisions.iter().map(|parts| parts.to_le_bytes()));
        sink.bytes("surfaces", triangle_surfaces.len(), triangle_surfaces.iter().map(|surface| surface.to_le_bytes()));
        for body in bodies {
            let Body { series, center_m, turn, inward, triangles, .. } = &**body;
            sink.text(format_args!("{:?}{center_m:?}{turn:?}{inward:?}{triangles:?}", series.coefficients()));
        }
        let mut webs = HashMap::new();
        luminaires.iter().for_each(|luminaire| take_luminaire(&mut sink, &mut webs, luminaire));
        // The shortest decimal form of a number reads back to the same bits.
        receivers.iter().for_each(|set| sink.text(format_args!("{set:?}")));
        sink.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// Adds a luminaire. A distribution that several luminaires share is added once, and then only its number.
fn take_luminaire(sink: &mut Sink, webs: &mut HashMap<usize, usize>, luminaire: &Luminaire) {
    let Luminaire { name, luminous_flux_lm, dimming, maintenance_factor, power_w, product: _, emission } = luminaire;
    sink.text(format_args!("{name:?}{luminous_flux_lm:?}{dimming:?}{maintenance_factor:?}{power_w:?}"));
    let Emission::Photometric { position_m, frame, web, opening, scale } = emission else {
        return sink.text(format_args!("{emission:?}"));
    };
    let number = webs.len();
    let known = *webs.entry(Arc::as_ptr(web) as usize).or_insert(number);
    if known == number {
        sink.text(format_args!("{web:?}"));
    }
    sink.text(format_args!("photometric {known} {position_m:?}{frame:?}{opening:?}{scale:?}"));
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scene::Scene;
    use crate::scene_from_json;

    const TEXT: &str = r#"{"version": 1, "title": "a",
        "materials": {"paint": {"type": "diffuse", "reflectance": 0.5}},
        "geometry": [{"name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "paint"}],
        "luminaires": [{"name": "lamp", "type": "point", "position": [2,2,1], "luminous_flux_lm": 1000}],
        "receivers": [{"name": "floor", "type": "grid", "origin": [1,1,0], "u": [2,0,0], "v": [0,1,0], "columns": 2, "rows": 2}]}"#;

    fn scene(text: &str) -> Scene {
        scene_from_json(text, None, Path::new(".")).expect("a scene")
    }

    #[test]
    fn a_digest_tells_every_change_that_results_depend_on_and_no_other() {
        let digest = scene(TEXT).digest();
        assert_eq!(digest.len(), 64);
        let same = TEXT.replace("\"title\": \"a\"", "\"title\": \"b\"").replace(", ", " ,\n");
        assert_eq!(scene(&same).digest(), digest);
        let changes = [
            ("0.5", "0.5000000000000001"),
            ("[4,3,2]", "[4,3,2.0000000001]"),
            ("[2,2,1]", "[2,2,1.1]"),
            ("1000", "1001"),
            ("\"columns\": 2", "\"columns\": 3"),
            ("\"lamp\"", "\"lamps\""),
        ];
        for (from, to) in changes {
            assert_ne!(scene(&TEXT.replacen(from, to, 1)).digest(), digest, "{from} → {to}");
        }
    }
}
