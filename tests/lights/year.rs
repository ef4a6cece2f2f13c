//! A year of daylight: its hours against runs with the same sky and sun and against closed forms, and its errors against the scatter of
//! seeds.

use std::f64::consts::PI;
use std::path::Path;

use luxmc::maps::Estimate;
use luxmc::scene::{Emission, Scene, Weather, WeatherHour, WeatherLight};
use luxmc::solver::MapSelection;
use luxmc::year::{
    Blinds, NotForYear, SetSunlight, SunSite, YearMeasure, YearSettings, YearSky, YearSolution, solve_year,
    sum_of_hours, sunlight,
};
use serde_json::{Value, json};

use crate::common;

const DIRECT_LX: f64 = 70_000.0;
const DIFFUSE_LX: f64 = 14_000.0;
/// 52° N, 13° E.
const SITE: [f64; 2] = [52.0, 13.0];

fn rectangle(name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3], material: &str) -> Value {
    json!({ "name": name, "type": "rectangle", "origin": origin, "u": u, "v": v, "material": material, "max_element_edge": 2 })
}

/// A room of 4 m × 4 m × 3 m with a window of 3 m × 1.5 m to the south, with or without glazing.
fn room(material: &str, is_glazed: bool) -> Vec<Value> {
    let wall = |name: &str, origin, u, v| rectangle(name, origin, u, v, material);
    let mut parts = vec![
        wall("floor", [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]),
        wall("ceiling", [0.0, 0.0, 3.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0]),
        wall("back", [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 3.0]),
        wall("left", [0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0]),
        wall("right", [4.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 4.0, 0.0]),
        wall("front 1", [0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.5, 0.0, 0.0]),
        wall("front 2", [3.5, 0.0, 0.0], [0.0, 0.0, 3.0], [0.5, 0.0, 0.0]),
        wall("front 3", [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0]),
        wall("front 4", [0.5, 0.0, 2.5], [0.0, 0.0, 0.5], [3.0, 0.0, 0.0]),
    ];
    if is_glazed {
        parts.push(rectangle("window", [0.5, 0.0, 1.0], [0.0, 0.0, 1.5], [3.0, 0.0, 0.0], "pane"));
    }
    parts
}

fn grid(name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3], columns: u32, rows: u32) -> Value {
    json!({ "name": name, "type": "grid", "origin": origin, "u": u, "v": v, "columns": columns, "rows": rows })
}

fn work_plane() -> Value {
    json!([grid("plane", [0.5, 0.5, 0.85], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], 3, 4)])
}

fn scene(geometry: Vec<Value>, luminaires: Vec<Value>, receivers: Value) -> Scene {
    let value = json!({ "version": 1,
        "materials": { "paint": { "type": "diffuse", "reflectance": 0.6 }, "black": { "type": "diffuse", "reflectance": 0 },
                       "pane": { "type": "glass", "refractive_index": 1.52, "internal_transmittance": 0.9 } },
        "geometry": geometry, "luminaires": luminaires, "receivers": receivers });
    common::scene_of(&value.to_string())
}

/// A sky whose light is given by the weather data.
fn sky() -> Value {
    json!({ "name": "sky", "type": "sky", "luminance_distribution": "overcast", "horizontal_illuminance_lx": 1000, "ground_reflectance": 0.2 })
}

fn weather(hours: &[(u32, u32, f64, [f64; 2])]) -> Weather {
    let hours = hours.iter().map(|(month, day, middle_hours, light)| WeatherHour {
        month: *month,
        day: *day,
        middle_hours: *middle_hours,
        light: WeatherLight::Illuminance(*light),
    });
    let [latitude_deg, longitude_deg] = SITE;
    Weather { place: "here".into(), latitude_deg, longitude_deg, time_zone_hours: 1.0, hours: hours.collect() }
}

fn settings(subdivision: u32, seed: u64, target_error: f64) -> YearSettings {
    YearSettings { subdivision, occupied_hours: [0.0, 24.0], target_error, seed, blinds: None }
}

/// The solution of the year, and every hour's illuminance for each point.
fn year(scene: &Scene, weather: &Weather, settings: &YearSettings) -> (YearSolution, Vec<Vec<Estimate>>) {
    let mut points = Vec::new();
    let solution = solve_year(scene.clone(), weather, settings, |_: &YearSky, hours| {
        let both = hours.lx.iter().zip(hours.standard_error_lx);
        points.push(both.map(|(value, error)| Estimate { value: *value, standard_error: *error }).collect());
        Ok::<(), NotForYear>(())
    });
    (solution.expect("a year"), points)
}

/// Largest difference of the points in combined standard errors, and the relative difference of their means.
fn differences(points: &[Estimate], others: &[Estimate]) -> (f64, f64) {
    let worst = points
        .iter()
        .zip(others)
        .map(|(one, other)| (one.value - other.value).abs() / (one.standard_error.hypot(other.standard_error) + 1e-9));
    let sum = |values: &[Estimate]| values.iter().map(|estimate| estimate.value).sum::<f64>();
    (worst.fold(0.0, f64::max), sum(points) / sum(others) - 1.0)
}

/// One hour by two methods. The first is daylight coefficients times Perez's patches and the sun. The second is `solve` with that sky and
/// sun as luminaires. Its walks, cells and openings share nothing with the first but rays and BSDFs. The hours are a clear noon in March
/// through a pane, and an overcast one without sun through an opening.
///
/// Seed 3, errors of 1 % and 0.7 %: twelve points agree within 6 combined errors (α some 1e-4 for all with 15 degrees of freedom), and
/// their means within 1.5 %, of which the patches may use 1 %. A sun 5 % stronger, the planted fault, is detected by the mean.
#[test]
fn an_hour_of_the_year_is_the_run_with_its_sky_and_sun() {
    for (is_glazed, direct_lx, month) in [(true, DIRECT_LX, 3), (false, 0.0, 11)] {
        let given = weather(&[(month, 10, 12.5, [direct_lx, DIFFUSE_LX])]);
        let (solution, points) =
            year(&scene(room("paint", is_glazed), vec![sky()], work_plane()), &given, &settings(4, 3, 0.01));
        let hour = solution.sky.hours[0];
        let elevation_deg = hour.towards_sun.z.asin().to_degrees();
        let azimuth_deg = hour.towards_sun.x.atan2(hour.towards_sun.y).to_degrees();
        let run = |direct_lx: f64| {
            let place = json!({ "sun_elevation_deg": elevation_deg, "sun_azimuth_deg": azimuth_deg });
            let with = |mut luminaire: Value| {
                luminaire.as_object_mut().expect("an object").extend(place.as_object().expect("an object").clone());
                luminaire
            };
            let perez = json!({ "name": "sky", "type": "sky", "luminance_distribution": "Perez", "ground_reflectance": 0.2 * (1.0 + direct_lx * hour.towards_sun.z / DIFFUSE_LX),
                "direct_normal_illuminance_lx": direct_lx, "diffuse_horizontal_illuminance_lx": DIFFUSE_LX });
            let sun = json!({ "name": "sun", "type": "sun", "normal_illuminance_lx": direct_lx });
            let lights = if direct_lx > 0.0 { vec![with(perez), with(sun)] } else { vec![with(perez)] };
            let solution = common::to_target(
                &scene(room("paint", is_glazed), lights, work_plane()),
                4,
                MapSelection::Receivers,
                0.007,
            );
            let values = &solution.maps[0].values;
            let both = values.value.iter().zip(&values.standard_error);
            both.map(|(value, error)| Estimate { value: *value, standard_error: *error }).collect::<Vec<_>>()
        };
        let found: Vec<Estimate> = points.iter().map(|hours| hours[0]).collect();
        let (worst, mean) = differences(&found, &run(direct_lx));
        assert!(worst < 6.0 && mean.abs() < 0.015, "glazed {is_glazed}: {worst:.2} errors, mean {mean:.4}");
        if direct_lx > 0.0 {
            let (_, mean) = differences(&found, &run(1.05 * direct_lx));
            assert!(mean.abs() > 0.015, "the planted fault passed: {mean}");
        }
    }
}

/// In the open field a horizontal point receives the weather's illuminance of sky and sun, for any pattern of the sky. Hours of night are
/// left out. Seed 1: within 7 errors (α some 1e-5) and 1 %. With 3 % more, the planted fault, neither holds.
#[test]
fn the_open_field_receives_the_weather() {
    let hours = [(6, 21, 12.5, [DIRECT_LX, DIFFUSE_LX]), (6, 21, 6.5, [20_000.0, 6_000.0]), (1, 10, 0.5, [0.0, 0.0])];
    let pit = vec![rectangle("pit", [0.0, 0.0, -9.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], "black")];
    let receivers = json!([grid("up", [1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 2, 2)]);
    let (solution, points) = year(&scene(pit, vec![sky()], receivers), &weather(&hours), &settings(2, 1, 0.002));
    assert_eq!((solution.sky.hours.len(), solution.sky.all, solution.sky.occupied), (2, 3, 3));
    for point in &points {
        for (found, hour) in point.iter().zip(&solution.sky.hours) {
            let outside_lx = hour.outside_lx[0] + hour.outside_lx[1];
            let off = |lx: f64| ((found.value - lx).abs() / found.standard_error, (found.value / lx - 1.0).abs());
            let (errors, share) = off(outside_lx);
            assert!(errors < 7.0 && share < 0.01, "{errors}, {share}");
            let (errors, share) = off(1.03 * outside_lx);
            assert!(errors > 7.0 && share > 0.01, "the planted fault passed: {errors}, {share}");
        }
    }
    let [noon, morning] = [0, 1].map(|hour: usize| solution.sky.hours[hour].outside_lx);
    assert!((noon[0] - DIFFUSE_LX).abs() < 1e-6 && (morning[0] - 6000.0).abs() < 1e-6);
    let height = solution.sky.hours[0].towards_sun.z;
    assert!((noon[1] - DIRECT_LX * height).abs() < 1e-6 * noon[1] && (0.85..0.9).contains(&height), "{height}");
}

/// The light of a sky whose sun is below the horizon is that of the overcast sky: its hours divided by the outdoor illuminance are the
/// daylight factors. The room faces a wall, so that most of its light was reflected there first. Seeds 5 and 6, errors of 0.7 %: within 6
/// combined errors and 1 %. With daylight factors 3 % larger, the planted fault, the mean is not.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn overcast_hours_are_daylight_factors() {
    let mut parts = room("paint", false);
    parts.push(rectangle("outside", [-1.0, -1.5, 0.0], [0.0, 0.0, 4.0], [6.0, 0.0, 0.0], "paint"));
    let given = weather(&[(12, 20, 20.5, [0.0, 8000.0])]);
    let scene = scene(parts, vec![sky()], work_plane());
    let (solution, points) = year(&scene, &given, &settings(4, 5, 0.007));
    assert!(solution.sky.hours[0].towards_sun.z < 0.0 && solution.sky.hours[0].sun_lx == 0.0);
    let run = common::to_target(&scene, 6, MapSelection::Receivers, 0.007);
    let values = &run.maps[0].values;
    let factors = |times: f64| {
        let both = values.value.iter().zip(&values.standard_error);
        both.map(|(value, error)| Estimate { value: 8.0 * times * value, standard_error: 8.0 * error })
            .collect::<Vec<_>>()
    };
    let found: Vec<Estimate> = points.iter().map(|hours| hours[0]).collect();
    let (worst, mean) = differences(&found, &factors(1.0));
    assert!(worst < 6.0 && mean.abs() < 0.01, "{worst:.2} errors, mean {mean:.4}");
    assert!(differences(&found, &factors(1.03)).1.abs() > 0.01, "the planted fault passed");
    // The sum of the three components, whose walks weight the sky without patches; and the sky component alone, which is the run's direct
    // part.
    let components = |year: &YearSolution, index: usize| {
        let measures = year.sets[0].points[index].measures;
        [YearMeasure::SkyComponent, YearMeasure::FromOutside, YearMeasure::FromInside].map(|one| measures[one as usize])
    };
    let percent = |lx: f64| 0.1 * lx;
    let (mut sums, mut direct) = ([0.0; 2], [0.0; 2]);
    for index in 0..points.len() {
        let [sky, outside, inside] = components(&solution, index);
        sums = [sums[0] + sky.value + outside.value + inside.value, sums[1] + percent(values.value[index])];
        direct = [direct[0] + sky.value, direct[1] + percent(values.direct[index])];
        assert!(outside.value > 0.0 && inside.value > 0.0 && sky.standard_error < 0.02 * sky.value.max(1.0));
    }
    assert!(
        (sums[0] / sums[1] - 1.0).abs() < 0.01 && (direct[0] / direct[1] - 1.0).abs() < 0.01,
        "{sums:?}, {direct:?}"
    );
    assert!((sums[0] / direct[1] - 1.0).abs() > 0.01, "the planted fault passed");
    // The run's own components, from walks under its sky: the mean of each agrees within 3 %. With 8 % more it does not.
    let split = |way: usize, times: f64| {
        let of_run: f64 = values.sky_components_lx.iter().map(|parts| times * percent(parts[way].value)).sum();
        let of_year: f64 = (0..points.len()).map(|index| components(&solution, index)[way].value).sum();
        (of_run / of_year - 1.0).abs()
    };
    for way in 0..3 {
        assert!(split(way, 1.0) < 0.03 && split(way, 1.08) > 0.03, "part {way}: {}", split(way, 1.0));
    }
    for (parts, lx) in values.sky_components_lx.iter().zip(&values.value) {
        assert!((parts.iter().map(|part| part.value).sum::<f64>() / lx - 1.0).abs() < 1e-9);
        assert!(parts.iter().all(|part| part.standard_error < 0.1 * lx));
    }
    // With black walls nothing is reflected inside.
    let mut parts = room("black", false);
    parts.push(rectangle("outside", [-1.0, -1.5, 0.0], [0.0, 0.0, 4.0], [6.0, 0.0, 0.0], "paint"));
    let black = year(&scene_of_parts(parts), &given, &settings(1, 5, 0.02)).0;
    for index in 0..points.len() {
        let [_, outside, inside] = components(&black, index);
        assert!(outside.value > 0.0 && inside.value == 0.0, "{outside:?}, {inside:?}");
    }
}

fn scene_of_parts(parts: Vec<Value>) -> Scene {
    scene(parts, vec![sky()], work_plane())
}

/// Behind a black shutter it is dark all year. Polar day and polar night are right: a sun at midnight, and no sun.
#[test]
fn shutters_and_poles() {
    let mut parts = room("paint", false);
    parts.push(rectangle("shutter", [0.5, 0.0, 1.0], [0.0, 0.0, 1.5], [3.0, 0.0, 0.0], "black"));
    let hours = [(6, 21, 0.5, [30_000.0, 8000.0]), (12, 21, 12.5, [0.0, 300.0]), (3, 1, 1.5, [0.0, 0.0])];
    let pole = Weather { latitude_deg: 80.0, ..weather(&hours) };
    let (solution, points) = year(&scene(parts, vec![sky()], work_plane()), &pole, &settings(1, 1, 0.03));
    assert!(points.iter().flatten().all(|hour| hour.value == 0.0 && hour.standard_error == 0.0));
    let dark = solution.sets[0].averages[YearMeasure::TooLittle as usize];
    assert!(dark.value == 1.0 && dark.standard_error == 0.0, "{dark:?}");
    let [midnight, noon] = [0, 1].map(|hour: usize| solution.sky.hours[hour]);
    assert!((midnight.towards_sun.z.asin().to_degrees() - 13.4).abs() < 0.2 && midnight.sun_lx > 0.0);
    assert!(noon.towards_sun.z < 0.0 && noon.sun_lx == 0.0);
}

/// Again in the open field: with the sun in the zenith of a tropic, just above the horizon, and on a polar day at midnight and noon. The
/// illuminance is that of the weather within 7 errors and 1 %; 3 % more, the planted fault, is not within 1 %.
#[test]
fn the_sun_in_the_zenith_on_the_horizon_and_at_midnight() {
    let hours = [(6, 21, 12.03, [90_000.0, 12_000.0]), (6, 21, 5.35, [3000.0, 900.0])];
    let tropic = Weather { latitude_deg: 23.44, longitude_deg: 15.0, ..weather(&hours) };
    let day = [(6, 21, 0.5, [30_000.0, 8000.0]), (6, 21, 12.5, [70_000.0, 9000.0])];
    let pole = Weather { latitude_deg: 80.0, ..weather(&day) };
    for (site, heights_deg) in [(tropic, [89.5..90.1, 0.3..1.5]), (pole, [13.2..13.6, 33.2..33.6])] {
        open_field(&site, heights_deg);
    }
}

/// Checks the hours of a site in the open field, with these ranges for the height of the sun.
fn open_field(site: &Weather, expected_deg: [std::ops::Range<f64>; 2]) {
    let pit = vec![rectangle("pit", [0.0, 0.0, -9.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], "black")];
    let receivers = json!([grid("up", [1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 2, 2)]);
    let (solution, points) = year(&scene(pit, vec![sky()], receivers), site, &settings(1, 1, 0.002));
    let heights_deg = [0, 1].map(|hour: usize| solution.sky.hours[hour].towards_sun.z.asin().to_degrees());
    assert!(expected_deg.iter().zip(&heights_deg).all(|(range, height)| range.contains(height)), "{heights_deg:?}");
    for (found, hour) in points.iter().flat_map(|point| point.iter().zip(&solution.sky.hours)) {
        let outside_lx = hour.outside_lx[0] + hour.outside_lx[1];
        let off = |lx: f64| ((found.value - lx).abs() / found.standard_error, (found.value / lx - 1.0).abs());
        let ((errors, share), (_, faulty)) = (off(outside_lx), off(1.03 * outside_lx));
        assert!(errors < 7.0 && share < 0.01 && faulty > 0.01, "{errors}, {share}, {faulty}");
    }
}

/// A board between points and window hides the sky. The points get the light of the run under the same sky and no sky component. Seeds 5
/// and 6, errors of 1 %: the means agree within 1.5 %. With 4 % more, the planted fault, they do not.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn light_that_comes_by_a_bounce_alone_is_met() {
    let mut parts = room("paint", false);
    let mut board = rectangle("board", [0.0, 0.6, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 2.9], "paint");
    board["two_sided"] = json!(true);
    parts.push(board);
    let receivers = json!([grid("plane", [0.5, 2.0, 0.85], [3.0, 0.0, 0.0], [0.0, 1.5, 0.0], 3, 4)]);
    let scene = scene(parts, vec![sky()], receivers);
    let (solution, points) = year(&scene, &weather(&[(12, 20, 20.5, [0.0, 1000.0])]), &settings(4, 5, 0.01));
    let run = common::to_target(&scene, 6, MapSelection::Receivers, 0.01);
    let sum_lx: f64 = points.iter().map(|hours| hours[0].value).sum();
    let run_lx: f64 = run.maps[0].values.value.iter().sum();
    assert!(run_lx > 0.0 && (sum_lx / run_lx - 1.0).abs() < 0.015, "{sum_lx}, {run_lx}");
    assert!((1.04 * sum_lx / run_lx - 1.0).abs() > 0.015, "the planted fault passed");
    let measures = |measure: YearMeasure| solution.sets[0].averages[measure as usize];
    assert!(measures(YearMeasure::SkyComponent).value == 0.0 && measures(YearMeasure::FromInside).value > 0.0);
    let parts = &run.maps[0].values.sky_components_lx;
    assert!(parts.iter().all(|[sky, _, inside]| sky.value == 0.0 && inside.value > 0.0));
}

/// Points that face down on a floor outdoors get the sky only by one reflection: ρ E_h times Lambert's factor of the floor. Seed 1, an
/// error of 0.5 %: the mean agrees within 1 %. With 3 % more, the planted fault, it does not.
#[test]
fn a_sky_that_is_seen_by_one_bounce_alone_brings_its_exact_share() {
    let floor = vec![rectangle("floor", [-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], "paint")];
    let receivers = json!([grid("down", [-0.01, -0.01, 1.0], [0.0, 0.02, 0.0], [0.02, 0.0, 0.0], 2, 2)]);
    let mut dark_ground = sky();
    dark_ground["ground_reflectance"] = json!(0);
    let given = weather(&[(12, 20, 20.5, [0.0, 8000.0])]);
    let (solution, points) = year(&scene(floor, vec![dark_ground], receivers), &given, &settings(4, 1, 0.005));
    let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|[x, y]| glam::DVec3::new(x, y, 0.0));
    let factor = luxmc::base::polygon::polygon_illuminance_factor(glam::DVec3::Z, glam::DVec3::NEG_Z, &corners).abs();
    let mean_lx = points.iter().map(|hours| hours[0].value).sum::<f64>() / points.len() as f64;
    let exact_lx = 0.6 * 8000.0 * factor;
    assert!((mean_lx / exact_lx - 1.0).abs() < 0.01, "{mean_lx}, {exact_lx}");
    assert!((1.03 * mean_lx / exact_lx - 1.0).abs() > 0.01, "the planted fault passed");
    assert_eq!(solution.sets[0].averages[YearMeasure::SkyComponent as usize].value, 0.0);
}

/// A board hides the sun's disk except a segment that begins at a third of its radius. The points are so close together that all see the
/// same. More light samples reduce its error to 5 % (sixteen leave 39 %). Seed 1: all 32 points meet a target of 8 %, are within 7 of their
/// errors and scatter by these within a third. Their mean is that of the segment within 3 %. With a third more, the planted fault, it is
/// not.
#[test]
fn suns_that_are_half_hidden_are_sampled_until_their_error_is_met() {
    const FAR_M: f64 = 20.0;
    const SHOWN_FROM: f64 = 1.0 / 3.0;
    let given = weather(&[(6, 21, 12.5, [DIRECT_LX, 1.0])]);
    let towards = YearSky::of(&given, 1, 0.0, 1.0, |_| true).hours[0].towards_sun;
    let across = towards.cross(glam::DVec3::Z).normalize();
    let up = across.cross(towards);
    // Its edge is at this distance from the centre. Its other edges are beyond the disk.
    let radius_m = FAR_M * 0.265f64.to_radians().tan();
    let corner = FAR_M * towards + SHOWN_FROM * radius_m * across - 0.5 * up - across;
    let mut board = rectangle("board", corner.to_array(), across.to_array(), up.to_array(), "black");
    board["two_sided"] = json!(true);
    let receivers = json!([grid("up", [-0.0005, -0.0005, 0.0], [0.001, 0.0, 0.0], [0.0, 0.001, 0.0], 8, 4)]);
    let mut dark_ground = sky();
    dark_ground["ground_reflectance"] = json!(0);
    let (solution, points) = year(&scene(vec![board], vec![dark_ground], receivers), &given, &settings(1, 1, 0.08));
    assert!(solution.target_met(), "{}", solution.sets[0].worst_error);
    let shown = (SHOWN_FROM.acos() - SHOWN_FROM * (1.0 - SHOWN_FROM * SHOWN_FROM).sqrt()) / PI;
    let exact_lx = shown * DIRECT_LX * towards.z + 1.0;
    let found: Vec<Estimate> = points.iter().map(|hours| hours[0]).collect();
    let scores: Vec<f64> = found.iter().map(|lx| (lx.value - exact_lx) / lx.standard_error).collect();
    let scatter = (scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64).sqrt();
    assert!(scores.iter().all(|score| score.abs() < 7.0) && (0.67..1.33).contains(&scatter), "{scatter}, {scores:?}");
    let mean_lx = found.iter().map(|lx| lx.value).sum::<f64>() / found.len() as f64;
    let off = |exact_lx: f64| (mean_lx / exact_lx - 1.0).abs();
    assert!(off(exact_lx) < 0.03 && off(4.0 / 3.0 * exact_lx) > 0.03, "{mean_lx}, {exact_lx}");
}

/// Suns of many days in one run give the same as each day alone. Nine hours of sixty-one days, whose reflected sun comes from nodes among
/// them, are compared with the hours of single days, which are nodes themselves. Seed 2, errors of 1.5 %: the ratios are within 2 % in the
/// root mean square over the plane's means, and within 1 % in the mean. Hours taken from ten days later, the planted fault, are off by
/// more.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn nodes_of_the_suns_way_stand_for_its_hours() {
    // Points that face the back wall: the sun never shines on them directly.
    let receivers = json!([grid("back", [0.5, 2.0, 0.5], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0], 3, 4)]);
    let scene = scene(room("paint", false), vec![sky()], receivers);
    let hours = |from: u32, days: u32| {
        let hour = |day: u32, at: u32| (3 + day / 31, 1 + day % 31, f64::from(at) + 0.5, [60_000.0, 15_000.0]);
        (from..from + days).flat_map(|day| (8..17).map(move |at| hour(day, at))).collect::<Vec<_>>()
    };
    let means = |from: u32, days: u32| {
        let (solution, _) = year(&scene, &weather(&hours(from, days)), &settings(1, 2, 0.015));
        solution.sets[0].hourly_lx.clone()
    };
    let all = means(0, 61);
    let off = |shift: usize| {
        let days = [3, 17, 30, 44];
        let ratios = days.into_iter().flat_map(|day| {
            let alone = means(day as u32, 1);
            let together = all[9 * (day + shift)..9 * (day + shift + 1)].to_vec();
            together.into_iter().zip(alone).map(|(together, alone)| together / alone - 1.0)
        });
        let ratios: Vec<f64> = ratios.collect();
        let count = ratios.len() as f64;
        [(ratios.iter().map(|off| off * off).sum::<f64>() / count).sqrt(), ratios.iter().sum::<f64>() / count]
    };
    let [spread, mean] = off(0);
    assert!(spread < 0.02 && mean.abs() < 0.01, "{spread}, {mean}");
    assert!(off(10)[0] > 0.02, "the planted fault passed: {:?}", off(10));
}

/// Errors of hours also hold with a low sun and a building in front of the window. Fifty-nine winter days under a sky of 1000 lx are
/// computed to 3 %. Four of the days are compared with years of these days alone, whose suns are nodes themselves, with other seeds and to
/// 1.5 %. Seed 7, 12 points and 4 × 7 hours, which share their walks: at least 86 % of the differences are within 2.13 combined errors,
/// where 95 % should be, and they scatter by 0.7 to 1.4 of these. With errors half as large, the planted fault, neither holds.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn errors_of_hours_hold_where_the_sun_is_low() {
    let mut parts = room("paint", false);
    parts.push(rectangle("opposite", [-3.0, -9.0, -4.0], [0.0, 0.0, 7.0], [7.0, 0.0, 0.0], "paint"));
    let receivers = json!([grid("back", [0.5, 2.0, 0.5], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0], 3, 4)]);
    let scene = scene(parts, vec![sky()], receivers);
    let hours = |from: u32, days: u32| {
        let hour = |day: u32, at: u32| (1 + day / 31, 1 + day % 31, f64::from(at) + 0.5, [DIRECT_LX, 1000.0]);
        (from..from + days).flat_map(|day| (9..16).map(move |at| hour(day, at))).collect::<Vec<_>>()
    };
    let of = |from, days, seed, target| year(&scene, &weather(&hours(from, days)), &settings(1, seed, target)).1;
    let all = of(0, 59, 7, 0.03);
    let mut scores = Vec::new();
    for day in [4, 19, 33, 48] {
        let alone = of(day, 1, 1000 + u64::from(day), 0.015);
        for (together, alone) in all.iter().zip(&alone) {
            let first = 7 * day as usize;
            let both = together[first..first + 7].iter().zip(alone);
            scores.extend(both.map(|(a, b)| (a.value - b.value) / a.standard_error.hypot(b.standard_error)));
        }
    }
    let told = |times: f64| {
        let count = scores.len() as f64;
        let within = scores.iter().filter(|score| (times * **score).abs() <= 2.13).count() as f64 / count;
        (within, times * (scores.iter().map(|score| score * score).sum::<f64>() / count).sqrt())
    };
    let holds = |(within, scatter): (f64, f64)| (within >= 0.86, (0.7..1.4).contains(&scatter));
    assert_eq!(holds(told(1.0)), (true, true), "{:?}", told(1.0));
    assert_eq!(holds(told(2.0)), (false, false), "the planted fault passed: {:?}", told(2.0));
}

/// A warning names a mirror, because suns reflected by it are left out. The error of the patches is larger for large patches.
#[test]
fn what_is_left_out_is_reported() {
    let mut parts = room("paint", false);
    let told = |parts: &[Value], subdivision: u32| {
        let value = json!({ "version": 1,
            "materials": { "paint": { "type": "diffuse", "reflectance": 0.6 }, "glass": { "type": "mirror", "reflectance": 0.9 } },
            "geometry": parts, "luminaires": [sky()], "receivers": work_plane() });
        year(&common::scene_of(&value.to_string()), &a_day(), &settings(subdivision, 1, 0.1)).0
    };
    let (coarse, fine) = (told(&parts, 1), told(&parts, 4));
    assert!(coarse.warnings.is_empty());
    assert!(
        coarse.patch_error > 2.0 * fine.patch_error && coarse.patch_error < 0.2,
        "{} {}",
        coarse.patch_error,
        fine.patch_error
    );
    parts.push(rectangle("looking glass", [0.1, 1.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], "glass"));
    let warned = told(&parts, 1).warnings.join("\n");
    assert!(warned.contains("looking glass") && warned.contains("mirrors"), "{warned}");
}

fn a_day() -> Weather {
    let hours: Vec<_> = (6..19).map(|hour| (9, 21, f64::from(hour) + 0.5, [60_000.0, 15_000.0])).collect();
    weather(&hours)
}

/// Stated errors agree with the scatter of the seeds: 48 seeds, one point, 64 walks per replica. The ratio of the scatter's variance to the
/// stated variance, averaged over thirteen hours, is between 0.56 and 1.6 (α some 1e-3 by χ² with 47 degrees of freedom for one hour; hours
/// are correlated). With errors half as large, the planted fault, it is not.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn stated_errors_are_what_seeds_scatter_by() {
    const SEEDS: u64 = 48;
    let receivers = json!([grid("plane", [1.0, 2.5, 0.85], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], 2, 2)]);
    let scene = scene(room("paint", false), vec![sky()], receivers);
    let given = a_day();
    let runs: Vec<Vec<Estimate>> =
        (0..SEEDS).map(|seed| year(&scene, &given, &settings(1, seed, 0.9)).1.swap_remove(0)).collect();
    let hours = runs[0].len();
    let ratio = (0..hours).map(|hour| {
        let mean = runs.iter().map(|run| run[hour].value).sum::<f64>() / SEEDS as f64;
        let scatter = runs.iter().map(|run| (run[hour].value - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        let stated = runs.iter().map(|run| run[hour].standard_error.powi(2)).sum::<f64>() / SEEDS as f64;
        scatter / stated
    });
    let ratio = ratio.sum::<f64>() / hours as f64;
    assert!((0.56..1.6).contains(&ratio), "{ratio}");
    assert!(!(0.56..1.6).contains(&(4.0 * ratio)), "the planted fault passed");
}

/// The numbers are the same for any number of threads. Closed blinds transmit a share and no direct sun. Hours with sun on the plane close
/// them, others do not.
#[test]
fn blinds_close_by_the_sun_and_threads_change_nothing() {
    let scene = scene(room("paint", false), vec![sky()], work_plane());
    let given = a_day();
    let with = |blinds, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| year(&scene, &given, &YearSettings { blinds, ..settings(1, 2, 0.05) }))
    };
    let (open, open_hours) = with(None, 1);
    let (_, again) = with(None, 3);
    assert_eq!(open_hours, again);
    let (shut, shut_hours) = with(Some(Blinds { transmittance: 0.2 }), 2);
    let closed = &shut.sets[0].closed;
    assert!(closed.iter().any(|closed| *closed) && closed.iter().any(|closed| !closed), "{closed:?}");
    for (hour, is_closed) in closed.iter().enumerate() {
        // The sun reaches the plane through a south window only when it is in the south and above the horizon.
        let towards = shut.sky.hours[hour].towards_sun;
        assert!(!is_closed || towards.y < 0.0 && towards.z > 0.0);
        for (one, other) in open_hours.iter().zip(&shut_hours) {
            let shares = other[hour].value / one[hour].value;
            assert!(if *is_closed { shares < 0.25 } else { (shares - 1.0).abs() < 0.3 }, "{shares}");
        }
    }
    assert!(
        shut.sets[0].averages[YearMeasure::Exposure as usize].value
            < open.sets[0].averages[YearMeasure::Exposure as usize].value
    );
}

/// A scene without a sky has no year and is refused with a message.
#[test]
fn scenes_without_a_sky_are_refused() {
    let lamp = json!({ "name": "lamp", "type": "point", "position": [2, 2, 2], "intensity_cd": 100 });
    let dark = scene(room("paint", false), vec![lamp], work_plane());
    let refused = solve_year(dark, &a_day(), &settings(1, 0, 0.03), |_, _| Ok::<(), NotForYear>(()));
    let told = refused.expect_err("no sky").to_string();
    assert!(told.contains("no sky") && told.contains("remedy"), "{told}");
}

/// The sample weather is what its generator writes: a year of hours.
#[test]
fn the_sample_weather_is_a_year() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weather/synthetic-52N.csv");
    let weather = luxmc::scene::read_weather(&path).expect("weather");
    assert_eq!((weather.hours.len(), weather.latitude_deg), (8760, 52.0));
    let scene = common::scene("daylight-office.json");
    assert!(scene.luminaires.iter().any(|luminaire| matches!(luminaire.emission, Emission::Sky { .. })));
    let sky = YearSky::of(&weather, 1, 0.2, 1.0, |hour| (8.0..18.0).contains(&hour));
    assert_eq!((sky.occupied, sky.all), (3650, 8760));
    // The patches give an open plane the illuminance of the weather, without the ground.
    for hour in (0..sky.hours.len()).step_by(97) {
        let luminances = sky.luminances_cd_m2(hour);
        let up: f64 = (0..sky.patches.count()).map(|patch| luminances[patch] * sky.patches.horizontal_sr(patch)).sum();
        assert!((up / sky.hours[hour].outside_lx[0] - 1.0).abs() < 1e-9);
        let ground = luminances[sky.patches.count()];
        let outside: f64 = sky.hours[hour].outside_lx.iter().sum();
        assert!((ground - 0.2 * outside / PI).abs() < 1e-9 * ground);
    }
}

/// On 21 March at 52° N, 13° E a point that faces east sees the sun until it crosses the meridian. By the equation of time of that day
/// (−7.3 min) this is at 12:15.3 of its standard time. A point that faces south, with an endless wall to its east, sees the sun from then
/// on (the wall leaves 0.06° free). A pane changes nothing, and behind a board there is hardly any sun. The times are within 1.5 min; a
/// longitude that is 1° off, the planted fault, is 4 min off. In polar night there is no sunlight.
#[test]
fn sunlight_begins_and_ends_where_walls_let_it() {
    const NOON: f64 = 12.0 + 15.3 / 60.0;
    let parts = vec![
        rectangle("wall", [1.0, 0.0, -1.0], [0.0, -100.0, 0.0], [0.0, 0.0, 900.0], "black"),
        rectangle("pane", [20.0, -0.5, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 90.0], "pane"),
        rectangle("board", [30.0, -0.01, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 9.0], "black"),
    ];
    let parts = parts.into_iter().map(|mut part| {
        part["two_sided"] = json!(true);
        part
    });
    let point = |name: &str, x: f64, u: [f64; 3]| grid(name, [x, 0.0, 0.0], u, [0.0, 0.0, 0.1], 2, 2);
    let receivers = json!([
        point("east", 5.0, [0.0, 0.1, 0.0]),
        point("south", 0.9, [0.01, 0.0, 0.0]),
        point("pane", 21.0, [0.01, 0.0, 0.0]),
        point("board", 31.0, [0.01, 0.0, 0.0]),
    ]);
    let lamp = json!({ "name": "lamp", "type": "point", "position": [50, 50, 2], "intensity_cd": 100 });
    let scene = scene(parts.collect(), vec![lamp], receivers);
    let found = |longitude_deg: f64, latitude_deg: f64| {
        let site = SunSite { latitude_deg, longitude_deg, time_zone_hours: 1.0, least_elevation_deg: 0.0 };
        sunlight(&scene, &site, &[(3, 21), (12, 21)])
    };
    let sets = found(SITE[1], SITE[0]);
    let at = |sets: &[SetSunlight], set: usize, day: usize| sets[set].points[0][day].clone();
    let close = |hour: f64| (hour - NOON).abs() < 1.5 / 60.0;
    let east = at(&sets, 0, 0);
    assert!(east.len() == 1 && close(east[0][1]) && (6.0..6.4).contains(&east[0][0]), "{east:?}");
    let south = at(&sets, 1, 0);
    assert!(south.len() == 1 && close(south[0][0]), "{south:?}");
    let pane = at(&sets, 2, 0);
    assert!(pane.len() == 1 && (6.0..6.4).contains(&pane[0][0]) && sum_of_hours(&pane) > 5.0, "{pane:?}");
    assert!(
        at(&sets, 3, 0).is_empty() || at(&sets, 3, 0).iter().all(|[from, to]| to - from < 0.2),
        "{:?}",
        at(&sets, 3, 0)
    );
    assert!(!close(at(&found(SITE[1] + 1.0, SITE[0]), 0, 0)[0][1]), "the planted fault passed");
    assert!(at(&found(SITE[1], 80.0), 0, 1).is_empty());
}
