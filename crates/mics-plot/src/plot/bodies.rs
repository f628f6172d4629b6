//! The bodies that figures are of, and their rows in `particles.csv` and `obstacles.csv`. Obstacles
//! have the numbers after those of the particles.

use super::Run;
use super::kinds::{Course, LINES, representatives};
use super::series::Group;
use super::table::{Rows, Table};
use mics_run::Result;
use mics_run::config::{Case, FixedRows, Motion};
use mics_run::folder::OBSTACLES;
use std::collections::HashMap;

/// The file of the rows of particles.
pub const PARTICLES: &str = "particles.csv";

/// The bodies that figures of motion are of: those that are `asked` for, or else all that move.
pub fn moving(case: &Case, asked: &[usize]) -> Vec<usize> {
    let particles = asked.iter().copied().filter(|id| *id < case.particle.len());
    if asked.is_empty() { movers(case).collect() } else { particles.collect() }
}

/// The bodies that figures of forces are of: those that are `asked` for, or else all that move, all
/// that are held where they have rows, and the obstacles.
pub fn loaded(case: &Case, asked: &[usize]) -> Vec<usize> {
    let held = |id: &usize| {
        case.output.fixed_rows() == FixedRows::Always && case.particle[*id].motion == Motion::Fixed
    };
    let held = (0..case.particle.len()).filter(held);
    let walls = case.particle.len()..case.particle.len() + case.obstacle.len();
    if asked.is_empty() { movers(case).chain(held).chain(walls).collect() } else { asked.to_vec() }
}

/// The free ones among the bodies of [`moving`].
pub fn free(case: &Case, asked: &[usize]) -> Vec<usize> {
    let mut ids = moving(case, asked);
    ids.retain(|id| case.particle[*id].is_free());
    ids
}

fn movers(case: &Case) -> impl Iterator<Item = usize> {
    case.particle.iter().enumerate().filter(|(_, p)| p.motion != Motion::Fixed).map(|(id, _)| id)
}

/// Columns of some bodies of a run, the first of which figures are over: a group each, of more than
/// a figure has lines for one each kind. Bodies without a row have none.
///
/// # Errors
/// When the rows lack a column.
pub fn groups(run: &Run, ids: &[usize], columns: &[&str]) -> Result<Vec<Group>> {
    if ids.len() <= LINES || columns[0] != "time" {
        return each(run, &representatives(&run.case, ids), columns);
    }
    let mut course = Course::new(&run.case, ids, columns);
    read(run, ids, columns, |id, row| course.take(id, row))?;
    Ok(course.groups())
}

/// Columns of some bodies of a run, a group each.
///
/// # Errors
/// As [`groups`].
pub fn each(run: &Run, ids: &[usize], columns: &[&str]) -> Result<Vec<Group>> {
    let mut tables: HashMap<usize, Table> =
        ids.iter().map(|id| (*id, Table::new(columns))).collect();
    read(run, ids, columns, |id, row| {
        if let Some(table) = tables.get_mut(&id) {
            table.push(row);
        }
    })?;
    let called = |id: usize| if ids.len() > 1 { run.case.called(id) } else { String::new() };
    let group = |id: &usize| Some(Group::new(called(*id), tables.remove(id)?));
    Ok(ids.iter().filter_map(group).filter(|group| !group.table.is_empty()).collect())
}

/// Reads the rows of the files that some bodies have rows in.
fn read(
    run: &Run,
    ids: &[usize],
    columns: &[&str],
    mut take: impl FnMut(usize, &[f64]),
) -> Result<()> {
    let particles = run.case.particle.len();
    let files = [(PARTICLES, 0..particles), (OBSTACLES, particles..usize::MAX)];
    let wanted = [&["id"], columns].concat();
    for (file, numbers) in files {
        if !ids.iter().any(|id| numbers.contains(id)) {
            continue;
        }
        let Some(mut rows) = Rows::open(&run.folder, file, &wanted)? else { continue };
        while let Some(row) = rows.advance()? {
            take(numbers.start + row[0] as usize, &row[1..]);
        }
    }
    Ok(())
}
