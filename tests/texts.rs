//! Texts in other languages: every text has a translation, and a page in another language contains no English.

mod common;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use common::{Silent, scene_of};
use luxmc::output::{Language, ReportContext, in_language, plots, report_files};
use luxmc::solver::{MapSelection, Settings, solve};

/// Files below a folder with this extension.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder of the sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|other| other == ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn source(folder: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    files(&folder, "rs").iter().map(|path| std::fs::read_to_string(path).expect("a source")).collect()
}

/// The string literal at the start of a text, as the compiler reads it.
fn literal(text: &str) -> Option<String> {
    let mut letters = text.trim_start().strip_prefix('"')?.chars().peekable();
    let mut read = String::new();
    loop {
        match letters.next()? {
            '"' => return Some(read),
            '\\' => match letters.next()? {
                '\n' => while letters.next_if(|letter| letter.is_whitespace()).is_some() {},
                'n' => read.push('\n'),
                'u' => {
                    let code: String = letters.by_ref().skip(1).take_while(|letter| *letter != '}').collect();
                    read.push(char::from_u32(u32::from_str_radix(&code, 16).ok()?)?);
                }
                letter => read.push(letter),
            },
            letter => read.push(letter),
        }
    }
}

/// All texts that the program writes in the language of its reader.
fn said() -> BTreeSet<String> {
    let mut said = BTreeSet::new();
    for text in ["src/output", "src/cli"].into_iter().flat_map(source) {
        for call in ["say!(", "words!("] {
            said.extend(text.split(call).skip(1).filter_map(literal));
        }
    }
    let view = include_str!("../src/output/view.html");
    said.extend(view.split("[[").skip(1).filter_map(|rest| Some(rest.split_once("]]")?.0.to_owned())));
    // The names of the kinds of luminaires stand with the kinds.
    let kinds = include_str!("../src/scene/emission.rs");
    let kinds: Vec<String> = kinds.split(" words: ").skip(1).filter_map(literal).collect();
    assert!(kinds.len() > 7, "the words of the kinds were not found: {kinds:?}");
    said.extend(kinds);
    // The placeholder in the documentation of the macros.
    said.remove("…");
    said
}

/// Code and texts of every language.
fn languages() -> Vec<(String, serde_json::Map<String, serde_json::Value>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/output/texts");
    files(&folder, "json")
        .iter()
        .map(|path| {
            let text = std::fs::read_to_string(path).expect("a file of texts");
            let file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            let texts = file["texts"].as_object().expect("texts").clone();
            (file["language"].as_str().expect("a code").to_owned(), texts)
        })
        .collect()
}

#[test]
fn every_language_has_words_for_all_that_is_said_and_for_nothing_else() {
    let said = said();
    assert!(said.len() > 200, "{}", said.len());
    let sources = source("src").concat();
    let known: Vec<&str> = Language::all().iter().map(|language| language.code()).collect();
    for (code, texts) in languages() {
        assert!(known.contains(&code.as_str()), "{code} is not among the files in texts.rs");
        let missing: Vec<&String> = said.iter().filter(|english| !texts.contains_key(*english)).collect();
        assert!(missing.is_empty(), "{code} has no words for {missing:#?}");
        // Texts of other rooms are string literals in their own sources.
        let is_dead = |english: &&String| !said.contains(*english) && !sources.contains(&format!("\"{english}\""));
        let dead: Vec<&String> = texts.keys().filter(is_dead).collect();
        assert!(dead.is_empty(), "{code} has words that nothing says: {dead:#?}");
        for (english, translated) in &texts {
            let translated = translated.as_str().expect("text");
            let places = |text: &str| text.matches('{').count();
            assert_eq!(places(english), places(translated), "{code}: {english}");
            let marks = |text: &str| ["<sub>", "<small>", "<b>", "</b>"].map(|mark| text.matches(mark).count());
            assert_eq!(marks(english), marks(translated), "{code}: {english}");
        }
    }
}

/// Texts of the standard's entries and of findings stand in other rooms. All of them need translations too.
#[test]
fn words_of_other_rooms_are_translated() {
    let entries = include_str!("../src/scene/standard_entries.rs");
    let (entries, _) = entries.split_once("    sports!(\"I\"").expect("entries of EN 12464-1 come first");
    let tasks = entries.split("entry!(").skip(1).filter_map(|entry| {
        let end = entry.rfind('"')?;
        literal(&entry[entry[..end].rfind('"')?..])
    });
    let mut wanted: BTreeSet<String> = tasks.collect();
    assert!(wanted.len() > 100);
    let verdicts = include_str!("../src/solver/verdicts.rs");
    wanted.extend(verdicts.split("Finding::Nothing(").skip(1).filter_map(literal));
    for (code, texts) in languages() {
        let missing: Vec<&String> = wanted.iter().filter(|english| !texts.contains_key(*english)).collect();
        assert!(missing.is_empty(), "{code} has no words for {missing:#?}");
    }
}

/// A room with everything that a report shows. Its names belong to no language.
const ROOM: &str = r#"{ "version": 1, "title": "X9", "energy": { "day_hours": 2000 },
  "materials": { "m1": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [
    { "name": "r1", "type": "box", "min": [0,0,0], "max": [6,5,3], "facing": "inward", "material": "m1", "max_element_edge": 1 },
    { "name": "p1", "type": "box", "min": [2,2,2.9], "max": [3,3,2.95], "material": "m1" } ],
  "luminaires": [
    { "name": "l1", "type": "area", "surface": "p1/floor", "luminous_flux_lm": 4000, "power_w": 40, "maintenance_factor": 0.8 },
    { "name": "l2", "type": "point", "position": [4,4,2.5], "luminous_flux_lm": 500, "power_w": 5, "dimming": 0.5 } ],
  "receivers": [
    { "name": "g1", "type": "grid", "surface": "r1/floor", "height": 0.8, "margin": 0.5, "spacing": "EN 12464-1",
      "requirements": { "en_12464_1": "34.2", "maximum_lx": 250 } },
    { "name": "g2", "type": "grid", "origin": [1,1,1], "u": [4,0,0], "v": [0,3,0], "columns": 5, "rows": 4, "quantity": "cylindrical" },
    { "name": "e1", "type": "grid", "origin": [1,1,0], "u": [4,0,0], "v": [0,3,0], "columns": 5, "rows": 4,
      "requirements": { "en_1838": "open area", "flux_factor": 0.2 } },
    { "name": "u1", "type": "ugr", "position": [0.5,2.5,1.2], "view_direction": [1,0,0], "requirements": { "ugr": 19 } } ] }"#;

/// English words that would be on the page if a text were not translated. Parts of surfaces have names as in scene files, such as
/// `r1/floor`.
const ENGLISH: [&str; 39] = [
    "the",
    "of",
    "and",
    "with",
    "is",
    "are",
    "for",
    "by",
    "from",
    "to",
    "error",
    "stated",
    "average",
    "illuminance",
    "luminaire",
    "luminaires",
    "surface",
    "surfaces",
    "power",
    "plan",
    "where",
    "required",
    "found",
    "verdict",
    "verdicts",
    "met",
    "not",
    "maintained",
    "maintenance",
    "dimmed",
    "values",
    "value",
    "points",
    "seen",
    "rays",
    "time",
    "light",
    "glare",
    "each",
];

/// A page without the parts that are not translated: styles, scripts, commands, and list items marked as English.
fn readable(page: &str) -> String {
    let mut text = page.to_owned();
    for [begin, end] in [
        ["<style", "</style>"],
        ["<script", "</script>"],
        ["<pre", "</pre>"],
        ["<code", "</code>"],
        ["<li lang=\"en\"", "</li>"],
    ] {
        while let Some(from) = text.find(begin) {
            let to = from + text[from..].find(end).expect("an end") + end.len();
            text.replace_range(from..to, " ");
        }
    }
    let mut plain = String::new();
    for piece in text.split('<') {
        // The text of labels is read too.
        if let Some((tag, behind)) = piece.split_once('>') {
            let labels = tag.split("aria-label=\"").skip(1).filter_map(|label| label.split('"').next());
            labels.for_each(|label| plain += &format!(" {label} "));
            plain += &format!(" {behind}");
        }
    }
    plain
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphabetic()).filter(|word| !word.is_empty())
}

/// The other data of a report, in one language.
fn context_in(language: Language) -> ReportContext {
    ReportContext {
        scene: "x9".into(),
        command: "luxmc".into(),
        repeats_digits: false,
        unix_time_s: 0,
        wall_s: 1.0,
        threads: 1,
        language,
    }
}

#[test]
fn no_english_and_no_decimal_point_is_left_on_a_page_in_german() {
    let scene = scene_of(ROOM);
    let settings = Settings { target_error: Some(0.05), maps: MapSelection::All, ..Settings::default() };
    let solution = solve(&scene, &settings, &Silent);
    let page_in = |language: Language| {
        let context = context_in(language);
        let drawn = in_language(language, || plots(&scene, &solution));
        let (page, pdf) = report_files(&scene, &solution, &drawn, &context);
        let pdf = pdf.expect("well-formed");
        assert!(pdf.name == "report.pdf" && pdf.bytes.starts_with(b"%PDF-") && pdf.bytes.len() > 20_000);
        let page = String::from_utf8(page.bytes).expect("text");
        assert!(page.contains(&format!("<html lang=\"{}\">", language.code())));
        readable(&page)
    };
    let german = page_in(Language::of_code("de").expect("German"));
    let left: BTreeSet<&str> = words(&german).filter(|word| ENGLISH.contains(&word.to_lowercase().as_str())).collect();
    assert!(left.is_empty(), "{left:?}");
    assert!(german.contains("LENI") && german.contains("Antipanikbereich") && german.contains("zylindrisch"));
    // Numbers of the standard's entries and of versions have points.
    let numbers = |text: &str| -> Vec<String> {
        let pieces = text.split(|letter: char| !letter.is_ascii_digit() && letter != '.');
        let is_decimal = |piece: &&str| {
            let mut parts = piece.split('.');
            matches!((parts.next(), parts.next(), parts.next()), (Some(a), Some(b), None) if !a.is_empty() && !b.is_empty())
        };
        pieces.filter(is_decimal).map(str::to_owned).filter(|number| number != "34.2" && number != "4.1").collect()
    };
    assert_eq!(numbers(&german), Vec::<String>::new());

    // The planted fault: the English page has these words and numbers with decimal points.
    let english = page_in(Language::ENGLISH);
    let left: BTreeSet<&str> = words(&english).filter(|word| ENGLISH.contains(&word.to_lowercase().as_str())).collect();
    assert!(left.len() > 30 && numbers(&english).len() > 20, "{left:?}");
}

#[test]
fn reports_of_sample_scenes_are_laid_out_as_pdf() {
    for name in ["daylight-office.json", "classroom.json", "corridor.json", "harmonics.json"] {
        let scene = common::scene(name);
        let settings = Settings { chains: Some(100), maps: MapSelection::Receivers, ..Settings::default() };
        let solution = solve(&scene, &settings, &Silent);
        for language in Language::all() {
            let context = context_in(language);
            let drawn = in_language(language, || plots(&scene, &solution));
            assert!(report_files(&scene, &solution, &drawn, &context).1.is_some(), "{name} in {}", language.code());
        }
    }
}
