use expoly::{models::*, *};
fn main() {
    let duff = Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap();
    let mut rows: Vec<[f64; 5]> = vec![];
    let mut rd = csv::Reader::from_path("tests/reference/vibro_impact_displacement_pdf.csv").unwrap();
    for r in rd.records() {
        let r = r.unwrap();
        let f = |i: usize| r[i].parse::<f64>().unwrap();
        rows.push([f(3), f(4), f(6), f(7), f(8)]);
    }
    let mut keys: Vec<(f64, f64)> = vec![];
    for r in &rows {
        if !keys.contains(&(r[0], r[1])) {
            keys.push((r[0], r[1]));
        }
    }
    for (b, r) in keys {
        for basis in [Basis::Classical, Basis::Folded] {
            for n in [2, 4, 6] {
                let s = Closure::classical(n)
                    .with_basis(basis)
                    .solve_with_wall(&duff, Barrier::new(b, r).unwrap())
                    .unwrap();
                // truncated l1: integrate over v in [-6,6]
                let q = s.polynomial();
                let pts: Vec<_> = rows.iter().filter(|z| z[0] == b && z[1] == r).collect();
                let m: Vec<f64> = pts
                    .iter()
                    .map(|z| {
                        let k = 400;
                        (0..k)
                            .map(|i| {
                                let v = -4.5 + 9.0 * (i as f64 + 0.5) / k as f64;
                                q.evaluate(&[z[2], v]).exp()
                            })
                            .sum::<f64>()
                    })
                    .collect();
                let z: f64 = m.iter().zip(&pts).map(|(m, p)| m * p[3]).sum();
                let l1: f64 = m.iter().zip(&pts).map(|(m, p)| p[3] * (m / z - p[4]).abs()).sum();
                let real = s
                    .density()
                    .map(|d| pts.iter().map(|p| p[3] * (d.marginal(0, p[2]).unwrap().value - p[4]).abs()).sum::<f64>());
                println!("{b} {r} {basis} {n} {} {:?} trunc {l1:.2e} real {:?}", s.termination(), s.route(), real.ok());
            }
        }
    }
}
