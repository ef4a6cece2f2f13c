use std::f64::consts::PI;

use super::*;

fn cube(reflectance: f64) -> BoxRoom {
    let source = RoomSource::Point { position: DVec3::splat(2.0), intensity_cd: 10_000.0 / (4.0 * PI) };
    BoxRoom { size_m: [4.0; 3], reflectances: [reflectance; 6], sources: vec![source] }
}

#[test]
fn the_cube_of_cie_171_case_5_8_is_met() {
    for (reflectance, average) in [(0.05, 5.4825), (0.5, 104.1667), (0.95, 1979.1667)] {
        let start = std::time::Instant::now();
        let solution = cube(reflectance).solve().expect("a valid room");
        println!("solve {:?}", start.elapsed());
        for face in RoomFace::ALL {
            let mean = solution.face_mean(face);
            assert!((mean.indirect_lx - average).abs() < 1e-4, "{mean:?}");
            assert!((mean.direct_lx * 96.0 / 10_000.0 - 1.0).abs() < 1e-12);
        }
        let centre = solution.on_face(RoomFace::Ceiling, 2.0, 2.0).expect("on the face");
        let start = std::time::Instant::now();
        let corner = solution.on_face(RoomFace::XLow, 0.0, 0.0).expect("on the face");
        println!("{centre:?} {corner:?} {:?}", start.elapsed());
        for mesh in &solution.meshes {
            println!("{}", mesh.indirect_at_lx(RoomFace::Floor, [2.0, 2.0]));
        }
        for mesh in &solution.meshes {
            println!("corner {}", mesh.indirect_at_lx(RoomFace::Floor, [0.0, 0.0]));
        }
        for mesh in &solution.meshes {
            println!("near edge {}", mesh.indirect_at_lx(RoomFace::Floor, [0.03, 1.0]));
        }
        if reflectance == 0.5 {
            assert!((centre.indirect_lx - 112.038).abs() < 6e-4, "{centre:?}");
        }
        assert!(corner.indirect_lx < average && centre.indirect_lx > average);
    }
}
