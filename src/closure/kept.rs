use super::reference::Reference;
use super::setting::Setting;
use super::trust_domain::TrustDomain;
use crate::fokker_planck::Local;
use crate::states::States;

/// The part of the trust domain on which a reference is large enough to be asked, with its nodes.
pub(super) struct Kept {
    pub(super) domain: TrustDomain,
    /// The nodes' places among those of the setting.
    pub(super) nodes: Vec<usize>,
    pub(super) points: States,
    pub(super) weights: Vec<f64>,
}

impl Kept {
    pub(super) fn above(setting: &Setting, reference: &Reference) -> Self {
        let domain = setting.domain.above(|x| reference.value(x), setting.drop);
        let all = &setting.nodes;
        let kept = |i: &usize| setting.is_on_lattice() || domain.contains(&all.points[*i]);
        let nodes: Vec<usize> = (0..all.len()).filter(kept).collect();
        let mut points = States::with_capacity(all.points.dimension(), nodes.len());
        nodes.iter().for_each(|&i| points.push(&all.points[i]));
        let weights = nodes.iter().map(|&i| all.weights[i]).collect();
        Kept { domain, nodes, points, weights }
    }

    /// The nodes, with the operator there.
    pub(super) fn locals<'a>(&'a self, setting: &'a Setting) -> impl Iterator<Item = (&'a [f64], &'a Local)> {
        self.points.iter().zip(self.nodes.iter().map(|&i| &setting.locals[i]))
    }
}
