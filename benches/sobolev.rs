//! A thousand radii of Sobolev's problem at once: some 30 ms on an idle core.
//!
//! `cargo bench --bench sobolev`

use criterion::{Criterion, criterion_group, criterion_main};
use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev_at_radii};

fn radii(criterion: &mut Criterion) {
    let problem = SobolevProblem { h1: 0.4, rho1: 0.9999, rho2: 0.9999 };
    let mut group = criterion.benchmark_group("sobolev");
    group.sample_size(10);
    for (name, low, high) in [("near", 0.0, 4.0), ("far", 25.0, 1e4), ("all", 0.0, 1e4)] {
        let radii: Vec<f64> = (0..1000).map(|i| low + (high - low) * f64::from(i) / 1000.0).collect();
        group.bench_function(name, |bencher| bencher.iter(|| sobolev_at_radii(&problem, SobolevPlane::One, &radii)));
    }
    group.finish();
}

criterion_group!(benches, radii);
criterion_main!(benches);
