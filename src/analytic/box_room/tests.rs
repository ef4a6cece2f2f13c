use std::f64::consts::PI;

use super::*;

fn lit_cube(reflectance: f64) -> BoxRoom {
    let source = RoomSource::Point { position: DVec3::splat(2.0), intensity_cd: 10_000.0 / (4.0 * PI) };
    BoxRoom { size_m: [4.0; 3], reflectances: [reflectance; 6], sources: vec![source] }
}

/// 6 m × 4 m × 3 m, floor 0.2, ceiling 0.7, walls with different reflectances, a point source off the centre and a panel on the
/// ceiling.
fn uneven_room() -> BoxRoom {
    let point = RoomSource::Point { position: DVec3::new(1.7, 2.9, 1.9), intensity_cd: 300.0 };
    let panel =
        RoomSource::Panel { face: RoomFace::Ceiling, low: [4.0, 1.0], high: [5.2, 1.6], exitance_lm_m2: 4000.0 };
    BoxRoom { size_m: [6.0, 4.0, 3.0], reflectances: [0.5, 0.4, 0.6, 0.0, 0.2, 0.7], sources: vec![point, panel] }
}

fn area_m2(room: &BoxRoom, face: RoomFace) -> f64 {
    face.other_axes().iter().map(|axis| room.size_m[*axis]).product()
}

#[test]
fn the_cube_of_cie_171_case_5_8_is_met() {
    for (reflectance, average) in [(0.05, 5.4825), (0.5, 104.1667), (0.95, 1979.1667)] {
        let solution = lit_cube(reflectance).solve().expect("a valid room");
        for face in RoomFace::ALL {
            let mean = solution.face_mean(face);
            assert!((mean.indirect_lx - average).abs() < 1e-4, "{mean:?}");
            assert!((mean.direct_lx * 96.0 / 10_000.0 - 1.0).abs() < 1e-12);
        }
        let centre = solution.on_face(RoomFace::Ceiling, 2.0, 2.0).expect("on the face");
        assert!(centre.estimated_error_lx < 1e-4 * centre.indirect_lx, "{centre:?}");
        if reflectance == 0.5 {
            assert!((centre.indirect_lx - 112.038).abs() < 1e-3, "{centre:?}");
        }
        let corner = solution.on_face(RoomFace::XLow, 0.0, 0.0).expect("on the face");
        assert!(corner.indirect_lx < average && centre.indirect_lx > average);
    }
}

#[test]
fn the_flux_balances_with_unequal_faces() {
    let room = uneven_room();
    let solution = room.solve().expect("a valid room");
    let absorbed: f64 = RoomFace::ALL
        .iter()
        .map(|face| {
            let mean = solution.face_mean(*face);
            assert!(mean.estimated_error_lx < 1e-4 * mean.indirect_lx, "{face:?} {mean:?}");
            (1.0 - room.reflectances[face.index()]) * mean.total_lx() * area_m2(&room, *face)
        })
        .sum();
    let emitted: f64 = room.sources.iter().map(|s| s.luminous_flux_lm()).sum();
    assert!((absorbed / emitted - 1.0).abs() < 1e-9, "{absorbed} {emitted}");
}

#[test]
fn an_isothermal_room_is_even_everywhere() {
    // With exitances (1 − ρ)πL₀ the illuminance is πL₀ at every point, including edges and corners.
    let reflectances = [0.1, 0.95, 0.3, 0.0, 0.7, 1.0];
    let size_m = [6.0, 4.0, 3.0];
    let panel = |face: RoomFace| RoomSource::Panel {
        face,
        low: [0.0, 0.0],
        high: face.other_axes().map(|axis| size_m[axis]),
        exitance_lm_m2: (1.0 - reflectances[face.index()]) * PI,
    };
    let room = BoxRoom { size_m, reflectances, sources: RoomFace::ALL.map(panel).to_vec() };
    let solution = room.solve().expect("a valid room");
    for face in RoomFace::ALL {
        let lengths = face.other_axes().map(|axis| size_m[axis]);
        for place in [[0.5, 0.5], [0.01, 0.3], [0.99, 0.999], [1e-6, 1e-6]] {
            let value = solution.on_face(face, lengths[0] * place[0], lengths[1] * place[1]).expect("on the face");
            assert!((value.total_lx() / PI - 1.0).abs() < 1e-9, "{face:?} {place:?} {value:?}");
        }
    }
}

#[test]
fn triangles_make_up_their_face() {
    let room = uneven_room();
    let solution = room.solve().expect("a valid room");
    let (mut sum, mut stated) = (RoomValue::default(), 0.0f64);
    let n = 4;
    for i in 0..n {
        for j in 0..n {
            let corner = |i: usize, j: usize| DVec3::new(6.0 * i as f64 / n as f64, 4.0 * j as f64 / n as f64, 0.0);
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            for triangle in [[a, b, c], [a, d, c]] {
                let mean = solution.triangle_mean(triangle).expect("on the floor");
                sum.direct_lx += mean.direct_lx / (2 * n * n) as f64;
                sum.indirect_lx += mean.indirect_lx / (2 * n * n) as f64;
                stated = stated.max(mean.estimated_error_lx / mean.indirect_lx);
            }
        }
    }
    let mean = solution.face_mean(RoomFace::Floor);
    assert!((sum.direct_lx / mean.direct_lx - 1.0).abs() < 1e-6, "{sum:?} {mean:?}");
    assert!((sum.indirect_lx / mean.indirect_lx - 1.0).abs() < 1e-4, "{sum:?} {mean:?}");
    let half = solution.rectangle_mean(RoomFace::Floor, [0.0, 0.0], [6.0, 4.0]).expect("on the floor");
    assert!((half.indirect_lx / mean.indirect_lx - 1.0).abs() < 1e-3);
}

#[test]
fn what_has_no_answer_is_refused() {
    let room = lit_cube(0.5);
    assert!(BoxRoom { reflectances: [1.0; 6], ..room.clone() }.solve().is_err());
    assert!(BoxRoom { reflectances: [1.1; 6], ..room.clone() }.solve().is_err());
    assert!(BoxRoom { size_m: [0.0, 1.0, 1.0], ..room.clone() }.solve().is_err());
    let outside = RoomSource::Point { position: DVec3::splat(5.0), intensity_cd: 1.0 };
    assert!(BoxRoom { sources: vec![outside], ..room.clone() }.solve().is_err());
    let solution = BoxRoom { reflectances: [0.0; 6], ..room }.solve().expect("a black room");
    assert_eq!(solution.face_mean(RoomFace::Floor).indirect_lx, 0.0);
    assert!(solution.on_face(RoomFace::Floor, 4.1, 0.0).is_err());
    assert!(solution.triangle_mean([DVec3::ZERO, DVec3::X, DVec3::ONE]).is_err());
    assert!(solution.triangle_mean([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]).is_err());
}
