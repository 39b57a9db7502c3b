use engine::transport::solve::*;
use std::time::Instant;
use tests::systems::*;

fn inf(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

#[test]
fn table() {
    for (name, g) in [("box", &*BOX), ("corridor", &*CORRIDOR)] {
        let n = g.patches.len();
        let m = g.patches.iter().map(|p| p.aggregate + 1).max().unwrap();
        println!("{name}: {n} patches, {} entries, {m} aggregates", g.rows.entries());
        let mut sizes = vec![0; m as usize];
        let mut x0 = vec![(f32::MAX, f32::MIN); m as usize];
        for p in &g.patches {
            let a = p.aggregate as usize;
            sizes[a] += 1;
            x0[a].0 = x0[a].0.min(p.centre.x);
            x0[a].1 = x0[a].1.max(p.centre.x);
        }
        println!("{sizes:?} {x0:?}");
        for (what, rho) in
            [("mono", 0.5), ("mono", 0.7), ("mono", 0.9), ("mono", 0.99), ("mono", 0.9999), ("mixed", 0.99)]
        {
            let c = g.channel(|p| {
                if what == "mixed" { [0.99, 0.2, 0.8, 0.99, 0.5, 0.0][p.batch as usize] } else { rho }
            });
            let mut e = vec![0.0; n];
            e[n / 3] = 1.0;
            let truth =
                solve(Method::DeflatedConjugateGradients, &c, &e, None, &Stop::at(1e-12, 500.0), &mut |_| {});
            println!(
                "{what} {rho}: gain {:.2} truth bound {:.1e} {} products",
                c.largest_gain, truth.bracket.bound, truth.products
            );
            let scale = inf(&truth.b);
            for method in Method::all() {
                let (mut a, mut b) = (None, None);
                let mut last = 0.0;
                let start = Instant::now();
                let mut begun = None;
                let s = solve(method, &c, &e, None, &Stop::at(1e-7, 3000.0), &mut |it| {
                    begun.get_or_insert_with(Instant::now);
                    let err =
                        it.b.iter().zip(&truth.b).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs())) / scale;
                    if err < 1e-3 {
                        a.get_or_insert(it.products);
                    }
                    if err < 1e-6 {
                        b.get_or_insert(it.products);
                    }
                    last = err;
                });
                let total = start.elapsed().as_secs_f64();
                let t = begun.unwrap().elapsed().as_secs_f64();
                println!(
                    "   {:30} {:?} {:?} end {last:.1e} {} reached {} setup {:.2} ms, {:.3} ms/product",
                    method.name(),
                    a,
                    b,
                    s.products,
                    s.reached,
                    (total - t) * 1e3,
                    t * 1e3 / s.products
                );
            }
        }
    }
}
