//! The 3D view in a browser, if one is installed: it draws, and its values at a point are those of the tables. Nothing is loaded.

use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::report_view::{page_of, solved_scene, table};
use luxmc::MapSelection;
use luxmc::solver::ElementChoice;

/// A room whose work plane has its middle point in the middle of the room.
const SCENE: &str = r#"{ "version": 1, "title": "a room",
  "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint", "max_element_edge": 1 } ],
  "luminaires": [ { "name": "lamp", "type": "point", "position": [1, 1, 2], "intensity_cd": 100 } ],
  "receivers": [ { "name": "plane", "type": "grid", "origin": [1, 0.5, 0.8], "u": [2, 0, 0], "v": [0, 2, 0], "columns": 3, "rows": 3 } ] }"#;

/// Waits for the view, uses it like a person, and writes what it showed into the page.
const VISITOR: &str = r##"<pre id="told"></pre><script>
const wait = setInterval(() => {
  const view = document.getElementById("view");
  if (view.hidden) return;
  clearInterval(wait);
  const canvas = view.querySelector("canvas"), words = view.querySelector("output"), told = {};
  const gl = canvas.getContext("webgl");
  const press = (key) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key }));
  const drawn = async () => {
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const pixels = new Uint8Array(4 * canvas.width * canvas.height), colors = {};
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    for (let i = 0; i < pixels.length; i += 4) colors[pixels.slice(i, i + 3).join()] = 1;
    return Object.keys(colors).length;
  };
  (async () => {
    told.colors = [await drawn()];
    press("t");
    press("Enter");
    told.middle = words.textContent;
    const box = canvas.getBoundingClientRect(), at = { pointerId: 1, button: 0, clientX: box.left + 1, clientY: box.top + 1 };
    for (const kind of ["pointerdown", "pointerup"]) canvas.dispatchEvent(new PointerEvent(kind, at));
    told.corner = words.textContent;
    for (const button of view.querySelectorAll("[data-quantity]")) {
      button.click();
      told.colors.push(await drawn());
    }
    told.pressed = view.querySelector("[data-quantity='3']").getAttribute("aria-pressed");
    const cut = view.querySelector("[data-cut]");
    cut.value = 100;
    cut.dispatchEvent(new Event("input"));
    press("Enter");
    told.below = words.textContent;
    told.fetched = performance.getEntriesByType("resource").map((entry) => entry.name).filter((name) => !name.startsWith("data:"));
    document.getElementById("told").textContent = JSON.stringify(told);
  })();
}, 50);
</script></body>"##;

/// A headless browser that does not paint its page gives no animation frames. A timer replaces them.
const FRAMES: &str = "</title><script>window.requestAnimationFrame = (then) => setTimeout(then, 16);</script>";

/// The program of a browser like Chromium: from the environment, or one of the usual names.
fn browser() -> Option<String> {
    let named = std::env::var("CHROMIUM").ok();
    let usual = ["chromium", "chromium-browser", "google-chrome", "chrome"].map(str::to_owned);
    named.into_iter().chain(usual).find(|program| {
        let asked = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        asked.is_ok_and(|status| status.success())
    })
}

/// The page after its scripts and the visitor have run. A browser that hangs is ended.
fn visited(browser: &str, page: &str) -> String {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("report.html");
    std::fs::write(&path, page.replacen("</title>", FRAMES, 1).replace("</body>", VISITOR)).expect("written");
    let dom = home.path().join("dom.html");
    let mut running = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--disable-quic",
        ])
        .args(["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=60000", "--window-size=1000,1000"])
        .arg(format!("--user-data-dir={}", home.path().join("profile").display()))
        .args(["--dump-dom", &format!("file://{}", path.display())])
        .stdout(std::fs::File::create(&dom).expect("a file"))
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser starts");
    for _ in 0..12_000 {
        if running.try_wait().expect("told").is_some() {
            return std::fs::read_to_string(&dom).expect("text");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    running.kill().ok();
    panic!("{browser} has not shown the page after ten minutes");
}

#[test]
fn the_view_draws_and_reads_what_the_tables_say() {
    let Some(browser) = browser() else {
        // Written directly to standard error, because the test runner captures what tests print.
        let words = "skipped: no browser was found (chromium, or what the environment variable CHROMIUM names); the view was not tried\n";
        std::io::stderr().write_all(words.as_bytes()).ok();
        return;
    };
    let (scene, solution) = solved_scene(SCENE, ElementChoice::Given, MapSelection::All);
    let page = page_of(&scene, &solution);
    let dom = visited(&browser, &page);
    let told = dom.split("<pre id=\"told\">").nth(1).and_then(|rest| rest.split("</pre>").next()).expect("a page");
    let told = told.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let told: Value = serde_json::from_str(&told).unwrap_or_else(|_| panic!("the view has not come up: {told:?}"));

    // More colours than those of background, outlines and luminaires, for every quantity.
    let colors: Vec<u64> = told["colors"].as_array().expect("five").iter().filter_map(Value::as_u64).collect();
    assert!(colors.len() == 5 && colors.iter().all(|count| *count > 8), "{colors:?}");
    assert_eq!(told["pressed"], "true");
    assert_eq!(told["fetched"], serde_json::json!([]), "the page needs nothing but itself");
    assert!(told["corner"].as_str().expect("words").starts_with("Nothing there"), "{told}");
    assert!(told["below"].as_str().expect("words").starts_with("room/floor: "), "below the work plane: {told}");

    // The middle point of the plane, seen from above.
    let words = told["middle"].as_str().expect("words");
    let row = &table(&scene, &solution, "receivers.csv")[4];
    let numbers: Vec<f64> = words.split([' ', ';', ',']).filter_map(|word| word.parse().ok()).collect();
    let [total_lx, error_lx, direct_lx, indirect_lx, place_m @ ..] = numbers.as_slice() else { panic!("{words}") };
    assert!(words.starts_with("plane: "), "{words}");
    assert_eq!(place_m[..2], [2.0, 1.5], "{words}");
    let is_reported = |told: f64, number: f64| {
        (told - number).abs() <= 0.5 * 10f64.powf(number.log10().floor() - 1.0).min(1.0) * 1.01
    };
    let of = |column: usize| row[column].parse::<f64>().expect("a number");
    for (told, column) in [(total_lx, 8), (direct_lx, 10), (indirect_lx, 11)] {
        assert!(is_reported(*told, of(column)), "{words}: {told} is not {}", of(column));
        assert!(!is_reported(*told, 1.1 * of(column)), "what is a tenth off is seen");
    }
    assert!((error_lx / of(9) - 1.0).abs() < 0.5, "{words}: {}", of(9));
}
