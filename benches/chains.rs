//! Chains per second on the cube and the office on one thread, and walks per second from the office's work plane.
//!
//! `cargo bench --bench chains`

use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use luxmc::check::read_scene;
use luxmc::estimators::receiver::Receiver;
use luxmc::estimators::walk::sample_indirect_lx;
use luxmc::sampling::emitter_tree::Cut;
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::scene::Scene;
use luxmc::transport::World;

/// Chains or walks that one iteration traces.
const BATCH: u64 = 1000;

fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    read_scene(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn chains(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("chains");
    group.throughput(Throughput::Elements(BATCH)).sample_size(20);
    for name in ["cube.json", "office.json"] {
        let world = World::new(&scene(name));
        let mut stream = Stream::new(1, Purpose::Chains, 0, 0);
        let mut first = 0;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let mut arrivals = 0u64;
                for chain in first..first + BATCH {
                    stream.seek(chain);
                    let choice = stream.fine_unit();
                    world.trace_chain(choice, &mut stream, |_| arrivals += 1);
                }
                first += BATCH;
                arrivals
            });
        });
    }
    group.finish();
}

fn walks(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("walks");
    group.throughput(Throughput::Elements(BATCH)).sample_size(20);
    let scene = scene("office.json");
    let world = World::new(&scene);
    let points = &scene.receivers[0].points;
    let mut stream = Stream::new(1, Purpose::Walks, 1, 0);
    let mut cut = Cut::default();
    let mut first = 0;
    group.bench_function("office.json", |bencher| {
        bencher.iter(|| {
            let mut sum_lx = 0.0;
            for walk in first..first + BATCH {
                let point = &points[walk as usize % points.len()];
                let origin = world.tracer.side_origin(point.position_m, point.normal);
                let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
                stream.seek(walk);
                sum_lx += sample_indirect_lx(&world, &receiver, &mut cut, &mut stream).value;
            }
            first += BATCH;
            sum_lx
        });
    });
    group.finish();
}

criterion_group!(benches, chains, walks);
criterion_main!(benches);
