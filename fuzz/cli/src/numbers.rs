//! Finds NaN and infinity in the files of a run: as words in texts, as bits in ParaView's file and in GLB.

use std::io::Read;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

/// Text formats that hold numbers. A page holds files in base 64, which can contain these words by chance.
const TEXTS: [&str; 6] = ["csv", "json", "svg", "pts", "res", "txt"];
const WORDS: [&str; 5] = ["NaN", "nan", "inf", "Infinity", "infinity"];
/// Largest size in bytes of a file that is searched.
const MOST_BYTES: usize = 64 << 20;
const FLOAT: u64 = 5126;

/// The NaN or infinity that a file holds, or why the file cannot be read.
pub fn fault_of(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_string_lossy();
    let kind = path.extension()?.to_str()?;
    let bytes = std::fs::read(path).ok().filter(|bytes| bytes.len() <= MOST_BYTES)?;
    let found = match kind {
        "vtp" => in_vtp(&bytes),
        "glb" => in_glb(&bytes),
        _ if TEXTS.contains(&kind) => Ok(word_in(&String::from_utf8_lossy(&bytes))),
        _ => Ok(None),
    };
    match found {
        Ok(what) => what.map(|what| format!("{name} holds {what}")),
        Err(why) => Some(format!("{name} cannot be read: {why}")),
    }
}

/// A word for NaN or infinity in a text.
pub fn word_in(text: &str) -> Option<String> {
    let mut words = text.split(|letter: char| !letter.is_ascii_alphanumeric());
    words.find(|word| WORDS.contains(word)).map(str::to_owned)
}

/// Each appended array has a header of 64-bit numbers (blocks, bytes per block, bytes of a smaller last block, compressed bytes of each
/// block) and the blocks one after another, both in base 64.
fn in_vtp(bytes: &[u8]) -> Result<Option<String>, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
    let (head, rest) = text.split_once("<AppendedData").ok_or("no appended data")?;
    if let Some(word) = word_in(head) {
        return Ok(Some(word));
    }
    let data = rest.split_once('_').ok_or("no start of data")?.1.split('<').next().unwrap_or_default().trim_end();
    for tag in head.split("<DataArray ").skip(1) {
        let attribute = |name: &str| Some(tag.split_once(&format!("{name}=\""))?.1.split('"').next()?.to_owned());
        let kind = attribute("type").ok_or("no type")?;
        let array = attribute("Name").ok_or("no name")?;
        let offset: usize = attribute("offset").and_then(|offset| offset.parse().ok()).ok_or("no offset")?;
        let numbers = array_at(data.get(offset..).ok_or("an offset behind the end")?)?;
        let is_finite = match kind.as_str() {
            "Float64" => numbers.as_chunks().0.iter().all(|bits| f64::from_le_bytes(*bits).is_finite()),
            "Float32" => numbers.as_chunks().0.iter().all(|bits| f32::from_le_bytes(*bits).is_finite()),
            _ => true,
        };
        if !is_finite {
            return Ok(Some(format!("what is no number in {array}")));
        }
    }
    Ok(None)
}

fn array_at(text: &str) -> Result<Vec<u8>, String> {
    let decoded = |letters: usize, from: usize| {
        let part = text.get(from..from + letters).ok_or("an array that is cut off")?;
        STANDARD.decode(part).map_err(|error| error.to_string())
    };
    let letters_of = |bytes: usize| 4 * bytes.div_ceil(3);
    let number =
        |bytes: &[u8], at: usize| bytes.as_chunks().0.get(at).map_or(0, |bits| u64::from_le_bytes(*bits) as usize);
    // The number of blocks is in the first eight bytes. Twelve letters hold nine bytes.
    let blocks = number(&decoded(12, 0)?, 0);
    let header_letters = letters_of(8 * (3 + blocks));
    let header = decoded(header_letters, 0)?;
    let sizes: Vec<usize> = (0..blocks).map(|block| number(&header, 3 + block)).collect();
    let packed = decoded(letters_of(sizes.iter().sum()), header_letters)?;
    let (mut all, mut from) = (Vec::new(), 0);
    for size in sizes {
        let block = packed.get(from..from + size).ok_or("a block that is cut off")?;
        flate2::read::ZlibDecoder::new(block).read_to_end(&mut all).map_err(|error| error.to_string())?;
        from += size;
    }
    Ok(all)
}

fn in_glb(bytes: &[u8]) -> Result<Option<String>, String> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    let json_bytes = word(12).ok_or("no head")?;
    let text = bytes.get(20..20 + json_bytes).ok_or("a description that is cut off")?;
    let json: Value = serde_json::from_slice(text).map_err(|error| error.to_string())?;
    let binary = bytes.get(28 + json_bytes..).unwrap_or_default();
    for accessor in json["accessors"].as_array().ok_or("no accessors")? {
        if accessor["componentType"].as_u64() != Some(FLOAT) {
            continue;
        }
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().ok_or("no view")? as usize];
        let [from, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap_or(0) as usize);
        let floats = binary.get(from..from + length).ok_or("a view that is cut off")?;
        if !floats.as_chunks().0.iter().all(|bits| f32::from_le_bytes(*bits).is_finite()) {
            return Ok(Some("what is no number".to_owned()));
        }
        let null = ["min", "max"]
            .iter()
            .any(|key| accessor[*key].as_array().is_some_and(|all| all.iter().any(Value::is_null)));
        if null {
            return Ok(Some("a bound that is no number".to_owned()));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn vtp(numbers: &[f64]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(&bytes).expect("room");
        let block = encoder.finish().expect("room");
        let header: Vec<u8> =
            [1, bytes.len() as u64, 0, block.len() as u64].iter().flat_map(|number| number.to_le_bytes()).collect();
        let data = STANDARD.encode(header) + &STANDARD.encode(block);
        format!(
            "<DataArray type=\"Float64\" Name=\"lx\" offset=\"0\"/>\n<AppendedData encoding=\"base64\">\n _{data}\n </AppendedData>"
        )
    }

    #[test]
    fn what_is_no_number_is_found_behind_its_encoding() {
        assert_eq!(in_vtp(vtp(&[1.0, 2.0]).as_bytes()), Ok(None));
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(matches!(in_vtp(vtp(&[1.0, bad]).as_bytes()), Ok(Some(_))));
        }
        let glb = |number: f32| {
            let json = r#"{"accessors":[{"componentType":5126,"bufferView":0}],"bufferViews":[{"byteOffset":0,"byteLength":4}]}"#;
            let mut bytes = vec![0; 12];
            bytes.extend((json.len() as u32).to_le_bytes());
            bytes.extend([0; 4]);
            bytes.extend(json.bytes());
            bytes.extend([0; 8]);
            bytes.extend(number.to_le_bytes());
            in_glb(&bytes)
        };
        assert_eq!(glb(1.0), Ok(None));
        assert!(matches!(glb(f32::INFINITY), Ok(Some(_))));
        assert_eq!(word_in("1,2,inf\n").as_deref(), Some("inf"));
        assert_eq!(word_in("information, nanometres"), None);
    }
}
