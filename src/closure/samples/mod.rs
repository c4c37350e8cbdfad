//! The closure on the pilot's own states, in any number of dimensions.
//!
//! Where the residual r of the true density is tested, it vanishes; and where it vanishes, an average over random states
//! has no noise. So the pilot's states serve as nodes for E[r ψ_k] = 0, and a further dimension costs no more than the
//! functions that it brings.

mod assembly;
mod basis;
mod copula;
mod importance;
mod iteration;
mod products;
mod score_matching;
mod sites;

pub(crate) use copula::Copula;
pub(crate) use importance::ImportanceRule;

use super::degrees::Degrees;
use super::exponent::Exponent;
use super::pilot::Pilot;
use super::space::{Functions, Polynomials};
use crate::problem::{Problem, Symmetry};
use assembly::Assembly;
use basis::Basis;
use iteration::{Iteration, dissipative};
use products::Products;
use score_matching::Score;
use sites::Sites;

/// The equations are solved in a space two degrees higher, of at most so many functions.
const MOST_FUNCTIONS: usize = 700;
/// States that each function needs there.
const STATES_EACH: usize = 60;
/// The order of the start: higher ones follow the states' noise.
const START_ORDER: u32 = 4;

/// ln p up to a constant, as found on samples.
#[derive(Clone, Debug)]
pub(in crate::closure) struct SampleClosure {
    /// Q; its constant is zero.
    pub(in crate::closure) exponent: Exponent,
    /// The functions of Q.
    pub(in crate::closure) polynomials: Polynomials,
    /// ‖F‖ in orthonormal functions, in the space in which the equations were solved.
    pub(in crate::closure) residual: f64,
    /// The root mean square of the residual at the states, in that space.
    pub(in crate::closure) pointwise: f64,
    /// Whether the equations have been solved. Where not, this is where the iteration got stuck.
    pub(in crate::closure) solved: bool,
    /// How much ln p was changed, in the mean square, by leaving out the terms of higher degree; none without any.
    pub(in crate::closure) indicator: Option<f64>,
    /// Half the mean square by which ∇Q, in units of the standard deviations, differs from its fit to the pilot's states:
    /// large for a spurious root.
    pub(in crate::closure) excess: f64,
    /// Whether that is more than chance explains.
    pub(in crate::closure) suspect: bool,
    /// The steps of the iteration, those of a lower order and of a start that led nowhere included.
    pub(in crate::closure) steps: usize,
}

/// Closes at one order on the pilot's states. None where the functions are linearly dependent at them: too few states.
///
/// The equations are solved two degrees higher where that is affordable, and the solution is cut back to the order,
/// orthogonally in L²: Q is then the best of its order in the mean square of ln p. Solved at the order itself, Q would
/// take up what the missing terms do, and the larger residual would let in more of the states' noise.
///
/// `near` is a similar system's Q, from which the iteration may start.
pub(in crate::closure) fn close_on_samples(
    problem: &Problem,
    pilot: &Pilot,
    degrees: &Degrees,
    order: u32,
    symmetry: &Symmetry,
    near: Option<&Exponent>,
) -> Option<SampleClosure> {
    let exponents = |order| degrees.exponents(problem.dimension(), order, |alpha| symmetry.keeps(alpha));
    let (kept, higher) = (exponents(order), exponents(order + 2));
    let sites = Sites::new(problem, &pilot.states);
    let affordable = higher.len() <= MOST_FUNCTIONS.min(sites.len() / STATES_EACH);
    let larger = affordable.then(|| close_within(&sites, pilot, symmetry, [&kept, &higher], near)).flatten();
    match larger {
        Some(closure) if closure.solved && !closure.suspect => Some(closure),
        larger => {
            let plain = close_within(&sites, pilot, symmetry, [&kept, &kept], near);
            let found = larger.into_iter().chain(plain);
            found.min_by(|a, b| b.solved.cmp(&a.solved).then(a.excess.total_cmp(&b.excess)))
        }
    }
}

/// Solves with the functions `used` and cuts back to the functions `kept`, which come first among them.
fn close_within(
    sites: &Sites,
    pilot: &Pilot,
    symmetry: &Symmetry,
    [kept, used]: [&[Vec<u32>]; 2],
    near: Option<&Exponent>,
) -> Option<SampleClosure> {
    let (centre, deviation) = pilot.spread(symmetry);
    let half_width = reach(pilot, &centre);
    let functions = |exponents: &[Vec<u32>]| Polynomials::new(centre.clone(), half_width.clone(), exponents.to_vec());
    let products = Products::new(&functions(used));
    let assembly = Assembly { products: &products, sites };
    let basis = Basis::new(&assembly.gram())?;
    let score = Score::new(&assembly, &basis, &deviation, kept.len(), pilot.inflation)?;
    let matrix = dissipative(&assembly);
    let solved = |start| Iteration { assembly, basis: &basis }.run(start, &matrix);
    // What is nearest to a similar system's Q in the mean square over the states.
    let projected = |near: &Exponent| {
        let tested = basis.tested(&assembly.means(|x| near.value(x)));
        basis.coefficients(&(0..tested.nrows()).map(|k| tested[(k, 0)]).collect::<Vec<_>>())
    };
    let mut steps = 0;
    let warm = near.map(|near| solved(projected(near))).filter(|ended| {
        steps += ended.steps;
        ended.solved && !score.suspects(score.excess(&basis.orthogonal(&ended.a)[..kept.len()]))
    });
    let ended = match warm {
        Some(ended) => ended,
        None => {
            let low = used.iter().filter(|alpha| alpha.iter().sum::<u32>() <= START_ORDER).count();
            // The solution of a low order is nearer than any fit to the states.
            let lower = (low < used.len()).then(|| close_within(sites, pilot, symmetry, [&used[..low]; 2], None));
            let start = match lower.flatten().filter(|closure| closure.solved) {
                Some(closure) => {
                    steps += closure.steps;
                    let coefficients = std::iter::once(0.0).chain(closure.exponent.coefficients);
                    coefficients.chain(std::iter::repeat(0.0)).take(used.len() + 1).collect()
                }
                None => basis.coefficients(&score.start(low.min(kept.len()))?),
            };
            let ended = solved(start);
            steps += ended.steps;
            ended
        }
    };
    let d = basis.orthogonal(&ended.a);
    let (inside, beyond) = d.split_at(kept.len());
    let excess = score.excess(inside);
    let coefficients = basis.coefficients(inside)[1..=kept.len()].to_vec();
    let polynomials = functions(kept);
    let space = Functions::Polynomials(polynomials.clone());
    Some(SampleClosure {
        exponent: Exponent { known: Vec::new(), space, constant: 0.0, coefficients },
        polynomials,
        residual: ended.residual,
        excess,
        suspect: score.suspects(excess),
        pointwise: ended.pointwise,
        solved: ended.solved,
        indicator: (!beyond.is_empty()).then(|| beyond.iter().map(|d| d * d).sum::<f64>().sqrt()),
        steps,
    })
}

/// The farthest that a state has been from the centre.
fn reach(pilot: &Pilot, centre: &[f64]) -> Vec<f64> {
    let farthest = |i: usize| pilot.states.iter().map(|x| (x[i] - centre[i]).abs()).fold(0.0, f64::max);
    (0..centre.len()).map(farthest).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::closure::pilot::Scout;
    use crate::models::{DuffingChain, Solved};

    fn chain(damping: [f64; 2]) -> DuffingChain {
        DuffingChain::new(&damping, 1.0, 0.5, 0.5, 1.0).unwrap()
    }

    fn pilot(chain: &DuffingChain, count: usize) -> (Problem, Symmetry, Pilot) {
        let problem = chain.problem().unwrap();
        let pilot = Scout::new(&problem, 1).unwrap().pilot(count, 1.0).unwrap();
        let symmetry = problem.symmetry();
        (problem, symmetry, pilot)
    }

    /// Products of all degrees up to `order` that the symmetry keeps, on the cube of half width 3.
    fn products(order: u32, symmetry: &Symmetry) -> Products {
        let exponents = Degrees::complete().exponents(4, order, |alpha| symmetry.keeps(alpha));
        Products::new(&Polynomials::new(vec![0.0; 4], vec![3.0; 4], exponents))
    }

    /// F is quadratic in the coefficients, so that central differences are exact whatever their width.
    #[test]
    fn the_jacobian_is_the_derivative_of_the_residual() {
        let (problem, symmetry, pilot) = pilot(&chain([0.2, 0.4]), 2048);
        let products = products(4, &symmetry);
        let sites = Sites::new(&problem, &pilot.states);
        let assembly = Assembly { products: &products, sites: &sites };
        let a: Vec<f64> = (0..products.len()).map(|k| (0.7 * k as f64).sin()).collect();
        let step: Vec<f64> = (0..products.len()).map(|k| (1.3 * k as f64).cos()).collect();
        let moved = |sign: f64| -> Vec<f64> { a.iter().zip(&step).map(|(a, s)| a + sign * s).collect() };
        let (ahead, behind) = (assembly.residual(&moved(1.0)).0, assembly.residual(&moved(-1.0)).0);
        let jacobian = assembly.images(|site, scratch| assembly.linearised(&a, site, scratch));
        let scale = ahead.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for k in 0..products.len() {
            let along: f64 = (0..products.len()).map(|l| jacobian[(k, l)] * step[l]).sum();
            assert!((along - 0.5 * (ahead[k] - behind[k])).abs() < 1e-12 * scale);
        }
    }

    /// At the stationary density both matrices are the same but for chance, and A is dissipative with any states.
    #[test]
    fn the_first_matrix_is_the_jacobian_at_the_stationary_density() {
        let chain = chain([0.5, 0.8]);
        let (problem, symmetry, pilot) = pilot(&chain, 100_000);
        let products = products(2, &symmetry);
        let sites = Sites::new(&problem, &pilot.states);
        let assembly = Assembly { products: &products, sites: &sites };
        let basis = Basis::new(&assembly.gram()).unwrap();
        let first = basis.form(&dissipative(&assembly));
        let symmetric = &first + first.transpose();
        assert!((faer::Scale(-1.0) * symmetric).self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0] > -1e-10);

        let log_p = chain.log_polynomial().unwrap();
        let exact = assembly.images(|site, scratch| {
            scratch.first.copy_from_slice(&site.backward);
            for l in 0..products::LANES {
                let slope = log_p.gradient(&[0, 1, 2, 3].map(|i| site.x[i][l]));
                for i in 0..4 {
                    scratch.first[i][l] += (0..4).map(|j| site.diffusion[4 * i + j][l] * slope[j]).sum::<f64>();
                }
            }
        });
        // Means of 1e5 correlated products of rates near one.
        assert!((basis.form(&exact) - first).norm_max() < 0.15);
    }

    /// The integrals give equipartition, and the same bits on any number of threads.
    #[test]
    fn integrals_have_honest_errors_and_do_not_depend_on_threads() {
        let (problem, symmetry, pilot) = pilot(&chain([0.2, 0.4]), 20_000);
        let closed = || close_on_samples(&problem, &pilot, &Degrees::complete(), 4, &symmetry, None).unwrap();
        let closure = closed();
        let rule = || ImportanceRule::new(&closure, &pilot, &symmetry, 100_000, 3).unwrap();
        let [square, fourth] = [2, 4].map(|power| rule().mean(&|x| x[1].powi(power)).unwrap());
        // E v² = T = 1; the trusted part leaves out a few millionths.
        assert!(square.deviation(1.0) < 4.0 && square.error < 2e-3, "{square}");
        assert!(fourth.deviation(3.0) < 4.0 && fourth.error < 2e-2, "{fourth}");
        let density = rule().section(&[(1, 0.5)], &|_| 1.0).unwrap();
        let normal = (-0.125_f64).exp() / std::f64::consts::TAU.sqrt();
        assert!(density.deviation(normal) < 4.0 && density.error < 1e-3, "{density}");
        assert!(rule().effective() > 50_000.0 && rule().trusts(&pilot.states[0]) && !rule().trusts(&[50.0; 4]));
        let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (alone, mass) = single.install(|| (closed(), rule().log_mass()));
        assert_eq!(alone.exponent.coefficients, closure.exponent.coefficients);
        assert_eq!(mass, rule().log_mass());
    }
}
