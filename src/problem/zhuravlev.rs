use super::Problem;
use crate::error::{Error, Result};
use crate::polynomial::{Polynomial, twelve_digits};
use crate::walls::Wall;

/// Zhuravlev's transformation y = |x| + b, y′ = x′ sgn x (V. F. Zhuravlev, 1976; M. F. Dimentberg and D. V. Iourtchenko,
/// 2004, doi:10.1023/B:NODY.0000045510.93602.ca): it unfolds the half plane above a wall into a plane. Below a wall, take
/// the mirror image.
///
/// With an elastic wall x passes zero smoothly; the loss at impacts becomes the impulse of a damper there,
///
/// x″ + sgn(x) h(|x| + b, sgn(x) x′) + (1 − r) x′|x′| δ(x) = ξ,
///
/// with the same white noise ξ. The point (x, x′) and its reflection (−x, −x′) stand for the same state, so that the
/// density on the plane is symmetric and p_{Y,Y′}(y, v) = p_X(y − b, v) + p_X(b − y, −v) = 2 p_X(y − b, v).
impl Wall {
    /// The state (y, y′) that a point (x, x′) of the transformed plane stands for.
    ///
    /// ```
    /// use expoly::Wall;
    /// let wall = Wall::above(0.5, 0.9)?;
    /// assert_eq!(wall.unfolded_state([-1.0, 2.0]), [1.5, -2.0]);
    /// assert_eq!(wall.unfolded_points([1.5, -2.0]), [[1.0, -2.0], [-1.0, 2.0]]);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn unfolded_state(&self, [x, slope]: [f64; 2]) -> [f64; 2] {
        let sign = if x < 0.0 { -1.0 } else { 1.0 };
        [x.abs() + self.offset(), sign * slope]
    }

    /// The two points of the plane that stand for the state (y, y′), the one with x ≥ 0 first.
    pub fn unfolded_points(&self, [y, v]: [f64; 2]) -> [[f64; 2]; 2] {
        let x = y - self.offset();
        [[x, v], [-x, -v]]
    }

    /// The density p_X at a point of the transformed plane that belongs to a density of (y, y′), a function of the state.
    pub fn unfolded_density(&self, density: impl Fn([f64; 2]) -> f64, point: [f64; 2]) -> f64 {
        density(self.unfolded_state(point)) / 2.0
    }

    /// The back-transformation: the density of (y, y′) at `state` that belongs to the density `plane` of (x, x′).
    pub fn folded_density(&self, plane: impl Fn([f64; 2]) -> f64, state: [f64; 2]) -> f64 {
        if state[0] < self.offset() { 0.0 } else { self.unfolded_points(state).map(plane).iter().sum() }
    }

    /// The transformed oscillator's equation as text.
    ///
    /// # Errors
    /// [`Error::NotServed`] unless the problem is one of a displacement and its velocity.
    ///
    /// ```
    /// use expoly::{Wall, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.25, 0.2)?.problem()?;
    /// let wall = Wall::above(2.0, 0.75)?;
    /// assert_eq!(
    ///     wall.unfolded_equation(&problem)?,
    ///     "x'' + 4 sgn(x) + 4 x + 0.2 x' + 1.5 |x| x + 0.25 x^3 + 0.25 x' |x'| delta(x) = noise"
    /// );
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn unfolded_equation(&self, problem: &Problem) -> Result<String> {
        if problem.dimension() != 2 || problem.displacements() != [(0, 1)] {
            let (what, remedy) =
                ("other than a displacement and its velocity", "write these two states, in this order");
            return Err(Error::NotServed { method: "transformation of Zhuravlev", what, remedy });
        }
        problem.operator().require_polynomial("transformation of Zhuravlev")?;
        let [u, w] = [0, 1].map(|i| Polynomial::variable(2, i));
        let force = (&problem.operator().drift()[1] * -1.0).compose(&[u + self.offset(), w]);
        let mut text = String::from("x''");
        for (alpha, coefficient) in force.terms() {
            let (i, j) = (alpha[0], alpha[1]);
            // sgn(x) |x|^i (sgn(x) x′)^j is a plain power where the signs cancel, and sgn(x) times one where not.
            let odd_sign = (1 + i + j) % 2 == 1;
            let position = match (odd_sign, i) {
                (true, 0) => String::from("sgn(x)"),
                (true, _) => format!("|x| {}", power("x", i - 1)),
                (false, _) => power("x", i),
            };
            let factors = [position, power("x'", j)];
            let factors: Vec<&str> = factors.iter().map(|f| f.trim()).filter(|f| !f.is_empty()).collect();
            let sign = if coefficient < 0.0 { '-' } else { '+' };
            let size =
                if coefficient.abs() == 1.0 { String::new() } else { format!("{} ", twelve_digits(coefficient.abs())) };
            text += &format!(" {sign} {size}{}", factors.join(" "));
        }
        let loss = twelve_digits(1.0 - self.restitution());
        if loss > 0.0 {
            text += &format!(" + {loss} x' |x'| delta(x)");
        }
        Ok(text + " = noise")
    }
}

fn power(name: &str, exponent: u32) -> String {
    match exponent {
        0 => String::new(),
        1 => name.to_owned(),
        n => format!("{name}^{n}"),
    }
}
