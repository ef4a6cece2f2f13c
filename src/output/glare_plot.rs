//! Glare in plan: the contribution of every luminaire for an observer, and the ratings of the observers of a grid.

use super::axes::TYPE;
use super::color::{AMBER, BLACK, GREY, Ink, perceptual};
use super::font::text_width;
use super::numbers::whole_percent;
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};
use super::plan::{Labels, Plan, middle_m};
use super::texts::say;
use crate::scene::Scene;
use crate::solver::GlareRating;

/// Radius of a disk that represents all of an observer's glare.
const LARGEST_DISK: f64 = 40.0;
/// Gap between a disk and the number of its share.
const BESIDE: f64 = 2.5;
/// Half the height of a cross.
const CROSS: f64 = 3.5;
/// Largest number of luminaires that are labelled with their share of the glare, and the smallest share that is labelled.
const MOST_LABELLED: usize = 12;
const LEAST_LABELLED: f64 = 0.02;
/// Ratings at which the next class begins: limits of EN 12464-1.
const CLASSES: [f64; 4] = [16.0, 19.0, 22.0, 25.0];
/// Positions of the classes on the perceptual scale, the mildest first.
const CLASS_INKS: [f64; 5] = [0.97, 0.76, 0.52, 0.26, 0.0];
/// Largest and smallest length of the wedge that represents an observer, and its half width as a share of its length.
const LONGEST_WEDGE: f64 = 26.0;
const SHORTEST_WEDGE: f64 = 5.0;
const WEDGE: f64 = 0.24;
/// Largest length of a wedge as a share of the distance between eyes.
const WEDGE_SHARE: f64 = 0.46;
/// Height of the legend below a plan.
const LEGEND: f64 = 34.0;

/// Draws the scene from above with every luminaire's contribution to the glare of an observer. Disks show their share of the sum;
/// crosses mark visible luminaires that do not count.
pub(super) fn glare_picture(scene: &Scene, rating: &GlareRating) -> Picture {
    let set = &scene.receivers[rating.set];
    let observer = &set.observers[rating.observer];
    let (plan, mut picture) = Plan::begin(scene, say!("What every luminaire adds to the glare of {}", set.name));
    for (luminaire, _) in &rating.outside {
        let [x, y] = plan.spot(middle_m(scene, &scene.luminaires[*luminaire].emission));
        for (i, j) in [(CROSS, CROSS), (CROSS, -CROSS)] {
            picture.line(vec![[x - i, y - j], [x + i, y + j]], Pen::new(GREY, 1.4));
        }
    }
    for (place, (luminaire, sum)) in rating.contributions.iter().enumerate() {
        let share = sum / rating.glare_sum.value;
        let [x, y] = plan.spot(middle_m(scene, &scene.luminaires[*luminaire].emission));
        let radius = LARGEST_DISK * share.sqrt();
        picture.disk([x, y], radius, AMBER);
        picture.circle([x, y], radius, Pen::new(BLACK, 0.8));
        if place < MOST_LABELLED && share >= LEAST_LABELLED {
            let text = whole_percent(share);
            let away = radius + BESIDE;
            // The label stands beside the disk, on the left if the page ends at the right.
            let is_right = x + away + text_width(&text, TYPE, true) < picture.width;
            let (x, anchor) = if is_right { (x + away, TextAnchor::Start) } else { (x - away, TextAnchor::End) };
            picture.words(Words::new(text, [x, y + 4.0], TYPE).bold().anchored(anchor).rimmed(2.0));
        }
    }
    plan.draw_lines_of_sight(&mut picture, observer.eye_m, &[observer.view]);
    plan.label(&mut picture, &mut Labels::default(), &[plan.spot(observer.eye_m)], set.name.clone());
    picture
}

/// Draws the scene from above with the observers of a grid: a wedge for each along the line of sight, darker for worse ratings.
pub(super) fn glare_grid_picture(scene: &Scene, ratings: &[GlareRating]) -> Option<Picture> {
    let set = &scene.receivers[ratings.first()?.set];
    let (plan, mut picture) = Plan::begin(scene, say!("Glare ratings of {}", set.name));
    let seen = |rating: &GlareRating| &set.observers[rating.observer];
    let spots: Vec<PagePoint> = ratings.iter().map(|rating| plan.spot(seen(rating).eye_m)).collect();
    let length = wedge_length(&spots);
    for (rating, [x, y]) in ratings.iter().zip(&spots) {
        let view = seen(rating).view;
        // y points down on paper. An observer who looks straight up or down has no wedge.
        let (along, across) = ([length * view.x, -length * view.y], [WEDGE * length * view.y, WEDGE * length * view.x]);
        let end = |side: f64| [x + along[0] + side * across[0], y + along[1] + side * across[1]];
        picture.area(vec![[*x, *y], end(1.0), end(-1.0)], class_ink(rating), 1.0);
    }
    let bottom = picture.height + 14.0;
    picture.height += LEGEND;
    let mut left = 58.0;
    for (class, place) in CLASS_INKS.iter().enumerate() {
        let name = match class {
            0 => format!("UGR < {}", CLASSES[0]),
            4 => say!("{} or more", CLASSES[3]),
            _ => say!("{} to {}", CLASSES[class - 1], CLASSES[class]),
        };
        let square = vec![
            [left, bottom - 10.0],
            [left + 12.0, bottom - 10.0],
            [left + 12.0, bottom + 2.0],
            [left, bottom + 2.0],
        ];
        picture.area(square, perceptual(*place), 1.0);
        let width = 34.0 + 6.8 * name.len() as f64;
        picture.words(Words::new(name, [left + 18.0, bottom], TYPE));
        left += width;
    }
    Some(picture)
}

/// Length of the wedges: as long as the distance between eyes permits.
fn wedge_length(spots: &[PagePoint]) -> f64 {
    let mut eyes = spots.to_vec();
    eyes.dedup();
    let nearest = eyes
        .windows(2)
        .map(|pair| super::contour::distance(pair[0], pair[1]))
        .filter(|distance| *distance > 0.0)
        .fold(f64::INFINITY, f64::min);
    (WEDGE_SHARE * nearest).clamp(SHORTEST_WEDGE, LONGEST_WEDGE)
}

fn class_ink(rating: &GlareRating) -> Ink {
    let class = rating.ugr.map_or(0, |ugr| CLASSES.iter().filter(|limit| ugr.value >= **limit).count());
    perceptual(CLASS_INKS[class])
}
