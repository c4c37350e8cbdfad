//! Figures, and the numbers drawn in them as CSV.

use crate::study::Study;
use crate::support::figure::{Band, ContourPanel, Curve, Panel, Scale, Style, View, write_figure};
use crate::support::file::write_csv;
use expoly::{ClosedDensity, Density};
use std::path::Path;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Iso-lines of a density: the eight highest below its peak are drawn.
const LEVELS: [f64; 14] = [5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// One drawn closure: its method, its name, its legend entry, whether it is only a cut-off exp(Q), its density.
struct Drawn {
    method: &'static str,
    name: String,
    label: String,
    cut_off: bool,
    colour: usize,
    density: ClosedDensity<2>,
}

/// Writes `<stem>.svg` and the CSV files behind it.
pub(crate) fn draw(study: &Study, folder: &Path, seed: u64) -> Outcome<()> {
    let simulated = study.simulated.as_ref().map(|(density, _)| density);
    let all: Vec<Drawn> = study
        .closures
        .iter()
        .enumerate()
        .filter_map(|(k, judged)| {
            let (density, cut_off) = judged.drawn(simulated)?;
            let facts = &judged.closed.facts;
            let name = facts.name();
            let label = match facts.l1_estimate {
                Some(l1) => format!("{name} (L¹ ≈ {:.0e})", l1.value()),
                None if cut_off => format!("{name}, no density"),
                None => name.clone(),
            };
            Some(Drawn { method: facts.method, name, label, cut_off, colour: k + 1, density })
        })
        .collect();
    let stem = study.parameters.stem();
    let mut views = Vec::new();
    for (state, name, axis) in [(0, "displacement", "displacement y"), (1, "velocity", "velocity y′")] {
        let grid = grid(study, &all, state)?;
        let symbol = ["p_Y(y)", "p_Y′(y′)"][state];
        let table = Table::new(study, &all, state, &grid)?;
        table.write(&folder.join(format!("{stem}_{name}.csv")), name, &all)?;
        for scale in [Scale::Linear, Scale::Logarithmic] {
            views.push(View::Curves(table.panel(&all, axis, symbol, scale)));
        }
    }
    // The phase plane of each method's first closure.
    for (k, drawn) in all.iter().enumerate() {
        if all[..k].iter().any(|before| before.method == drawn.method) {
            continue;
        }
        let (x, y) = (grid(study, std::slice::from_ref(drawn), 0)?, grid(study, std::slice::from_ref(drawn), 1)?);
        let (x, y) = (thinned(&x), thinned(&y));
        let z: Vec<Vec<f64>> =
            y.iter().map(|v| x.iter().map(|y| drawn.density.pdf(&[*y, *v]).value).collect()).collect();
        let rows: Vec<Vec<f64>> =
            y.iter().zip(&z).flat_map(|(v, row)| x.iter().zip(row).map(|(y, p)| vec![*y, *v, *p])).collect();
        let file = format!("{stem}_phase_plane_{}.csv", drawn.name.replace(" n = ", "_"));
        write_csv(&folder.join(file), &["displacement", "velocity", "density"].map(String::from), &rows)?;
        let peak = z.iter().flatten().copied().fold(0.0, f64::max);
        views.push(View::Contour(ContourPanel {
            title: format!("p(y, y′), {}{}", drawn.name, if drawn.cut_off { ", no density" } else { "" }),
            x_label: String::from("displacement y"),
            y_label: String::from("velocity y′"),
            levels: LEVELS.iter().copied().filter(|level| *level < peak).take(8).collect(),
            x,
            y,
            z,
        }));
    }
    let mut caption = format!("{}; E[ξ(t)ξ(t+τ)] = 2D δ(τ).", study.parameters.line());
    if let Some(density) = simulated {
        let provenance = density.provenance();
        caption += &format!(
            "\nSimulation: {} samples, {} trajectories, time step {}, seed {seed}; band: ± 2 standard errors.",
            provenance.samples, provenance.trajectories, provenance.time_step
        );
    }
    if let Some((density, _)) = &study.gridded {
        let provenance = density.provenance();
        caption += &format!(
            "\nGrid: {} × {} cells of degree {}, estimated joint L¹ error {:.0e}.",
            provenance.cells[0], provenance.cells[1], provenance.degree, provenance.l1_error
        );
    }
    for judgement in study.closures.iter().filter_map(|judged| judged.closed.facts.judgement()) {
        caption += &format!("\n{judgement}.");
    }
    if all.iter().any(|d| d.cut_off) {
        caption +=
            "\nWithout density: exp(Q) of a root that cannot be normalised, cut off at the range of the samples.";
    }
    write_figure(&folder.join(format!("{stem}.svg")), &caption, 2, &views)?;
    Ok(())
}

/// What is drawn of one state: the abscissae and there the simulation, the grid's solution and the closures.
struct Table {
    x: Vec<f64>,
    simulated: Vec<(f64, f64)>,
    gridded: Vec<f64>,
    closures: Vec<Vec<f64>>,
}

impl Table {
    fn new(study: &Study, drawn: &[Drawn], state: usize, grid: &[f64]) -> Outcome<Self> {
        let simulated = match &study.simulated {
            None => Vec::new(),
            Some((density, _)) => {
                let histogram = density.histogram(state)?;
                grid.iter().map(|x| histogram.density_at([*x])).map(|p| (p.value, p.error)).collect()
            }
        };
        let gridded = study.gridded.as_ref().map(|(density, _)| {
            grid.iter().map(|x| Ok(density.marginal(state, *x)?.value)).collect::<expoly::Result<Vec<f64>>>()
        });
        let marginal = |drawn: &Drawn| {
            grid.iter().map(|x| Ok(drawn.density.marginal(state, *x)?.value)).collect::<expoly::Result<Vec<f64>>>()
        };
        let closures = drawn.iter().map(marginal).collect::<expoly::Result<_>>()?;
        Ok(Table { x: grid.to_vec(), simulated, gridded: gridded.transpose()?.unwrap_or_default(), closures })
    }

    fn write(&self, path: &Path, name: &str, drawn: &[Drawn]) -> std::io::Result<()> {
        let mut header = vec![name.to_owned()];
        if !self.simulated.is_empty() {
            header.extend(["simulation", "standard error"].map(String::from));
        }
        if !self.gridded.is_empty() {
            header.push(String::from("grid"));
        }
        header.extend(drawn.iter().map(|d| d.name.clone()));
        let row = |i: usize| {
            let mut row = vec![self.x[i]];
            row.extend(self.simulated.get(i).into_iter().flat_map(|(p, error)| [*p, *error]));
            row.extend(self.gridded.get(i));
            row.extend(self.closures.iter().map(|closure| closure[i]));
            row
        };
        write_csv(path, &header, &(0..self.x.len()).map(row).collect::<Vec<_>>())
    }

    fn panel(&self, drawn: &[Drawn], axis: &str, symbol: &str, scale: Scale) -> Panel {
        let mut curves: Vec<Curve> = drawn
            .iter()
            .zip(&self.closures)
            .map(|(drawn, values)| Curve {
                label: drawn.label.clone(),
                style: if drawn.cut_off { Style::Dotted } else { Style::Solid },
                colour: drawn.colour,
                points: self.x.iter().zip(values).map(|(x, p)| [*x, *p]).collect(),
            })
            .collect();
        if !self.gridded.is_empty() {
            curves.push(Curve {
                label: String::from("grid"),
                style: Style::Dashed,
                colour: 5,
                points: self.x.iter().zip(&self.gridded).map(|(x, p)| [*x, *p]).collect(),
            });
        }
        let mut bands = Vec::new();
        let mut floor = self.closures.iter().flatten().chain(&self.gridded).copied().fold(0.0, f64::max) * 1e-6;
        if !self.simulated.is_empty() {
            let around = |(x, (p, error)): (&f64, &(f64, f64))| [*x, p - 2.0 * error, p + 2.0 * error];
            bands.push(Band {
                label: String::new(),
                colour: 0,
                points: self.x.iter().zip(&self.simulated).map(around).collect(),
            });
            // Every fourth value as a marker; those that are mostly noise are left out.
            let clear = self.x.iter().zip(&self.simulated).step_by(4).filter(|(_, (p, error))| *p > 3.0 * error);
            let points: Vec<[f64; 2]> = clear.map(|(x, (p, _))| [*x, *p]).collect();
            floor = points.iter().map(|[_, p]| *p).fold(f64::MAX, f64::min) / 3.0;
            curves.push(Curve { label: String::from("simulation"), style: Style::Points, colour: 0, points });
        }
        let peak = curves.iter().flat_map(|c| &c.points).map(|[_, p]| *p).fold(0.0, f64::max);
        Panel {
            title: String::new(),
            x_label: axis.to_owned(),
            y_label: symbol.to_owned(),
            scale,
            bands,
            curves,
            y_range: (scale == Scale::Logarithmic).then_some([floor, 2.0 * peak]),
            x_range: None,
        }
    }
}

/// 240 points over the range of the samples or, without any, where the closures' densities are above 1e-6 of their peak.
fn grid(study: &Study, drawn: &[Drawn], state: usize) -> Outcome<Vec<f64>> {
    const COUNT: usize = 240;
    let between = |low: f64, high: f64| {
        (0..COUNT).map(move |i| low + (high - low) * i as f64 / (COUNT - 1) as f64).collect::<Vec<f64>>()
    };
    let coarse = match &study.simulated {
        Some((density, _)) => density.histogram(state)?.edges().collect(),
        None if study.gridded.is_some() => {
            let domain = study.gridded.as_ref().map_or([[-1.0, 1.0]; 2], |(density, _)| density.provenance().domain);
            between(domain[state][0], domain[state][1])
        }
        None => {
            let powers = [[1, 0], [0, 1]][state];
            let mean = |d: &Drawn| d.density.moment(powers).value;
            let spread = |d: &Drawn| d.density.variance(state).map_or(1.0, |v| v.value.sqrt());
            let low = drawn.iter().map(|d| mean(d) - 6.0 * spread(d)).fold(f64::MAX, f64::min);
            let high = drawn.iter().map(|d| mean(d) + 6.0 * spread(d)).fold(f64::MIN, f64::max);
            between(if state == 0 { low.max(study.parameters.offset) } else { low }, high)
        }
    };
    let occupied = |x: &f64| match &study.simulated {
        Some((density, _)) => density.histogram(state).is_ok_and(|h| h.density_at([*x]).value > 0.0),
        None => true,
    };
    let kept: Vec<f64> = coarse.into_iter().filter(occupied).collect();
    let (low, high) = (kept.first().copied().unwrap_or(-1.0), kept.last().copied().unwrap_or(1.0));
    Ok(between(low, high))
}

fn thinned(grid: &[f64]) -> Vec<f64> {
    grid.iter().copied().step_by(2).collect()
}
