//! A system of six states as a user defines it: three masses in a row between two walls, with hardening springs and noise on
//! the first and the last.

#![allow(clippy::print_stdout, reason = "a program prints its answer")]

use expoly::{Closure, Density, Drift, Intensity, Problem, Scalar, Simulation};

struct Row {
    damping: f64,
    cubic: f64,
    intensity: Intensity,
}

impl Drift<6, 2> for Row {
    fn drift<S: Scalar>(&self, [x, y, z, u, v, w]: [S; 6]) -> [S; 6] {
        let spring = |stretch: S| stretch + stretch.powi(3) * self.cubic;
        let forces = [spring(x), spring(y - x), spring(z - y), spring(-z)];
        let mass = |k: usize, velocity: S| forces[k + 1] - forces[k] - velocity * self.damping;
        [u, v, w, mass(0, u), mass(1, v), mass(2, w)]
    }
    fn noise<S: Scalar>(&self, _: [S; 6]) -> [[S; 2]; 6] {
        let sigma = self.intensity.amplitude();
        let mut noise = [[S::from(0.0); 2]; 6];
        (noise[3][0], noise[5][1]) = (S::from(sigma), S::from(sigma));
        noise
    }
}

fn main() -> expoly::Result<()> {
    let problem = Problem::of(Row { damping: 0.3, cubic: 0.4, intensity: Intensity::new(0.2)? })?;
    let simulated = Simulation::new().samples(100_000).seed(1).run(&problem)?;
    let density = Closure::new(4).solve(&problem)?;
    for powers in [[2, 0, 0, 0, 0, 0], [0, 2, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]] {
        println!("{:.4} {:.4}", density.moment(&powers)?, simulated.moment(&powers)?);
    }
    println!("estimated L1 error {:.4}", density.l1_estimate());
    Ok(())
}
