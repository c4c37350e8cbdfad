//! Files that simulations go on from, damaged.

use super::mutants::mutant;
use super::probe::Probe;
use expoly::models::{Duffing, Solved};
use expoly::{Density, Problem, SimulatedDensity, Simulation, Wall};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

const MUTANTS: usize = 60;
/// Not to be cancelled.
const ALL: u64 = u64::MAX;

/// Files before any damage.
#[derive(Default)]
pub(super) struct Files(Vec<File>);

struct File {
    content: Vec<u8>,
    /// The answer of a run that goes on from it.
    answer: String,
    again: Again,
}

/// Goes on from a file, and returns its answer as text.
type Again = Box<dyn Fn(&Path) -> expoly::Result<String>>;

impl Files {
    /// A damaged file is refused, or the answer is that of the file as it was.
    pub(super) fn probe(&mut self, probe: &mut Probe) {
        let path = probe.folder.join("kept");
        if self.0.is_empty() {
            self.0 = probe.ask("files", || sound(&path)).unwrap_or_default();
        }
        if self.0.is_empty() {
            return probe.finding("other-answer", "a file that nothing happened to is refused");
        }
        let file = &self.0[probe.draw.below(self.0.len())];
        for _ in 0..MUTANTS {
            probe.documents += 1;
            let content = mutant(&mut probe.draw, &file.content);
            if let Err(error) = std::fs::write(&path, &content) {
                probe.finding("file", &error.to_string());
                return;
            }
            if let Some(answer) = probe.ask("a damaged file", || (file.again)(&path))
                && answer != file.answer
            {
                probe.show(&String::from_utf8_lossy(&content));
                probe.show(&format!("{answer}\ninstead of\n{}", file.answer));
                probe.finding("other-answer", "from a damaged file");
            }
        }
        let _ = std::fs::remove_file(&path);
    }
}

/// The files of a simulation above a wall that has ended, and of one that was cancelled.
fn sound(path: &Path) -> expoly::Result<Vec<File>> {
    let free = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let walled = free.clone().with_wall(Wall::above(-0.5, 0.9)?)?;
    let read = |path: &Path| Ok(told(&SimulatedDensity::from_checkpoint(path)?));
    let ended = walled.clone();
    Ok(vec![
        file(path, &|path| simulated(path, &walled, ALL), Box::new(read))?,
        file(path, &|path| simulated(path, &walled, ALL), Box::new(move |p| simulated(p, &ended, ALL)))?,
        file(path, &|path| simulated(path, &free, 1000), {
            let free = free.clone();
            Box::new(move |path| simulated(path, &free, ALL))
        })?,
    ])
}

/// The file that a run leaves, which may have been cancelled, and the answer of a run that goes on from it.
fn file(path: &Path, make: &dyn Fn(&Path) -> expoly::Result<String>, again: Again) -> expoly::Result<File> {
    let _ = std::fs::remove_file(path);
    let _ = make(path);
    let content = std::fs::read(path).unwrap_or_default();
    let answer = again(path)?;
    let _ = std::fs::remove_file(path);
    Ok(File { content, answer, again })
}

fn until(done: u64, most: u64) -> ControlFlow<()> {
    if done < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}

/// A small simulation, cancelled after some path-steps.
fn simulated(path: &Path, problem: &Problem, steps: u64) -> expoly::Result<String> {
    let simulation = Simulation::new().trajectories(8).samples(160).time_step(0.05).burn_in(5.0).bins(4).levels([0.5]);
    let simulation = simulation.checkpoint(path, Duration::ZERO).progress(|come| until(come.done, steps));
    Ok(told(&simulation.run(problem)?))
}

fn told(density: &SimulatedDensity) -> String {
    format!("{:?} {:?} {:?}", density.moment(&[2, 0]), density.marginal(0, 0.1), density.upcrossing_rate(0.5))
}
