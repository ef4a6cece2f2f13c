//! Faults of a scene file: one good file and the ways in which the tests break it.

/// A good file; every case breaks it in one place.
pub const GOOD: &str = r#"{
  "version": 1,
  "title": "good",
  "length_unit": "m",
  "materials": {
    "white": { "type": "diffuse", "reflectance": 1 },
    "grey":  { "type": "diffuse", "reflectance": 0.5 }
  },
  "geometry": [
    { "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "white",
      "materials": { "floor": "grey" }, "max_element_edge": 0.5 },
    { "name": "panel", "type": "rectangle", "origin": [1,1,2.4], "u": [0,1,0], "v": [0.5,0,0], "material": "grey" },
    { "name": "ball", "type": "sphere", "center": [2,2,1], "radius": 0.25, "material": "grey" },
    { "name": "parts", "type": "mesh", "file": "parts.obj", "material": "grey",
      "transform": { "scale": 0.5, "rotate_deg": [0,0,90], "translate": [3,1,1] } }
  ],
  "luminaires": [
    { "name": "lamp", "type": "point", "position": [2,1,2], "intensity_cd": 100 },
    { "name": "troffer", "type": "area", "surface": "panel", "exitance_lm_m2": 4000, "dimming": 0.5 }
  ],
  "receivers": [
    { "name": "plane", "type": "grid", "origin": [0.5,0.5,0.8], "u": [3,0,0], "v": [0,2,0], "columns": 4, "rows": 3 },
    { "name": "task", "type": "grid", "surface": "room/floor", "height": 0.8, "margin": 0.5, "spacing": "EN 12464-1" },
    { "name": "probes", "type": "points", "file": "probes.csv" }
  ]
}
"#;

/// Replaces `old` (which stands once in the good file) by `new`; the fault lies at the first `at` from there on, at the
/// given JSON path, and the message says `says`.
pub struct Case {
    pub old: &'static str,
    pub new: &'static str,
    pub at: &'static str,
    pub json_path: &'static str,
    pub says: &'static str,
}

const fn case(
    old: &'static str,
    new: &'static str,
    at: &'static str,
    json_path: &'static str,
    says: &'static str,
) -> Case {
    Case { old, new, at, json_path, says }
}

/// One fault each.
pub const CASES: &[Case] = &[
    // JSON itself.
    case("\"version\": 1,", "\"version\": 1", "\n  \"title\"", "", "expected comma"),
    case("\"title\": \"good\",", "\"title\": \"good", "\n  \"length", "", "closing quote"),
    case("\"title\": \"good\",", "\"title\": ,", ",", "", "malformed JSON"),
    case("\"title\": \"good\",", "title: \"good\",", "title", "", "expected string for object property"),
    case("\"title\": \"good\",", "\"title\": 'good',", "'good'", "", "single-quoted"),
    case("\"title\": \"good\",", "\"title\": \"go\tod\",", "\tod", "", "control character"),
    case("\"title\": \"good\",", "// a comment\n", "// a comment", "", "comments"),
    case("\"reflectance\": 0.5 }\n", "\"reflectance\": 0.5 },\n", ",\n", "", "trailing comma"),
    case("\"reflectance\": 0.5", "\"reflectance\": .5", ".5", "", "decimal point"),
    case("\"reflectance\": 0.5", "\"reflectance\": 00.5", "0.5", "", "malformed JSON"),
    case("\"reflectance\": 0.5", "\"reflectance\": NaN", "NaN", "", "malformed JSON"),
    case("\"reflectance\": 0.5", "\"reflectance\": 0x1", "0x1", "", "hexadecimal"),
    case("  ]\n}\n", "  ]\n} }\n", "}\n", "", "more than one"),
    // Keys.
    case("\"title\": \"good\"", "\"titel\": \"good\"", "\"titel\"", "titel", "perhaps \"title\" is meant"),
    case("\"title\": \"good\"", "\"version\": 1", "\"version\": 1,\n  \"length", "version", "given twice"),
    case("\"grey\":  {", "\"white\":  {", "\"white\":  {", "materials.white", "given twice"),
    case(
        "\"radius\": 0.25",
        "\"radius\": 0.25, \"colour\": 3",
        "\"colour\"",
        "geometry[2].colour",
        "has no key \"colour\"",
    ),
    case("\"max_element_edge\": 0.5", "\"max_edge\": 0.5", "\"max_edge\"", "geometry[0].max_edge", "has no key"),
    case("\"dimming\": 0.5", "\"diming\": 0.5", "\"diming\"", "luminaires[1].diming", "perhaps \"dimming\" is meant"),
    case(
        "\"floor\": \"grey\"",
        "\"flor\": \"grey\"",
        "\"flor\"",
        "geometry[0].materials.flor",
        "perhaps \"floor\" is meant",
    ),
    case("\"scale\": 0.5", "\"size\": 0.5", "\"size\"", "geometry[3].transform.size", "has no key"),
    case("\"columns\": 4", "\"columns\": 4, \"height\": 1", "\"height\"", "receivers[0].height", "has no key"),
    case("\"type\": \"points\", ", "", "{ \"name\": \"probes\"", "receivers[2]", "needs the key \"type\""),
    case("\"origin\": [1,1,2.4], ", "", "{ \"name\": \"panel\"", "geometry[1]", "needs the key \"origin\""),
    // Version and units.
    case("\"version\": 1,", "\"version\": 2,", "2,", "version", "another version"),
    case("\"version\": 1,", "\"version\": \"1\",", "\"1\"", "version", "wrong type"),
    case("\"version\": 1,", "", "{\n  \n", "", "needs the key \"version\""),
    case("\"length_unit\": \"m\"", "\"length_unit\": \"metre\"", "\"metre\"", "length_unit", "none of the values"),
    case("\"length_unit\": \"m\"", "\"length_unit\": null", "null", "length_unit", "wrong type"),
    // Types and numbers.
    case("\"title\": \"good\"", "\"title\": 7", "7", "title", "wrong type"),
    case("\"radius\": 0.25", "\"radius\": \"0.25\"", "\"0.25\"", "geometry[2].radius", "wrong type"),
    case("\"radius\": 0.25", "\"radius\": -0.25", "-0.25", "geometry[2].radius", "negative"),
    case("\"radius\": 0.25", "\"radius\": 1e999", "1e999", "geometry[2].radius", "not finite"),
    case("\"min\": [0,0,0]", "\"min\": [0,0]", "[0,0]", "geometry[0].min", "has 2 numbers"),
    case("\"min\": [0,0,0]", "\"min\": [0,true,0]", "true", "geometry[0].min[1]", "wrong type"),
    case(
        "\"facing\": \"inward\"",
        "\"facing\": \"inwards\"",
        "\"inwards\"",
        "geometry[0].facing",
        "perhaps \"inward\" is meant",
    ),
    case("\"facing\": \"inward\"", "\"two_sided\": 1", "1,", "geometry[0].two_sided", "wrong type"),
    case("\"scale\": 0.5", "\"scale\": 0", "0,", "geometry[3].transform.scale", "the scale is 0"),
    case("\"max_element_edge\": 0.5", "\"max_element_edge\": -1", "-1", "geometry[0].max_element_edge", "negative"),
    case(
        "\"max_element_edge\": 0.5",
        "\"max_element_edge\": 1e-5",
        "1e-5",
        "geometry[0].max_element_edge",
        "too many elements",
    ),
    case(
        "\"radius\": 0.25",
        "\"radius\": 0.25, \"max_element_edge\": 1e-6",
        "1e-6",
        "geometry[2].max_element_edge",
        "too many",
    ),
    case("\"columns\": 4", "\"columns\": 0", "0,", "receivers[0].columns", "no count"),
    case("\"columns\": 4", "\"columns\": 2.5", "2.5", "receivers[0].columns", "no count"),
    case("\"columns\": 4", "\"columns\": 4000000000", "4000000000", "receivers[0].columns", "too many points"),
    // Materials.
    case("\"reflectance\": 0.5", "\"reflectance\": 1.5", "1.5", "materials.grey.reflectance", "above 1"),
    case(
        "\"reflectance\": 0.5",
        "\"reflectance\": 50",
        "50",
        "materials.grey.reflectance",
        "if 50 % is meant, write 0.5",
    ),
    case("\"reflectance\": 0.5", "\"reflectance\": -0.5", "-0.5", "materials.grey.reflectance", "negative"),
    case(
        "\"diffuse\", \"reflectance\": 0.5",
        "\"difuse\", \"reflectance\": 0.5",
        "\"difuse\"",
        "materials.grey.type",
        "perhaps \"diffuse\"",
    ),
    case(
        "\"diffuse\", \"reflectance\": 0.5",
        "\"phong\", \"diffuse_reflectance\": 0.6, \"specular_reflectance\": 0.5, \"exponent\": 60",
        "0.5, \"exponent\"",
        "materials.grey.specular_reflectance",
        "sum above 1",
    ),
    case(
        "\"diffuse\", \"reflectance\": 0.5",
        "\"translucent\", \"diffuse_reflectance\": 0.6, \"diffuse_transmittance\": 0.5",
        "0.5 }",
        "materials.grey.diffuse_transmittance",
        "sum above 1",
    ),
    case(
        "{ \"type\": \"diffuse\", \"reflectance\": 0.5 }",
        "{ \"type\": \"phong\", \"diffuse_reflectance\": 0.4, \"specular_reflectance\": 0.1, \"exponent\": 6e7 }",
        "6e7",
        "materials.grey.exponent",
        "too large",
    ),
    case(
        "\"diffuse\", \"reflectance\": 0.5",
        "\"glass\", \"refractive_index\": 0.9, \"internal_transmittance\": 1",
        "0.9",
        "materials.grey.refractive_index",
        "below 1",
    ),
    // Geometry.
    case("\"max\": [4,3,2.5]", "\"max\": [4,0,2.5]", "[4,0,2.5]", "geometry[0].max", "no extent along y"),
    case("\"max\": [4,3,2.5]", "\"max\": [4,3,2.5e20]", "{ \"name\": \"room\"", "geometry[0]", "too large"),
    case("\"v\": [0.5,0,0]", "\"v\": [0,2,0]", "[0,2,0]", "geometry[1].v", "has no area"),
    case(
        "\"name\": \"panel\", \"type\": \"rectangle\"",
        "\"name\": \"room\", \"type\": \"rectangle\"",
        "\"room\"",
        "geometry[1].name",
        "given twice",
    ),
    case(
        "\"name\": \"panel\", \"type\": \"rectangle\"",
        "\"name\": \"room/floor\", \"type\": \"rectangle\"",
        "\"room/floor\"",
        "geometry[1].name",
        "given twice",
    ),
    case(
        "\"name\": \"panel\", \"type\": \"rectangle\"",
        "\"name\": \" \", \"type\": \"rectangle\"",
        "\" \"",
        "geometry[1].name",
        "empty name",
    ),
    case(
        "\"radius\": 0.25, \"material\": \"grey\"",
        "\"radius\": 0.25, \"material\": \"gray\"",
        "\"gray\"",
        "geometry[2].material",
        "perhaps \"grey\" is meant",
    ),
    case(
        "\"radius\": 0.25, \"material\": \"grey\"",
        "\"radius\": 0.25",
        "{ \"name\": \"ball\"",
        "geometry[2]",
        "without a material",
    ),
    case(
        "\"file\": \"parts.obj\", \"material\": \"grey\"",
        "\"file\": \"parts.obj\"",
        "{ \"name\": \"parts\"",
        "geometry[3]",
        "no material for the mesh's part",
    ),
    case(
        "\"file\": \"parts.obj\", \"material\": \"grey\"",
        "\"file\": \"parts.obj\", \"material\": \"grey\", \"materials\": { \"Oka\": \"grey\" }",
        "\"Oka\"",
        "geometry[3].materials.Oka",
        "perhaps \"Oak\" is meant",
    ),
    case("\"type\": \"sphere\"", "\"type\": \"cylinder\"", "\"cylinder\"", "geometry[2].type", "none of the values"),
    // Luminaires.
    case("\"intensity_cd\": 100", "\"intensity_cd\": -100", "-100", "luminaires[0].intensity_cd", "negative"),
    case(
        "\"intensity_cd\": 100",
        "\"intensity_cd\": 100, \"luminous_flux_lm\": 9",
        "9 }",
        "luminaires[0].luminous_flux_lm",
        "given twice over",
    ),
    case(
        ", \"intensity_cd\": 100",
        "",
        "{ \"name\": \"lamp\"",
        "luminaires[0]",
        "needs \"intensity_cd\" or \"luminous_flux_lm\"",
    ),
    case(
        "\"intensity_cd\": 100",
        "\"intensity_cd\": 1e308",
        "1e308",
        "luminaires[0].intensity_cd",
        "out of all proportion",
    ),
    case(
        "\"intensity_cd\": 100",
        "\"aim\": [0,0,0], \"intensity_cd\": 100",
        "[0,0,0]",
        "luminaires[0].aim",
        "no direction",
    ),
    case(
        "\"surface\": \"panel\"",
        "\"surface\": \"pannel\"",
        "\"pannel\"",
        "luminaires[1].surface",
        "perhaps \"panel\" is meant",
    ),
    case("\"dimming\": 0.5", "\"dimming\": 1.5", "1.5", "luminaires[1].dimming", "above 1"),
    case("\"dimming\": 0.5", "\"maintenance_factor\": -0.1", "-0.1", "luminaires[1].maintenance_factor", "negative"),
    case(
        "\"name\": \"troffer\"",
        "\"name\": \"lamp\"",
        "\"lamp\", \"type\": \"area\"",
        "luminaires[1].name",
        "given twice",
    ),
    case(
        "\"intensity_cd\": 100",
        "\"intensity_cd\": 1e300",
        "1e300",
        "luminaires[0].intensity_cd",
        "out of all proportion",
    ),
    case(
        "\"intensity_cd\": 100",
        "\"intensity_cd\": 1e-300",
        "1e-300",
        "luminaires[0].intensity_cd",
        "out of all proportion",
    ),
    case(
        "\"intensity_cd\": 100",
        "\"intensity_cd\": 100, \"columns\": 3, \"u\": [0,0,0]",
        "[0,0,0]",
        "luminaires[0].u",
        "3 luminaires in one place",
    ),
    case(
        "\"type\": \"diffuse\", \"reflectance\": 0.5",
        "\"type\": \"glass\", \"refractive_index\": 1e200, \"internal_transmittance\": 0.9",
        "1e200",
        "materials.grey.refractive_index",
        "that of no glass",
    ),
    // Receivers.
    case("\"u\": [3,0,0]", "\"u\": [0,3,0]", "[0,2,0]", "receivers[0].v", "no normal"),
    case("\"margin\": 0.5", "\"margin\": 1.5", "1.5", "receivers[1].margin", "leaves nothing"),
    case("\"margin\": 0.5", "\"margin\": -0.5", "-0.5", "receivers[1].margin", "negative"),
    case("\"EN 12464-1\"", "\"EN 12464\"", "\"EN 12464\"", "receivers[1].spacing", "perhaps \"EN 12464-1\" is meant"),
    case("\"EN 12464-1\"", "1e-9", "1e-9", "receivers[1].spacing", "too many points"),
    case("\"surface\": \"room/floor\"", "\"surface\": \"room\"", "\"room\"", "receivers[1].surface", "it is not flat"),
    case(
        "\"surface\": \"room/floor\"",
        "\"surface\": \"room/flor\"",
        "\"room/flor\"",
        "receivers[1].surface",
        "perhaps \"room/floor\"",
    ),
    case(
        "\"name\": \"task\"",
        "\"name\": \"plane\"",
        "\"plane\", \"type\": \"grid\", \"surface\"",
        "receivers[1].name",
        "given twice",
    ),
    case(
        "\"type\": \"points\", \"file\": \"probes.csv\"",
        "\"type\": \"luminance\", \"position\": [1,1,1], \"directions\": []",
        "[]",
        "receivers[2].directions",
        "no direction to look in",
    ),
    case(
        "\"type\": \"points\", \"file\": \"probes.csv\"",
        "\"type\": \"ugr\", \"position\": [1,1,1], \"view_direction\": [0,0,0]",
        "[0,0,0]",
        "receivers[2].view_direction",
        "no direction",
    ),
    case(
        "\"type\": \"points\", \"file\": \"probes.csv\"",
        "\"type\": \"luminance\", \"position\": [1,1,1], \"fan\": { \"direction\": [0,0,1], \"from_deg\": 0, \"to_deg\": 9, \"count\": 3 }",
        "{ \"direction\": [0,0,1]",
        "receivers[2].fan",
        "are parallel",
    ),
    case(
        "\"type\": \"points\", \"file\": \"probes.csv\"",
        "\"type\": \"luminance\", \"position\": [1,1,1], \"view\": { \"direction\": [1,0,0], \"field_deg\": [175, 60], \"columns\": 4, \"rows\": 3 }",
        "175",
        "receivers[2].view.field_deg[0]",
        "too wide",
    ),
    case(
        "\"type\": \"points\", \"file\": \"probes.csv\"",
        "\"type\": \"luminance\", \"position\": [1,1,1], \"directions\": [[1,0,0]], \"fan\": {}",
        "{ \"name\": \"probes\"",
        "receivers[2]",
        "one set of directions",
    ),
];
