//! `scene.vtp`: the elements with their illuminances, for ParaView and other readers of VTK's XML files.

use std::f64::consts::PI;
use std::io::Write;

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;

use super::StreamedFile;
use super::maps::OwnEmission;
use super::picture::escaped;
use super::streamed::unwritable;
use super::zlib::zlib;
use crate::maps::{MapKind, MapResult};
use crate::scene::{Elements, Scene, Side};
use crate::solver::Solution;

/// Bytes of a block that is compressed separately.
const BLOCK_BYTES: usize = 1 << 20;

/// The element map as VTK PolyData: one triangle for each element side, in the order of `elements.csv`. Back sides have reversed
/// corners.
///
/// Coordinates in m and values are f64. `None` if no element map was computed. The compressed arrays are in memory while the file
/// is written, since their offsets come before them in the file.
pub fn vtk_file<'a>(scene: &'a Scene, solution: &'a Solution) -> Option<StreamedFile<'a>> {
    const NAME: &str = "scene.vtp";
    let map = solution.maps.iter().find(|map| map.kind == MapKind::Elements)?;
    Some(StreamedFile::new(NAME, move |writer| {
        poly_data(scene, &solution.elements, map).write_to(writer).map_err(|error| unwritable(NAME, &error))
    }))
}

fn poly_data(scene: &Scene, elements: &Elements, map: &MapResult) -> File {
    let count = elements.len();
    let all = || 0..count as u32;
    let own = OwnEmission::of(scene);
    let exitances_lm_m2: Vec<[f64; 2]> = all().map(|index| own.exitances_lm_m2(scene, elements, map, index)).collect();
    let surface_of = |index: u32| scene.triangle_surfaces[elements.element(index).triangle as usize];
    let bsdf_of = |index: u32| &scene.materials[scene.surfaces[surface_of(index) as usize].material as usize].bsdf;

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
    let values = &map.values;
    file.numbers("illuminance_lx", values.value.iter().copied());
    file.numbers("standard_error_lx", values.standard_error.iter().copied());
    if !values.halves.is_empty() {
        let half = |parity: usize| values.halves.iter().map(move |halves_lx| halves_lx[parity]);
        let difference = |(halves_lx, mean_lx): (&[f64; 2], &f64)| match *mean_lx > 0.0 {
            true => (halves_lx[1] - halves_lx[0]) / mean_lx,
            false => 0.0,
        };
        file.numbers("even_lx", half(0));
        file.numbers("odd_lx", half(1));
        file.numbers("odd_minus_even_over_mean", values.halves.iter().zip(&values.value).map(difference));
    }
    file.numbers("direct_lx", values.direct.iter().copied());
    file.numbers("indirect_lx", values.indirect.iter().copied());
    let exitances = || exitances_lm_m2.iter().map(|[diffuse_lm_m2, emitted_lm_m2]| diffuse_lm_m2 + emitted_lm_m2);
    file.numbers("exitance_lm_m2", exitances());
    file.numbers("luminance_cd_m2", exitances().map(|exitance| exitance / PI));
    file.numbers("diffuse_luminance_cd_m2", exitances_lm_m2.iter().map(|[diffuse_lm_m2, _]| diffuse_lm_m2 / PI));
    file.numbers("area_m2", all().map(|index| elements.area_m2(scene, elements.element(index))));
    file.array("Int32", "surface", 1, all().map(|index| (surface_of(index) as i32).to_le_bytes()));
    file.array("UInt8", "side", 1, all().map(|index| [u8::from(elements.element(index).side == Side::Back)]));
    file.array("UInt8", "material_type", 1, all().map(|index| [bsdf_of(index).number()]));
    if !values.discretisation_lx.is_empty() {
        file.numbers("discretisation_error_lx", values.discretisation_lx.iter().copied());
    }
    file.line(3, "</CellData>");
    if !values.slopes_lx.is_empty() {
        let corners_lx = |index: u32| turned(values.at_corners_lx(index as usize), elements.element(index).side);
        file.line(3, "<PointData Scalars=\"illuminance_at_corner_lx\">");
        file.numbers("illuminance_at_corner_lx", all().flat_map(corners_lx));
        file.line(3, "</PointData>");
    }
    file.line(3, "<Points>");
    let corners_m = |index: u32| {
        let element = elements.element(index);
        turned(elements.corners_m(scene, element), element.side).into_iter().flat_map(|corner| corner.to_array())
    };
    file.array("Float64", "Points", 3, all().flat_map(corners_m).map(f64::to_le_bytes));
    file.line(3, "</Points>");
    file.line(3, "<Polys>");
    file.array("Int64", "connectivity", 1, (0..3 * count as i64).map(i64::to_le_bytes));
    file.array("Int64", "offsets", 1, (1..=count as i64).map(|number| (3 * number).to_le_bytes()));
    file.line(3, "</Polys>");
    file.line(2, "</Piece>");
    file.line(1, "</PolyData>");
    file.line(1, "<AppendedData encoding=\"base64\">");
    file
}

/// Values at an element's corners, in the order that is counter-clockwise as seen from its side.
fn turned<T>([a, b, c]: [T; 3], side: Side) -> [T; 3] {
    if side == Side::Front { [a, b, c] } else { [a, c, b] }
}

/// A VTK file under construction: the tags, and the arrays that are appended to them.
#[derive(Default)]
struct File {
    text: String,
    /// Pieces that are encoded separately.
    appended: Vec<Vec<u8>>,
    /// Number of letters of all encoded pieces so far.
    letters: usize,
}

impl File {
    fn line(&mut self, depth: usize, text: &str) {
        self.text.push_str(&"  ".repeat(depth));
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn numbers(&mut self, name: &str, numbers: impl Iterator<Item = f64>) {
        self.array("Float64", name, 1, numbers.map(f64::to_le_bytes));
    }

    fn array<const N: usize>(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        data: impl Iterator<Item = [u8; N]>,
    ) {
        let offset = self.letters;
        self.line(
            4,
            &format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>"
            ),
        );
        for piece in compressed_blocks(data) {
            self.letters += 4 * piece.len().div_ceil(3);
            self.appended.push(piece);
        }
    }

    /// Texts in VTK's form: the bytes as numbers, with a 0 after each text.
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

    /// Writes tags and arrays. Each piece is released once it is written.
    fn write_to(self, writer: &mut dyn Write) -> std::io::Result<()> {
        writer.write_all(self.text.as_bytes())?;
        writer.write_all(b"    _")?;
        for piece in self.appended {
            let mut encoder = EncoderWriter::new(&mut *writer, &STANDARD);
            encoder.write_all(&piece)?;
            encoder.finish()?;
        }
        writer.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
    }
}

/// Data as VTK's zlib blocks. First come the number of blocks, their size, the size of the last one if it is smaller, and the
/// compressed sizes. The blocks follow, encoded separately.
fn compressed_blocks<const N: usize>(data: impl Iterator<Item = [u8; N]>) -> [Vec<u8>; 2] {
    let mut block: Vec<u8> = Vec::new();
    let (mut blocks, mut sizes, mut last) = (Vec::new(), Vec::new(), 0);
    let mut add = |block: &mut Vec<u8>| {
        let compressed = zlib(block, Compression::fast());
        sizes.push(compressed.len());
        blocks.extend(compressed);
        block.clear();
    };
    for number in data {
        block.extend(number);
        if block.len() == BLOCK_BYTES {
            add(&mut block);
        }
    }
    if !block.is_empty() {
        last = block.len();
        add(&mut block);
    }
    let header = [sizes.len(), BLOCK_BYTES, last].into_iter().chain(sizes.iter().copied());
    [header.flat_map(|size| (size as u64).to_le_bytes()).collect(), blocks]
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::*;

    #[test]
    fn blocks_come_back_whole() {
        let data: Vec<u8> = (0..100_000u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        let mut back = Vec::new();
        flate2::read::ZlibDecoder::new(&zlib(&data, Compression::fast())[..]).read_to_end(&mut back).expect("sound");
        assert_eq!(back, data);
    }

    /// Whole blocks, a smaller last one, and no data at all.
    #[test]
    fn blocks_are_counted_with_their_sizes() {
        let header = |count: usize| -> Vec<u64> {
            let [header, _] = compressed_blocks((0..count as u64).map(u64::to_le_bytes));
            header.chunks(8).map(|size| u64::from_le_bytes(size.try_into().expect("eight bytes"))).collect()
        };
        let each = (BLOCK_BYTES / 8) as u64;
        assert_eq!(header(0), [0, 8 * each, 0]);
        assert_eq!(header(2 * each as usize)[..3], [2, 8 * each, 0]);
        let rest = header(each as usize + 5);
        assert!(rest.len() == 5 && rest[..3] == [2, 8 * each, 40], "{rest:?}");
    }
}
