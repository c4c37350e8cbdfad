//! Functions as products, for sweeps over many states.

use super::corner::{Kink, Radius};
use super::functions::{Block, Functions};
use super::{Corner, PlaneJet};
use crate::control_variates::planes::{Form, PlaneFunctions, PlaneLanes, Planes};
use crate::control_variates::products::{ProductFactors, Products};
use crate::numerics::{Eight, PointLane};
use std::sync::Arc;

/// The kinks at one wall as functions of a plane.
#[derive(Debug)]
struct Kinks {
    corner: Corner,
    kinks: Vec<Kink>,
    highest: [usize; 4],
}

impl PlaneFunctions for Kinks {
    fn forms(&self) -> [Form; 2] {
        self.corner.forms()
    }

    fn len(&self) -> usize {
        self.kinks.len()
    }

    fn values(&self, x: &[PointLane], functions: &mut [PlaneLanes]) {
        let radius = self.radius(x);
        for (function, kink) in functions.iter_mut().zip(&self.kinks) {
            function[0] = radius.value(kink).0;
        }
    }

    fn jets(&self, x: &[PointLane], functions: &mut [PlaneLanes]) {
        let radius = self.radius(x);
        for (function, kink) in functions.iter_mut().zip(&self.kinks) {
            let PlaneJet { value, gradient: [u, w], hessian: [[uu, uw], [_, ww]] } = radius.jet(kink);
            *function = [value.0, u.0, w.0, uu.0, uw.0, ww.0];
        }
    }
}

impl Kinks {
    fn radius(&self, x: &[PointLane]) -> Radius<Eight> {
        let x: Vec<Eight> = x.iter().map(|lane| Eight(*lane)).collect();
        Radius::new(&self.corner, &x, self.highest)
    }
}

impl Products {
    /// These functions, after the constant.
    pub(in crate::closure) fn of(functions: &Functions) -> Self {
        let corners = functions.corners();
        let mut kinks: Vec<Vec<Kink>> = vec![Vec::new(); corners.len()];
        for (wall, kink) in functions.blocks.iter().flat_map(Block::each).flatten() {
            if !kinks[wall].contains(&kink) {
                kinks[wall].push(kink);
            }
        }
        let before = |wall: usize| kinks[..wall].iter().map(Vec::len).sum::<usize>();
        let place = |(wall, kink): (usize, Kink)| {
            before(wall) + kinks[wall].iter().position(|known| *known == kink).unwrap_or(0)
        };
        let mut listed = Vec::with_capacity(functions.len());
        for block in &functions.blocks {
            for kink in block.each() {
                let plane = kink.map(place);
                let exponents = block.factors.exponents().iter();
                listed.extend(exponents.map(|degrees| ProductFactors { plane, degrees: degrees.clone() }));
            }
        }
        let planes = corners.iter().zip(&kinks).map(|(corner, kinks)| -> Arc<dyn PlaneFunctions> {
            Arc::new(Kinks { corner: corner.clone(), kinks: kinks.clone(), highest: functions.highest })
        });
        Products::with_planes(functions.box_around(), Planes(planes.collect()), &listed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Jet;
    use super::super::wall::tests::{POINTS, functions_of_four};
    use super::*;
    use crate::numerics::EIGHT;

    /// The tree of products has the same values, images, sums and gradients.
    #[test]
    fn products_agree() {
        let functions = functions_of_four();
        let count = functions.len();
        let products = Products::of(&functions);
        assert_eq!(products.len(), count + 1);
        let drift = [1.1, -0.8, 0.3, -0.6];
        let a: Vec<f64> = (0..=count).map(|k| (0.7 * k as f64).sin()).collect();
        let mut scratch = products.scratch();
        let lanes: Vec<PointLane> = (0..4).map(|i| std::array::from_fn(|l: usize| POINTS[l % 3][i])).collect();
        products.place(&lanes, &mut scratch);
        // With noises that are correlated, and with those that are not: a kink between two bodies has the velocities of both.
        for (mixed, coupled) in [(0.2, vec![2, 3]), (0.0, vec![])] {
            let mut b = [0.0; 16];
            (b[10], b[11], b[14], b[15]) = (0.5, mixed, mixed, 0.7);
            scratch.first.copy_from_slice(&drift.map(|f| [f; EIGHT]));
            products.apply(&b.map(|b| [b; EIGHT]), &coupled, &mut scratch);
            for (l, x) in POINTS.iter().enumerate() {
                let [mut values, mut rates] = [(); 2].map(|()| vec![0.0; count]);
                functions.rates(x, (&drift, &b), &mut values, &mut rates);
                for k in 0..count {
                    let found = [products.value(&scratch, k + 1)[l], products.image(&scratch, k + 1)[l]];
                    assert!((found[0] - values[k]).abs() < 1e-13 * (1.0 + values[k].abs()), "{k}");
                    assert!(
                        (found[1] - rates[k]).abs() < 1e-12 * (1.0 + rates[k].abs()),
                        "{k}: {found:?} {}",
                        rates[k]
                    );
                }
            }
        }
        let sum = products.sum(&a, &scratch);
        products.gradient(&a, &mut scratch);
        for (l, x) in POINTS.iter().enumerate() {
            let mut jet = Jet::zero(4);
            functions.combine(x, &a[1..], &mut jet);
            let size: f64 = 1.0 + jet.gradient.iter().map(|g| g.abs()).sum::<f64>();
            assert!((sum[l] - a[0] - jet.value).abs() < 1e-12 * size);
            assert!((0..4).all(|i| (scratch.gradient[i][l] - jet.gradient[i]).abs() < 1e-12 * size));
        }
    }
}
