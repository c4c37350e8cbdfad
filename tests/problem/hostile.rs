//! Bad input gets a typed error that names the value and the remedy; nothing panics.

use crate::common::*;
use expoly::models::{CubicDamping, DisplacementNoise, Duffing, DuffingChain, ParametricLinear, Solved};
use expoly::{
    Basis, Closure, Crossing, Density, Drift, Error, Estimate, ExpPolynomial, Gaussian, Grid, Intensity, Oscillator,
    Polynomial, Problem, Provenance, Scalar, Simulation, States, Support, Termination, Wall,
};
use nalgebra::{DMatrix, DVector, dmatrix};
use std::f64::consts::PI;

const ODD_NUMBERS: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0];

#[test]
fn an_intensity_is_finite_and_positive() {
    for value in ODD_NUMBERS {
        for make in [
            Intensity::new,
            Intensity::from_sigma,
            Intensity::from_two_sided_density,
            Intensity::from_one_sided_density,
        ] {
            let error = make(value).unwrap_err();
            assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
            assert!(error.to_string().contains(&value.to_string()), "the message names {value}: {error}");
        }
        assert!(Duffing::new(0.2, 1.0, 0.3, value).is_err());
        assert!(DuffingChain::new(&[0.2, value], 1.0, 0.3, 0.1, 1.0).is_err());
        assert!(DuffingChain::new(&[0.2, 0.1], 1.0, 0.3, 0.1, value).is_err());
    }
    assert!(DuffingChain::new(&[], 1.0, 0.3, 0.1, 1.0).is_err());
    // 2D = σ² = 2π S₀ = π G₀, all four ways round.
    let d = Intensity::new(0.37).unwrap();
    for same in [
        Intensity::from_sigma(d.amplitude()),
        Intensity::from_two_sided_density(d.two_sided_density()),
        Intensity::from_one_sided_density(d.one_sided_density()),
    ] {
        assert!((same.unwrap().d() - 0.37).abs() < 1e-15);
    }
}

#[test]
fn a_restitution_lies_between_zero_and_one() {
    for r in [0.0, -0.3, 1.0 + 1e-12, f64::NAN, f64::INFINITY] {
        for error in [Wall::above(0.0, r).unwrap_err(), Wall::below(0.0, r).unwrap_err()] {
            assert!(matches!(error, Error::OutOfRange { name: "restitution r", .. }), "{error}");
            assert!(error.to_string().contains("0 < r ≤ 1"), "{error}");
        }
    }
    for b in [f64::NAN, f64::INFINITY] {
        assert!(matches!(Wall::above(b, 1.0), Err(Error::OutOfRange { .. })));
        assert!(matches!(Wall::below(b, 1.0), Err(Error::OutOfRange { .. })));
    }
    assert!(Wall::above(-3.0, 1.0).is_ok());
}

#[test]
fn parameters_that_are_not_finite_are_named() {
    for value in [f64::NAN, f64::INFINITY] {
        let error = Problem::of(Duffing::new(0.2, value, 0.3, 0.2).unwrap()).unwrap_err();
        let Error::NotFinite { part, state, exponents, .. } = &error else { panic!("{error}") };
        assert_eq!((*part, *state, exponents.as_slice()), ("drift", 1, &[1, 0][..]));
        assert!(error.to_string().contains("finite"), "{error}");
    }
    // A negative growth of noise has no real amplitude.
    let system = DisplacementNoise::new(0.5, 1.0, 0.4, -0.7, 0.5).unwrap();
    assert!(matches!(Problem::of(system), Err(Error::NotFinite { part: "noise", .. })));
    // Parametric noise so strong that nothing is stationary.
    assert!(matches!(ParametricLinear::new(1.0, 1.0, 0.6, 0.2), Err(Error::OutOfRange { name: "δ − 1", .. })));
}

#[test]
fn an_order_is_at_least_one() {
    let (free, walled) = (problem(duffing()), duffing_above(0.0, 1.0));
    for (error, least) in [
        (Closure::classical(0).solve(&free).unwrap_err(), "order 1"),
        (Closure::classical(0).solve(&walled).unwrap_err(), "order 1"),
        (Closure::classical(0).basis(Basis::Folded).solve(&walled).unwrap_err(), "order 1"),
        (Closure::classical(1).solve(&walled).unwrap_err(), "order 2"),
    ] {
        assert!(matches!(error, Error::OutOfRange { name: "order of the closure", .. }));
        assert!(error.to_string().contains(least), "{error}");
    }
    // An order that would take terabytes.
    for order in [1000, u32::MAX] {
        assert!(matches!(Closure::classical(order).solve(&free), Err(Error::TooMuchMemory { .. })), "{order}");
    }
}

/// No damping, negative damping, negative stiffness without a cubic term: nothing is stationary, and the error is typed.
#[test]
fn a_drift_without_a_stationary_density_is_refused() {
    let unstable = [
        Duffing::new(-0.2, 1.0, 0.3, 0.2),
        Duffing::new(0.0, 1.0, 0.3, 0.2),
        Duffing::new(0.2, -1.0, 0.0, 0.2),
        Duffing::new(0.2, 1.0, -0.3, 0.2),
    ];
    for (k, system) in unstable.into_iter().enumerate() {
        let system = system.unwrap();
        let result = Closure::classical(4).solve(&problem(system));
        match result {
            Err(error) => {
                assert!(matches!(error, Error::NoDensity { .. }), "{k}: {error}");
                assert!(error.to_string().contains("signs of damping"), "{error}");
            }
            // A softening spring has a Gaussian closure; what it closes to is no density.
            Ok(solution) => assert_ne!(solution.termination(), Termination::Root, "{k}"),
        }
        assert!(system.exact().is_err(), "{k}");
    }
    let drifting = CubicDamping::new([-0.5, -0.1], 1.0, 0.0, 0.2).unwrap();
    assert!(matches!(Closure::classical(2).solve(&problem(drifting)), Err(Error::NoDensity { .. })));
}

struct Silent;

impl Drift<2, 1> for Silent {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -v - x]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 1]; 2] {
        [[S::from(0.0)]; 2]
    }
}

/// One state, no velocity: a wall makes no sense.
struct Relaxation;

impl Drift<1, 1> for Relaxation {
    fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-(x + x.powi(3))]
    }
    fn noise<S: Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
        [[S::from(1.0)]]
    }
}

/// State 0 is driven by noise: no displacement.
struct Diffusing;

impl Drift<2, 2> for Diffusing {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -(v + x)]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 2]; 2] {
        let [o, one] = [0.0, 1.0].map(S::from);
        [[one, o], [o, one]]
    }
}

#[test]
fn systems_without_noise_or_without_a_displacement_are_refused() {
    assert!(matches!(Problem::of(Silent), Err(Error::NoDensity { .. })));
    let wall = Wall::above(0.0, 0.9).unwrap();
    for open in [problem(Diffusing), problem(Relaxation)] {
        assert_eq!(open.with_wall(wall).unwrap_err(), Error::NotADisplacement { state: 0 });
    }
    // The motion of y, z is deterministic, though x is shaken by noise and by them; y alone is reached through x.
    let text = |y: &str| {
        format!("states = ['x', 'y', 'z']\ndrift = {{ x = '-x + y', y = '{y}', z = '-z + y' }}\nnoise.w.x = '1'")
    };
    let deaf = Problem::from_toml(&text("-y - y^3")).unwrap();
    let unreached = Closure::new(2).solve(&deaf).unwrap_err();
    assert!(matches!(unreached, Error::NoDensity { .. }) && unreached.to_string().contains("state 1"), "{unreached}");
    assert!(Closure::new(2).solve(&Problem::from_toml(&text("-y - y^3 - x")).unwrap()).is_ok());
    let plane = Problem::from_toml("states = ['x', 'y']\ndrift = { x = '-x', y = '-y' }\nnoise.w.x = '1'").unwrap();
    let unreached = Grid::new().solve(&plane).unwrap_err();
    assert!(matches!(unreached, Error::NoDensity { .. }) && unreached.to_string().contains("state 1"), "{unreached}");
    // Without a wall both have a density.
    assert!(Closure::classical(4).solve(&problem(Diffusing)).unwrap().density().is_ok());
    let density = Closure::classical(4).solve(&problem(Relaxation)).unwrap().density().unwrap();
    // ln p = −2(x²/2 + x⁴/4): one state is closed exactly too.
    assert!((density.log_polynomial().coefficient(&[4]) + 0.5).abs() < 1e-12);
}

#[test]
fn wrong_dimensions_and_indices_are_refused() {
    let error = Polynomial::from_terms(2, [(&[1, 2, 3][..], 1.0)]).unwrap_err();
    assert!(matches!(error, Error::Dimension { expected: 2, found: 3, .. }), "{error}");
    let density = duffing().exact().unwrap();
    for error in [
        density.marginal(2, 0.0).unwrap_err(),
        density.variance(7).unwrap_err(),
        density.flux(Crossing { displacement: 2, ..Crossing::upward(0.0) }, 1).unwrap_err(),
        density.flux(Crossing { velocity: 2, ..Crossing::upward(0.0) }, 1).unwrap_err(),
        density.flux(Crossing { velocity: 0, ..Crossing::upward(0.0) }, 1).unwrap_err(),
    ] {
        assert!(matches!(error, Error::Dimension { expected: 2, .. }), "{error}");
    }
}

#[test]
fn densities_need_a_finite_mass_and_a_proper_frame() {
    let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
    let unit = Gaussian { mean: DVector::zeros(2), covariance: DMatrix::identity(2, 2) };
    let growing = &x * &x * -1.0 + &v * &v;
    let error = ExpPolynomial::from_states(&growing, &unit, Support::WholeSpace).unwrap_err();
    let Error::NotNormalisable { direction, .. } = &error else { panic!("{error}") };
    assert!(direction[1].abs() > 0.9, "{direction:?}");
    // A channel that bends: no straight ray grows, but the mass never ends.
    let bent = &x + &(&v * &v) * -1.0;
    let channel = &(&bent * &bent) * -1.0;
    assert!(matches!(
        ExpPolynomial::from_states(&channel, &unit, Support::WholeSpace),
        Err(Error::NotNormalisable { .. })
    ));
    let falling = &x * &x * -1.0 + &v * &v * -1.0;
    // Variances that are no variances, none of them followed by an endless search for eigenvalues.
    for covariance in
        [dmatrix![1.0, 1.0; 1.0, 1.0], dmatrix![f64::NAN, 0.0; 0.0, 1.0], dmatrix![f64::INFINITY, 0.0; 0.0, 1.0]]
    {
        let flat = Gaussian { mean: DVector::zeros(2), covariance };
        let density = ExpPolynomial::from_states(&falling, &flat, Support::WholeSpace);
        assert!(matches!(density, Err(Error::OutOfRange { .. })), "{density:?}");
    }
    for support in [Support::Above(f64::NAN), Support::Region(vec![[1.0, 0.0], [-1.0, 1.0]])] {
        let density = ExpPolynomial::from_states(&falling, &unit, support);
        assert!(matches!(density, Err(Error::OutOfRange { .. })), "{density:?}");
    }
    let three = ExpPolynomial::from_states(&falling, &unit, Support::Region(vec![[0.0, 1.0]; 3]));
    assert!(matches!(three, Err(Error::Dimension { expected: 2, found: 3, .. })), "{three:?}");
    for region in [
        [[0.0, 0.0], [-1.0, 1.0]],
        [[1.0, 0.0], [-1.0, 1.0]],
        [[0.0, f64::INFINITY], [-1.0, 1.0]],
        [[f64::NAN, 1.0], [-1.0, 1.0]],
    ] {
        assert!(matches!(ExpPolynomial::cut_off(&growing, &region), Err(Error::OutOfRange { .. })));
    }
    let cut = ExpPolynomial::cut_off(&growing, &[[-1.0, 1.0], [-1.0, 1.0]]).unwrap();
    assert!((cut.moment(&[0, 0]).unwrap().value - 1.0).abs() < 1e-12);
    assert_eq!(cut.pdf(&[0.0, 1.1]).unwrap().value, 0.0);
}

/// Q that is no number or too steep to be integrated is no density; nor is there a flux of a power beyond 200.
#[test]
fn densities_are_made_of_numbers() {
    let unit = Gaussian { mean: DVector::zeros(2), covariance: DMatrix::identity(2, 2) };
    for odd in [f64::NAN, f64::NEG_INFINITY, -1e308] {
        let q = Polynomial::from_terms(2, [([2, 0], -0.5), ([0, 2], -0.5), ([4, 0], odd)]).unwrap();
        for density in [
            ExpPolynomial::from_states(&q, &unit, Support::WholeSpace),
            ExpPolynomial::from_states(&q, &unit, Support::Above(0.3)),
            ExpPolynomial::cut_off(&q, &[[-1.0, 1.0]; 2]),
        ] {
            assert!(matches!(density, Err(Error::OutOfRange { .. })), "{odd}: {density:?}");
        }
    }
    let closed = Closure::new(2).solve(&problem(duffing())).unwrap();
    let power_law = ParametricLinear::new(0.1, 1.0, 0.5, 0.2).unwrap().exact();
    for density in [&duffing().exact().unwrap() as &dyn Density, &closed, &power_law] {
        for (level, power) in [(0.3, 201), (0.3, u32::MAX), (f64::NAN, 1), (f64::INFINITY, 1)] {
            let refused = density.flux(Crossing::upward(level), power);
            assert!(matches!(refused, Err(Error::OutOfRange { .. })), "{level}, {power}: {refused:?}");
        }
    }
    let coarse = Grid::new().accuracy(1e-2).solve(&problem(duffing())).unwrap();
    let sampled = Simulation::new().samples(1024).run(&problem(duffing())).unwrap();
    for density in [&duffing().exact().unwrap() as &dyn Density, &closed, &power_law, &coarse, &sampled] {
        for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let log = density.log_pdf(&[0.1, odd]).map(Estimate::exact);
            let whole = density.joint_marginal([0, 1], [odd, 0.1]);
            for refused in [density.pdf(&[odd, 0.1]), log, density.marginal(1, odd), whole] {
                let named = |error: &Error| matches!(error, Error::OutOfRange { name: "coordinate of a state", .. });
                assert!(refused.as_ref().is_err_and(named), "{odd}: {refused:?}");
            }
        }
    }
    // A mean that is not defined is NaN.
    let [one, two] = [1, 2].map(|n| Polynomial::variable(n, n - 1));
    let line = Gaussian { mean: DVector::zeros(1), covariance: DMatrix::identity(1, 1) };
    let misfit = Gaussian { mean: DVector::zeros(2), covariance: DMatrix::identity(1, 1) };
    let high = Polynomial::from_terms(1, [([100_000], 1.0)]).unwrap();
    for mean in [line.expectation(&two), line.expectation(&high), misfit.expectation(&one)] {
        assert!(mean.is_nan(), "{mean}");
    }
}

/// Texts that this library does not write.
#[test]
fn spoiled_texts_are_refused() {
    let polynomial = |text: &str| serde_json::from_str::<Polynomial>(text);
    let text = serde_json::to_string(&Polynomial::from_terms(2, [([1, 0], 2.0), ([0, 3], -1.0)]).unwrap()).unwrap();
    assert_eq!(polynomial(&text).unwrap().to_string(), "2 x1 - x2^3");
    assert!(polynomial(&text.replace("[1,0,0,3]", "[1,0,0]")).is_err());
    assert!(polynomial(&text.replace("\"dimension\":2", "\"dimension\":18446744073709551615")).is_err());
    for text in [r#"{"dimension":0,"values":[1.0]}"#, r#"{"dimension":2,"values":[1.0,2.0,3.0]}"#] {
        assert!(serde_json::from_str::<States>(text).is_err(), "{text}");
    }
    let text = serde_json::to_string(&Wall::above(0.0, 0.9).unwrap()).unwrap().replace("0.9", "9.0");
    let wall = serde_json::from_str::<Wall>(&text).unwrap();
    assert!(matches!(problem(duffing()).with_wall(wall), Err(Error::OutOfRange { name: "restitution r", .. })));
}

struct Steep(u32, f64);

impl Drift<1, 1> for Steep {
    fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-x.powi(self.0)]
    }
    fn noise<S: Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
        [[S::from(self.1)]]
    }
}

#[test]
fn degrees_and_squares_of_noise_are_moderate() {
    assert!(Problem::of(Steep(59, 1.0)).is_ok());
    for degree in [61, 3001, u32::MAX] {
        let error = Problem::of(Steep(degree, 1.0)).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { name: "degree of the drift", .. }), "{error}");
    }
    assert!(matches!(Problem::of(Steep(3, 1e200)), Err(Error::NotFinite { part: "squared noise", .. })));
}

/// Nothing is allocated that does not keep to a limit, which is an option of every method whose memory grows with its own.
#[test]
fn memory_is_estimated_before_it_is_taken() {
    let refused = |what: &str, error: Option<Error>| match error {
        Some(error @ Error::TooMuchMemory { needed, limit, .. }) => {
            println!("{what}: {error}");
            assert!(needed > limit, "{what}: {error}");
            needed
        }
        other => panic!("{what}: {other:?}"),
    };
    let (free, walled) = (problem(duffing()), duffing_above(0.3, 0.8));
    // Terabytes, by the default limit.
    let states = Simulation::new().samples(1 << 40).states(&free).err();
    assert!((refused("states", states) - 16_384.0).abs() < 0.1);
    let spectrum = Simulation::new().trajectories(1 << 17).samples(1 << 18).spectrum(0, 1 << 20);
    assert!((refused("spectrum", spectrum.run(&free).err()) - 1024.0).abs() < 0.1);
    for count in [1_000_000_000_000, usize::MAX] {
        refused("pilot", Closure::new(4).pilot_states(count).solve(&free).err());
    }
    refused("coefficients", Closure::classical(400).solve(&free).err());
    let chain = DuffingChain::new(&[0.3; 3], 1.0, 0.3, 0.5, 0.8).unwrap().problem().unwrap();
    let many = |order: u32| Closure::new(order).pilot_states(5120);
    refused("functions", many(10).memory_limit(1.0).solve(&chain).err());
    // A thousand cells of degree 8 take a quarter of a gibibyte: the first mesh of sixteen and more some thousandths.
    for problem in [&free, &walled] {
        refused("first mesh", Grid::new().memory_limit(1e-3).solve(problem).err());
    }
    // Where the memory ends later, the density is as good as its estimate says, and a warning names the option.
    let ended = Grid::new().accuracy(1e-11).degree(4).memory_limit(0.1).solve(&free).unwrap();
    println!("estimate {:.1e}, {:?}", ended.l1_estimate(), ended.provenance().warning);
    assert!(ended.l1_estimate() > 1e-11);
    assert!(ended.provenance().warning.as_ref().is_some_and(|warning| warning.contains("memory_limit")));
    // No limit at all.
    for limit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for error in [
            Grid::new().memory_limit(limit).solve(&free).err(),
            Closure::new(2).memory_limit(limit).solve(&free).err(),
            Simulation::new().samples(1000).memory_limit(limit).run(&free).err(),
        ] {
            assert!(matches!(error, Some(Error::OutOfRange { name: "memory limit in GiB", .. })), "{error:?}");
        }
    }
}

/// What would take for ever is refused before it begins.
#[test]
fn times_beyond_all_patience_are_refused() {
    let free = problem(duffing());
    let new = || Simulation::new().samples(100);
    for simulation in [
        new().burn_in(1e15),
        new().burn_in(1e308),
        new().sampling_interval(1e15),
        new().sampling_interval(1e308),
        new().sampling_interval(1e-300),
    ] {
        let text = format!("{simulation:?}");
        let refused = simulation.run(&free).map(|_| ());
        assert!(matches!(refused, Err(Error::OutOfRange { name: "number of path-steps", .. })), "{text}: {refused:?}");
    }
}

/// At r ≤ 0.163 the impact rate is infinite, and the finite one that is found carries a warning.
#[test]
fn walls_that_trajectories_collapse_onto_are_warned_of() {
    let problem = duffing_above(0.0, 0.15);
    let simulated = |problem: &Problem| Simulation::new().samples(20_000).run(problem).unwrap().provenance().clone();
    let gridded = Grid::new().accuracy(1e-3).solve(&problem).unwrap();
    let closed = Closure::new(2).pilot_states(5120).solve(&problem).unwrap();
    for made in [&simulated(&problem), gridded.provenance(), closed.provenance()] {
        assert!(made.warning.as_ref().is_some_and(|warning| warning.contains("0.163")), "{made:?}");
    }
    assert_eq!(simulated(&duffing_above(0.0, 0.3)).warning, None);
}

/// Random oscillators with extreme and odd parameters, some of them with a wall: every result is an answer or a typed error,
/// and an answer's density is a density.
#[test]
fn nothing_panics_on_random_systems() {
    struct Random([f64; 8], Intensity);
    impl Oscillator for Random {
        fn force<S: Scalar>(&self, x: S, v: S) -> S {
            let c = self.0;
            let odd = x.powi(3) * c[2] + x.powi(5) * c[3] + v.powi(3) * c[5];
            v * c[0] + x * c[1] + odd + x * x * v * c[4] + x * x * c[6] + S::from(c[7])
        }
        fn intensity(&self) -> Intensity {
            self.1
        }
    }
    /// The problem, if its coefficients are finite.
    fn asked(system: Random, wall: Wall) -> expoly::Result<[Problem; 2]> {
        let free = Problem::of(system)?;
        Ok([free.clone(), free.with_wall(wall)?])
    }
    let mut points = Points::new(2026);
    let extreme = [0.0, 1e-8, 1e6, 1e150, f64::NAN, f64::INFINITY, -1e3];
    let mut densities = 0;
    for k in 0..60usize {
        let mut c: [f64; 8] = points.array(1.0);
        // Two in three are confined, so that many have a density.
        if k % 3 > 0 {
            [c[0], c[2], c[3], c[5]] = [c[0], c[2], c[3], c[5]].map(f64::abs);
        }
        if k % 5 == 0 {
            c[k % 8] = extreme[k % extreme.len()];
        }
        let intensity = Intensity::new(0.05 + points.next().abs()).unwrap();
        for order in [2, 3, 4] {
            let basis = if k % 2 == 0 { Basis::Classical } else { Basis::Folded };
            let closure = Closure::classical(order).basis(basis);
            let wall = Wall::above(points.next(), 0.3 + 0.7 * points.next().abs()).unwrap();
            let Ok(problems) = asked(Random(c, intensity), wall) else { continue };
            for solution in problems.iter().flat_map(|problem| closure.solve(problem)) {
                if let Ok(density) = solution.density() {
                    let mass = density.moment(&[0, 0]).unwrap();
                    assert!((mass.value - 1.0).abs() < 1e-6, "{k}, {order}: {mass}");
                    densities += 1;
                }
            }
        }
    }
    assert!(densities > 60, "{densities}");
}

/// A density that is high on a fine lattice, where every cell is evaluated first, and 1e-12 of that elsewhere.
#[derive(Default)]
struct Lattice(Provenance);

impl Density for Lattice {
    fn dimension(&self) -> usize {
        1
    }
    fn provenance(&self) -> &Provenance {
        &self.0
    }
    fn pdf(&self, x: &[f64]) -> expoly::Result<Estimate> {
        let on_lattice = (x[0] * 2.0_f64.powi(30)).fract() == 0.0;
        Ok(Estimate::new(if on_lattice { 1.0 } else { 1e-12 }, 0.0))
    }
    fn marginal(&self, _: usize, x: f64) -> expoly::Result<Estimate> {
        self.pdf(&[x])
    }
    fn bounds(&self) -> Vec<[f64; 2]> {
        vec![[0.0, 1.0]]
    }
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> expoly::Result<Estimate> {
        Ok(Estimate::new(g(&[0.5]), 0.0))
    }
    fn flux(&self, _: Crossing, _: u32) -> expoly::Result<Estimate> {
        Ok(Estimate::new(0.0, 0.0))
    }
}

#[test]
fn draws_from_what_is_no_density_end() {
    let drawn = expoly::statistics::samples(&Lattice::default(), 1, 1);
    assert!(matches!(drawn, Err(Error::NotKnown { .. })), "{drawn:?}");
}

/// A trap in SI units, with friction of Γ/m = 2e16 per second and a spring that relaxes at k/Γ = 5e-6 per second: no trajectory and no grid
/// of its steps; both rates are named, to rounding of the parameters.
#[test]
fn rates_that_are_too_far_apart_are_named() {
    let problem = Problem::from_toml(include_str!("../cases/trap-si.toml")).unwrap();
    let (mass, friction) = (4.0 / 3.0 * PI * 70e-9_f64.powi(3) * 2000.0, 2.0 * PI * 0.01);
    let rates = [friction / mass, (2.0 * PI * 50000.0_f64).powi(2) * mass / friction];
    let by_grid = Grid::new().solve(&problem).map(|_| ());
    let by_simulation = Simulation::new().samples(1000).run(&problem).map(|_| ());
    for found in [by_grid, by_simulation] {
        let Err(Error::TooStiff { fastest, slowest }) = found else { panic!("{found:?}") };
        assert!(
            (fastest / rates[0] - 1.0).abs() < 1e-9 && (slowest / rates[1] - 1.0).abs() < 1e-9,
            "{fastest} {slowest}"
        );
    }
    assert!(Closure::new(2).solve(&problem).is_ok());
}

/// Trajectories that grow without end, by a resonance that nothing damps, by chance alone or by energy that is fed in, and those that end
/// where the noise vanishes, have no density; what is slow to settle, or comes to rest nowhere, has one.
#[test]
fn what_does_not_settle_has_no_density() {
    let undamped = include_str!("../cases/undamped.toml");
    let shrinking = "states = ['x']\ndrift.x = '-x'\nnoise.w.x = '0.5*x'";
    let free = "states = ['x', 'v']\ndrift = { x = 'v', v = '-v' }\nnoise.w.v = '1'";
    let fed = "states = ['x', 'v']\ndrift = { x = 'v', v = '0.02*v - x' }\nnoise.w.v = '1'";
    let elsewhere = "states = ['x']\ndrift.x = '1 - x'\nnoise.w.x = '0.5*(x - 1)'";
    let driftless = "states = ['x']\ndrift.x = '0'\nnoise.w.x = '1'";
    for (text, what) in [
        (shrinking, "come to rest"),
        (elsewhere, "come to rest"),
        (driftless, "spread without end"),
        (undamped, "keep growing"),
        (free, "keep growing"),
        (fed, "exploded"),
    ] {
        let problem = Problem::from_toml(text).unwrap();
        for error in [Closure::new(4).solve(&problem).map(|_| ()), Grid::new().solve(&problem).map(|_| ())] {
            let error = error.expect_err(text);
            assert!(error.to_string().contains(what), "{text}: {error}");
        }
    }
    // Without a drift there is a density at each time all the same, with the variance t.
    let spreading =
        Simulation::new().transient(&Problem::from_toml(driftless).unwrap(), [0.0], &[2.0]).unwrap().remove(0);
    assert!(spreading.moment(&[2]).unwrap().deviation(2.0) < 4.0);
    let frozen = Problem::from_toml(include_str!("../cases/two-oscillators-frozen.toml")).unwrap();
    let error = Closure::new(4).pilot_states(16_384).solve(&frozen).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("stay where they began"), "{error}");
    // Damping of a thousandth; rates of 2e16 and 5e-6 beside each other; damping of higher order alone, or negative at rest; noise that vanishes
    // at a state of rest that drives away.
    for text in [
        "states = ['x', 'v']\ndrift = { x = 'v', v = '-0.001*v - x' }\nnoise.w.v = '1'",
        include_str!("../cases/trap-si.toml"),
        "states = ['x', 'v']\ndrift = { x = 'v', v = '-v^3 - x' }\nnoise.w.v = '1'",
        "states = ['x', 'v']\ndrift = { x = 'v', v = '0.5*v - 0.5*x^2*v - x' }\nnoise.w.v = '0.5'",
        include_str!("../cases/cycle-driven-displacement.toml"),
        "states = ['x']\ndrift.x = 'x - x^3'\nnoise.w.x = '0.5*x'",
        "states = ['x', 'v']\ndrift = { x = 'v', v = '-v + x - x^3' }\nnoise.w.v = '0.3*x'",
        include_str!("../cases/lorenz-multiplicative.toml"),
    ] {
        let problem = Problem::from_toml(text).unwrap();
        let closed = Closure::new(2).pilot_states(1024).solve(&problem).map(|_| ());
        // The first mesh is beyond the memory, after the question.
        let solved = Grid::new().memory_limit(1e-6).solve(&problem).map(|_| ());
        for found in [closed, solved] {
            assert!(!matches!(found, Err(Error::NoDensity { .. } | Error::Exploded { .. })), "{text}: {found:?}");
        }
    }
}
