//! `scene.vtp`: the elements with their illuminances, for ParaView and other readers of VTK's XML files.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::ResultFile;
use super::maps::OwnEmission;
use super::picture::escaped;
use crate::maps::{MapKind, MapResult};
use crate::scene::{Elements, Scene, Side};
use crate::solver::Solution;

/// Bytes of a block that is compressed by itself.
const BLOCK_BYTES: usize = 1 << 20;

/// The element map as VTK PolyData: a triangle an element side, in the order of `elements.csv`; backs are turned round.
///
/// Coordinates in m and values are f64. `None` where no element map was computed.
pub fn vtk_file(scene: &Scene, solution: &Solution) -> Option<ResultFile> {
    let map = solution.maps.iter().find(|map| map.kind == MapKind::Elements)?;
    Some(ResultFile { name: "scene.vtp".to_owned(), bytes: poly_data(scene, &solution.elements, map).into_bytes() })
}

fn poly_data(scene: &Scene, elements: &Elements, map: &MapResult) -> String {
    let count = elements.len();
    let own = OwnEmission::of(scene);
    let mut points_m: Vec<f64> = Vec::with_capacity(9 * count);
    let mut corners_lx: Vec<f64> = Vec::with_capacity(3 * count);
    let (mut surfaces, mut sides) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut areas_m2, mut exitances_lm_m2) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut diffuse_cd_m2, mut material_types) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for index in 0..count {
        let cell = elements.cell(index as u32);
        let surface = scene.triangle_surfaces[cell.triangle as usize];
        let [a, b, c] = elements.corners_m(scene, cell);
        let front = cell.side == Side::Front;
        let corners = if front { [a, b, c] } else { [a, c, b] };
        let [at_a, at_b, at_c] = map.values.at_corners_lx(index);
        corners_lx.extend(if front { [at_a, at_b, at_c] } else { [at_a, at_c, at_b] });
        points_m.extend(corners.iter().flat_map(|corner| corner.to_array()));
        surfaces.push(surface as i32);
        sides.push(u8::from(cell.side == Side::Back));
        areas_m2.push(elements.area_m2(scene, cell));
        let [diffuse_lm_m2, emitted_lm_m2] = own.exitances_lm_m2(scene, elements, map, index as u32);
        exitances_lm_m2.push(diffuse_lm_m2 + emitted_lm_m2);
        diffuse_cd_m2.push(diffuse_lm_m2 / std::f64::consts::PI);
        material_types.push(scene.materials[scene.surfaces[surface as usize].material as usize].law.number());
    }
    let luminances_cd_m2: Vec<f64> = exitances_lm_m2.iter().map(|exitance| exitance / std::f64::consts::PI).collect();

    let mut file = File::default();
    file.line(0, "<?xml version=\"1.0\"?>");
    file.line(
        0,
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">",
    );
    file.line(1, "<PolyData>");
    file.line(2, "<FieldData>");
    file.texts("title", std::iter::once(scene.title.as_str()));
    file.texts("surface_names", scene.surfaces.iter().map(|surface| surface.name.as_str()));
    file.line(2, "</FieldData>");
    file.line(2, &format!("<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{count}\">", 3 * count));
    file.line(3, "<CellData Scalars=\"illuminance_lx\">");
    file.numbers("illuminance_lx", &map.values.illuminance_lx);
    file.numbers("standard_error_lx", &map.values.standard_error_lx);
    if !map.values.halves_lx.is_empty() {
        let half = |parity: usize| map.values.halves_lx.iter().map(|halves_lx| halves_lx[parity]).collect::<Vec<f64>>();
        let difference = |(halves_lx, mean_lx): (&[f64; 2], &f64)| match *mean_lx > 0.0 {
            true => (halves_lx[1] - halves_lx[0]) / mean_lx,
            false => 0.0,
        };
        let relative: Vec<f64> = map.values.halves_lx.iter().zip(&map.values.illuminance_lx).map(difference).collect();
        file.numbers("even_lx", &half(0));
        file.numbers("odd_lx", &half(1));
        file.numbers("odd_minus_even_over_mean", &relative);
    }
    file.numbers("direct_lx", &map.values.direct_lx);
    file.numbers("indirect_lx", &map.values.indirect_lx);
    file.numbers("exitance_lm_m2", &exitances_lm_m2);
    file.numbers("luminance_cd_m2", &luminances_cd_m2);
    file.numbers("diffuse_luminance_cd_m2", &diffuse_cd_m2);
    file.numbers("area_m2", &areas_m2);
    file.array("Int32", "surface", 1, &bytes(&surfaces, |id| id.to_le_bytes()));
    file.array("UInt8", "side", 1, &sides);
    file.array("UInt8", "material_type", 1, &material_types);
    if !map.values.discretisation_lx.is_empty() {
        file.numbers("discretisation_error_lx", &map.values.discretisation_lx);
    }
    file.line(3, "</CellData>");
    if !map.values.slopes_lx.is_empty() {
        file.line(3, "<PointData Scalars=\"illuminance_at_corner_lx\">");
        file.numbers("illuminance_at_corner_lx", &corners_lx);
        file.line(3, "</PointData>");
    }
    file.line(3, "<Points>");
    file.array("Float64", "Points", 3, &bytes(&points_m, |number| number.to_le_bytes()));
    file.line(3, "</Points>");
    file.line(3, "<Polys>");
    let corners: Vec<i64> = (0..3 * count as i64).collect();
    let ends: Vec<i64> = (1..=count as i64).map(|number| 3 * number).collect();
    file.array("Int64", "connectivity", 1, &bytes(&corners, |index| index.to_le_bytes()));
    file.array("Int64", "offsets", 1, &bytes(&ends, |index| index.to_le_bytes()));
    file.line(3, "</Polys>");
    file.line(2, "</Piece>");
    file.line(1, "</PolyData>");
    file.line(1, "<AppendedData encoding=\"base64\">");
    let appended = std::mem::take(&mut file.appended);
    file.line(2, &format!("_{appended}"));
    file.line(1, "</AppendedData>");
    file.line(0, "</VTKFile>");
    file.text
}

fn bytes<T: Copy, const N: usize>(numbers: &[T], of: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|number| of(*number)).collect()
}

/// A VTK file in the making: the tags, and the arrays that are appended to them.
#[derive(Default)]
struct File {
    text: String,
    appended: String,
}

impl File {
    fn line(&mut self, depth: usize, text: &str) {
        self.text.push_str(&"  ".repeat(depth));
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn numbers(&mut self, name: &str, numbers: &[f64]) {
        self.array("Float64", name, 1, &bytes(numbers, |number| number.to_le_bytes()));
    }

    fn array(&mut self, kind: &str, name: &str, components: usize, data: &[u8]) {
        let offset = self.appended.len();
        self.line(
            4,
            &format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>"
            ),
        );
        append_compressed(&mut self.appended, data);
    }

    /// Texts as VTK writes them: the bytes as numbers, a 0 behind each text.
    fn texts<'a>(&mut self, name: &str, texts: impl ExactSizeIterator<Item = &'a str>) {
        let count = texts.len();
        self.line(
            3,
            &format!("<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{count}\" format=\"ascii\">", escaped(name)),
        );
        for text in texts {
            let codes: Vec<String> = text.bytes().chain([0]).map(|code| code.to_string()).collect();
            self.line(4, &codes.join(" "));
        }
        self.line(3, "</Array>");
    }
}

/// Appends data as VTK's zlib blocks: the number of blocks, their size, that of the last one where it is smaller, the
/// compressed sizes; then, encoded by themselves, the blocks.
fn append_compressed(appended: &mut String, data: &[u8]) {
    let blocks: Vec<Vec<u8>> = data.chunks(BLOCK_BYTES).map(compressed).collect();
    let sizes = [blocks.len(), BLOCK_BYTES, data.len() % BLOCK_BYTES];
    let header: Vec<u8> =
        sizes.into_iter().chain(blocks.iter().map(Vec::len)).flat_map(|size| (size as u64).to_le_bytes()).collect();
    append_base64(appended, &header);
    append_base64(appended, &blocks.concat());
}

fn compressed(block: &[u8]) -> Vec<u8> {
    const IN_MEMORY: &str = "compressing to memory asks for nothing that could fail";
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(block).expect(IN_MEMORY);
    encoder.finish().expect(IN_MEMORY)
}

/// Base 64 with padding (RFC 4648).
fn append_base64(text: &mut String, data: &[u8]) {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for group in data.chunks(3) {
        let bits = (0..3).fold(0u32, |bits, i| bits << 8 | u32::from(group.get(i).copied().unwrap_or(0)));
        for place in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * place) & 63) as usize];
            text.push(if place <= group.len() { char::from(letter) } else { '=' });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::*;

    /// Test vectors of RFC 4648, section 10.
    #[test]
    fn base_64_follows_its_standard() {
        for (data, expected) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            let mut text = String::new();
            append_base64(&mut text, data.as_bytes());
            assert_eq!(text, expected);
        }
    }

    #[test]
    fn blocks_come_back_whole() {
        let data: Vec<u8> = (0..100_000u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        let mut back = Vec::new();
        flate2::read::ZlibDecoder::new(&compressed(&data)[..]).read_to_end(&mut back).expect("sound");
        assert_eq!(back, data);
    }
}
