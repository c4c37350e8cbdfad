use crate::closure::discretisation::Discretisation;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::reference::Reference;
use crate::fokker_planck::Local;
use crate::states::States;

/// The part of the trust domain on which a reference is large enough to be relied on, with its nodes.
pub(in crate::closure) struct Retained {
    pub(in crate::closure) domain: TrustDomain,
    /// The nodes' places among those of the discretisation.
    pub(in crate::closure) nodes: Vec<usize>,
    pub(in crate::closure) points: States,
    pub(in crate::closure) weights: Vec<f64>,
}

impl Retained {
    pub(in crate::closure) fn above(discretisation: &Discretisation, reference: &Reference) -> Self {
        let domain = discretisation.domain.above(|x| reference.value(x), discretisation.drop);
        let all = &discretisation.nodes;
        let kept = |i: &usize| discretisation.is_on_lattice() || domain.contains(&all.points[*i]);
        let nodes: Vec<usize> = (0..all.len()).filter(kept).collect();
        let mut points = States::with_capacity(all.points.dimension(), nodes.len());
        nodes.iter().for_each(|&i| points.push(&all.points[i]));
        let weights = nodes.iter().map(|&i| all.weights[i]).collect();
        Retained { domain, nodes, points, weights }
    }

    /// The nodes, with the operator there.
    pub(in crate::closure) fn locals<'a>(
        &'a self,
        discretisation: &'a Discretisation,
    ) -> impl Iterator<Item = (&'a [f64], &'a Local)> {
        self.points.iter().zip(self.nodes.iter().map(|&i| &discretisation.locals[i]))
    }
}
