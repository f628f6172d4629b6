//! The table of a report of the pressure solves of its last step with a history.

use crate::plot::{Solve, StepSolves};
use maud::{Markup, html};
use mics_run::words::rounded;

/// A row a solve: iterations, first and last residual, tolerance, |D| before and after.
pub fn table(step: &StepSolves) -> Markup {
    let scientific = |value: f64| format!("{value:.2e}");
    let some = |value: Option<f64>| value.map_or(String::new(), scientific);
    let residual = |point: Option<&(f64, f64)>| some(point.map(|point| point.1));
    let iterations = |solve: &Solve| solve.residuals.last().map_or(0.0, |point| point.0);
    html! {
        p.soft { "The pressure solves of step " (step.step) ", t = " (rounded(step.time))
            " s, the last one with a history; " code { "solves.csv" } " has all." }
        div.scroll { table {
            thead { tr { th { "solve" } th { "norm" } th.number { "iterations" }
                th.number { "first residual" } th.number { "last residual" }
                th.number { "tolerance" } th.number { "|D| before (1/s)" }
                th.number { "|D| after (1/s)" } } }
            tbody { @for solve in &step.solves { tr {
                th scope="row" { (step.name(solve)) } td { (solve.norm) }
                td.number { (iterations(solve)) }
                td.number { (residual(solve.residuals.first())) }
                td.number { (residual(solve.residuals.last())) }
                td.number { (some(solve.tolerance)) }
                td.number { (scientific(solve.divergence.0)) }
                td.number { (some(solve.divergence.1)) }
            } } }
        } }
    }
}
