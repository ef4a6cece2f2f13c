use luxmc::scene::*;
use luxmc::solver::*;
struct Silent(std::time::Instant);
impl Observer for Silent {
    fn progress(&self, _: &Progress) {}
    fn is_interrupted(&self) -> bool {
        false
    }
    fn wall_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let t = std::time::Instant::now();
    let scene = read_scene(std::path::Path::new(&args[1])).unwrap_or_else(|e| panic!("{e}"));
    println!(
        "read {:?} triangles {} cells {} warnings {:?}",
        t.elapsed(),
        scene.triangles.len(),
        Elements::of(&scene).len(),
        scene.warnings
    );
    let maps = match args[2].as_str() {
        "default" => MapSelection::Default,
        "all" => MapSelection::All,
        "elements" => MapSelection::Elements,
        _ => MapSelection::Receivers,
    };
    let target: Option<f64> = args[3].parse().ok();
    let chains: Option<u64> = args.get(4).and_then(|c| c.parse().ok());
    let s = solve(
        &scene,
        &Settings { seed: 0, target_error: target, chains, time_limit_s: None, maps, threads: None },
        &Silent(t),
    );
    println!(
        "chains {} rays {} build {:.3} compute {:.3} Mrays/s {:.2} err {} met {:?} {:?}",
        s.chains,
        s.rays,
        s.build_s,
        s.compute_s,
        s.rays as f64 / s.compute_s / 1e6,
        s.estimated_error,
        s.target_met,
        s.stop_reason
    );
    println!("{:?} {:?}", s.flux_balance, s.map_check);
    for m in &s.maps {
        println!("{} {} chains {} err {:?} ", m.name, m.method, m.chains, m.error);
        for r in &m.tables {
            println!(
                "   {:20} {} avg {:.3}±{:.3} min {:.2}±{:.2} max {:.2} u0 {:.4}±{:.4} ud {:.3} A {:.2} err {:.4}",
                r.name,
                r.side,
                r.average_lx.value,
                r.average_lx.standard_error,
                r.minimum_lx.value,
                r.minimum_lx.standard_error,
                r.maximum_lx,
                r.uniformity_u0.value,
                r.uniformity_u0.standard_error,
                r.uniformity_ud,
                r.area_m2,
                r.estimated_error
            );
        }
    }
    for c in &s.convergence {
        println!(
            "   {:.3}s {} chains err {:.5} forecast {:.3}s {:.0}",
            c.wall_s, c.chains, c.estimated_error, c.forecast_wall_s, c.forecast_chains
        );
    }
}
