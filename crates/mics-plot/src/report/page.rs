//! The page: HTML by `maud`, which escapes all that comes from a case or a log.

use super::figures::{Figure, Part};
use super::{Run, numbers, solves};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use mics_run::compare::{measured, percent};
use mics_run::config::{AXES, MeasureKind};

/// Keeps a browser from fetching anything, whatever the page says.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The whole report.
pub fn page(run: &Run, figures: &[Figure]) -> Markup {
    let sections = sections(run, figures);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content={ "mics " (run.provenance.version) };
                title { (run.case().name) " \u{2013} mics report" }
                link rel="icon" href="data:,";
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                header {
                    div {
                        div.head { h1 { (run.case().name) } (status(run)) }
                        p.soft { (lead(run)) }
                        @if let Some(reason) = run.failure() { p.notice { (reason) } }
                        @for note in notes(run) { p.notice { (note) } }
                        (tiles(run))
                        nav aria-label="Sections" {
                            @for (id, title, _) in &sections { a href={ "#" (id) } { (title) } }
                        }
                    }
                }
                main {
                    @for (id, title, body) in &sections {
                        section id=(id) { h2 { (title) } (body) }
                    }
                    footer {
                        "Written by mics " (run.provenance.version) " from the files of the run. \
                            Units are SI, or the case's own consistent ones; the method and its \
                            equation numbers are those of MICS (Ushijima et al. 2003), as the \
                            chapter on the method in its book has them."
                    }
                }
            }
        }
    }
}

/// The sections that the run has something for: a name for links, a title and what they hold.
fn sections(run: &Run, figures: &[Figure]) -> Vec<(&'static str, &'static str, Markup)> {
    let shown = |part: Part, class: &str| {
        let figures: Vec<&Figure> = figures.iter().filter(|f| f.part == part).collect();
        (!figures.is_empty()).then(|| gallery(&figures, class))
    };
    let numerics = shown(Part::Numerics, "figures curves");
    let numerics = numerics.map(|figures| {
        html! { (figures) @if let Some(step) = &run.solves { (solves::table(step)) } }
    });
    let all = [
        ("measures", "Measures", (!run.case().measure.is_empty()).then(|| measures(run))),
        ("flow", "The flow", shown(Part::Fields, "figures fields")),
        ("particles", "Particles", shown(Part::Particles, "figures curves")),
        ("records", "Profiles and probes", shown(Part::Records, "figures curves")),
        ("scene", "The case in words", Some(scene(run))),
        ("numbers", "Reynolds numbers and others", Some(numbers(run))),
        (
            "needs",
            "What was needed and what was skipped",
            (!run.provenance.needs.is_empty()).then(|| needs(run)),
        ),
        ("numerics", "How well it was solved", numerics),
        ("cost", "Where the time went", run.summary.as_ref().map(|_| cost(run))),
        ("reproduce", "How to run it again", Some(reproduce(run))),
    ];
    all.into_iter().filter_map(|(id, title, body)| Some((id, title, body?))).collect()
}

/// Notes that a reader needs before the results: the warnings of the run, and those on its energy
/// at the end.
fn notes(run: &Run) -> Vec<&str> {
    let warnings = run.log.lines().filter(|line| line.starts_with("warning"));
    let mut all: Vec<&str> = Vec::new();
    for note in run.summary.iter().flat_map(|s| s.notes.iter().map(String::as_str)).chain(warnings)
    {
        // The log of a run that went on has them twice, and has the notes of the end too.
        if all.iter().all(|other| !note.ends_with(other)) {
            all.push(note);
        }
    }
    all
}

fn status(run: &Run) -> Markup {
    let class = match run.status() {
        "done" if notes(run).is_empty() => "chip good",
        "failed" => "chip bad",
        _ => "chip warn",
    };
    let verdicts: Vec<bool> = run.measures().into_iter().filter_map(|m| Some(m.2?.pass)).collect();
    let short = verdicts.iter().filter(|pass| !**pass).count();
    html! {
        span class=(class) { (run.status()) }
        @if !verdicts.is_empty() && run.summary.is_some() {
            @if short == 0 { span.chip.good { (verdicts.len()) " of " (verdicts.len())
                " references met" } }
            @else { span.chip.bad { (short) " of " (verdicts.len()) " fall short of their \
                references" } }
        }
    }
}

/// The case in a sentence.
fn lead(run: &Run) -> String {
    let particles = match run.case().particle.len() {
        0 => "no particles".into(),
        1 => "one particle".into(),
        n => format!("{n} particles"),
    };
    let cells =
        run.case().domain.cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" \u{d7} ");
    let start = run
        .provenance
        .start
        .as_deref()
        .unwrap_or("an unknown date")
        .replace('T', " ")
        .replace('Z', " UTC");
    format!(
        "{}D, {cells} cells, {particles}, to t = {} s; begun {start}.",
        run.case().dimension(),
        run.case().time.end
    )
}

fn tiles(run: &Run) -> Markup {
    let last = |name: &str| run.column(name).last().copied().unwrap_or(0.0);
    let time = run.summary.as_ref().map_or(last("time"), |s| s.time);
    let steps = run.summary.as_ref().map_or(last("step"), |s| s.steps as f64);
    let wall = run.summary.as_ref().map_or(last("wall"), |s| s.cost.wall_seconds);
    let divergence = run.column("divergence_max").iter().copied().fold(0.0, f64::max);
    let divergence = run.summary.as_ref().map_or(divergence, |s| s.divergence_max);
    let ranks = run.provenance.ranks;
    html! {
        dl.tiles {
            div { dt { "Time reached" } dd { (short(time)) " s "
                small { "of " (run.case().time.end) } } }
            div { dt { "Steps" } dd { (steps) } }
            div { dt { "Wall clock" } dd { (short(wall)) " s " small { "on " (ranks)
                @if ranks == 1 { " rank" } @else { " ranks" } } } }
            div { dt { "Largest |D|" } dd { (format!("{divergence:.1e}")) " " small { "of "
                (format!("{:e}", run.case().pressure.divergence_limit)) " 1/s" } } }
            @if let Some(s) = &run.summary {
                div { dt { "Krylov iterations" }
                    dd { (short(s.krylov_iterations as f64 / s.steps.max(1) as f64)) " "
                    small { "a step" } } }
                div { dt { "Peak memory" }
                    dd { (format!("{:.0}", s.cost.peak_memory_bytes / 1e6)) " "
                    small { "MB" } } }
            }
        }
    }
}

fn measures(run: &Run) -> Markup {
    let measures = run.measures();
    let kind = |m| what(run.case(), m);
    let compared = measures.iter().any(|m| m.2.is_some());
    html! {
        div.scroll { table {
            thead { tr {
                th { "measure" } th { "what" } th.number { "value" }
                @if compared { th.number { "reference" } th.number { "error" }
                    th.number { "tolerance" } th { } }
            } }
            tbody { @for (m, value, comparison) in &measures { tr {
                th scope="row" { (m.name) }
                td { (kind(m)) }
                td.number { @match value {
                    Some(v) => { (measured(*v)) " " (m.kind.unit(run.case().dimension())) }
                    None => "none"
                } }
                @if let Some(c) = comparison {
                    td.number { (c.reference.to_string()) }
                    td.number { @if let Some(difference) = c.difference() { (difference) } }
                    td.number { (percent(c.tolerance)) }
                    td { span class=(if c.pass { "chip good" } else { "chip bad" }) { (c.verdict())
                        } }
                } @else if compared { td { } td { } td { } td.soft { "no reference" } }
            } } }
        } }
        @if compared {
            p.soft { "An error is a part of the reference, of a band a part of its middle; a \
                tolerance reaches beyond a band's ends." }
            dl.terms { @for (m, _, c) in &measures { @if let Some(source)
                = c.as_ref().and_then(|c| c.source.as_ref()) {
                dt { (m.name) } dd { (source) }
            } } }
        }
    }
}

/// Describes a measure: its kind in the case's own word, of which body, along what and from when.
fn what(case: &mics_run::config::Case, m: &mics_run::config::Measure) -> String {
    let word = serde_json::to_value(m.kind)
        .ok()
        .and_then(|v| Some(v.as_str()?.replace('_', " ")))
        .unwrap_or_default();
    let wall = m.kind.is_of_group() && m.group().eq([m.particle.id()]);
    let particle = if m.kind.needs_particle() || wall {
        format!(" of {}", case.called(m.particle.id()))
    } else {
        String::new()
    };
    let direction = m.direction().map_or(String::new(), |direction| {
        let along = if m.kind == MeasureKind::Torque { "about" } else { "along" };
        let axis = (0..3).find(|a| direction[*a].abs() > 1.0 - 1e-9);
        let parts = direction.iter().take(case.dimension()).map(|part| short(*part));
        match axis {
            Some(a) if direction[a] > 0.0 => format!(" {along} {}", AXES[a]),
            Some(a) => format!(" {along} -{}", AXES[a]),
            None => format!(" {along} ({})", parts.collect::<Vec<_>>().join(", ")),
        }
    });
    let about = m.about.as_ref().map_or(String::new(), |about| {
        let parts: Vec<_> = about.iter().map(|part| short(*part)).collect();
        format!(" through ({}) m", parts.join(", "))
    });
    let axis = if m.kind.has_axis() { format!(" along {}", AXES[m.axis()]) } else { String::new() };
    let from = if m.from > 0.0 { format!(", from {} s on", m.from) } else { String::new() };
    word + &particle + &direction + &about + &axis + &from
}

/// An SVG text with a label for readers of the screen.
fn labelled(svg: &str, title: &str) -> String {
    let tag = format!("<svg role=\"img\" aria-label=\"{title}\" ");
    svg.replacen("<svg ", &tag, 1)
}

fn gallery(figures: &[&Figure], class: &str) -> Markup {
    html! { div class=(class) { @for f in figures {
        figure {
            h3 { (f.title) }
            (PreEscaped(labelled(&f.svg, f.title)))
            figcaption { (f.caption) }
        }
    } } }
}

fn scene(run: &Run) -> Markup {
    let case = run.case();
    let solved = [case.describe_time(), case.describe_pressure(&run.provenance.solver)];
    let lines = [case.describe_box(), case.describe_bodies(), solved.to_vec()].concat();
    html! { dl.terms { @for lines in lines.chunk_by(|one, next| one.label == next.label) {
        dt { (lines[0].label) } dd { @for line in lines { div { (line.words) } } }
    } } }
}

fn numbers(run: &Run) -> Markup {
    html! { div.scroll { table {
        thead { tr { th { "number" } th.number { "value" } th { "definition" } } }
        tbody { @for n in numbers::numbers(run) { tr {
            th.symbol scope="row" { (symbol(n.name)) } td.number { (short(n.value)) }
                td { (n.definition) }
        } } }
    } } }
}

/// `Re_p` with its index below the line, `delta` in Greek.
fn symbol(name: &str) -> Markup {
    let name = name.replace("delta", "\u{3b4}");
    let (base, rest) = name.split_once('_').unwrap_or((&name, ""));
    let end = rest.find('/').unwrap_or(rest.len());
    html! { (base) @if !rest.is_empty() { sub { (rest[..end]) } (rest[end..]) } }
}

fn needs(run: &Run) -> Markup {
    html! {
        p.soft { "A scene builds only what it needs; this is what " code { "mics check" }
            " says of it." }
        div.scroll { table { tbody {
            @for n in &run.provenance.needs { tr {
                td { span class=(if n.needed { "chip good" } else { "chip" })
                    { (if n.needed { "needed" } else { "skipped" }) } }
                th scope="row" { (n.what) } td { (n.why) }
            } }
            tr { td { span.chip.good { "needed" } } th scope="row" { "pressure solver" }
                td { (run.provenance.solver) } }
        } } }
    }
}

fn cost(run: &Run) -> Markup {
    let Some(summary) = &run.summary else { return html! {} };
    let stages: Vec<(&String, f64)> = summary
        .cost
        .stages_ns_per_cell_step
        .iter()
        .filter_map(|(name, ns)| Some((name, ns.as_f64()?)))
        .collect();
    let all: f64 = stages.iter().map(|s| s.1).sum();
    html! {
        div.scroll { table {
            thead { tr { th { "stage" } th.number { "ns per cell and step" } th.number { "share" }
                th.wide { } } }
            tbody {
                @for (name, ns) in &stages { tr {
                    th scope="row" { (name) } td.number { (format!("{ns:.1}")) }
                    td.number { (format!("{:.1} %", 100.0 * ns / all)) }
                    td.wide { span.share style=(format!("width:{:.2}%", 100.0 * ns / all)) { } }
                } }
                tr.sum { th scope="row" { "all" } td.number { (format!("{all:.1}")) } td { } td { }
                    }
            }
        } }
    }
}

fn reproduce(run: &Run) -> Markup {
    let p = &run.provenance;
    let command = p.command.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
    let ranks = if p.ranks > 1 { format!("mpirun -n {} ", p.ranks) } else { String::new() };
    let options =
        p.command.iter().position(|word| word == "--").map_or(&[][..], |at| &p.command[at..]);
    let options: String = options.iter().map(|word| format!(" {}", quoted(word))).collect();
    let toml = run.case().to_toml();
    html! {
        p { "Save the case below, which has every default written out, as " code { "case.toml" }
            ", build mics at the commit below, and run" }
        pre { (ranks) "mics run case.toml --out again" (options) }
        dl.terms {
            dt { "mics" } dd { (p.version) ", commit " code { (p.git_commit) } }
            dt { "Command" } dd { code { (ranks) (command) } }
            dt { "PETSc" } dd { (p.petsc_version) }
            dt { "PETSc options" } dd { code { (p.petsc_options.trim()) } }
            dt { "Ranks, machine" } dd { (p.ranks) " on " (p.host) }
            dt { "Begun, ended" } dd { (p.start.as_deref().unwrap_or("unknown")) ", "
                (p.end.as_deref().unwrap_or("not ended")) }
        }
        details { summary { "The case as run" } pre { (toml) } }
        @if !run.log.is_empty() { details { summary { "What it printed" } pre { (run.log) } } }
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// A number to four digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        1e4.. | ..1e-3 => format!("{value:.3e}"),
        size => {
            let digits = (3 - size.log10().floor() as i32).max(0) as usize;
            let text = format!("{value:.digits$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').into()
            } else {
                text
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn report_measure_has_particle_name() {
        let body = |more: &str| {
            format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = 0.2 }} }}\nposition = [{more}\n\
                density = 3.0\n"
            )
        };
        let measure = |name: &str, particle: usize| {
            format!(
                "[[measure]]\nname = \"{name}\"\nkind = \"terminal_velocity\"\n\
                particle = {particle}\n"
            )
        };
        let case = mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 2.0], cells = [8, 16] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
            }}\n{}{}{}{}",
            body("0.3, 0.5]\nname = \"stone\""),
            body("0.7, 0.5]"),
            measure("a", 0),
            measure("b", 1)
        ))
        .unwrap();
        let said: Vec<_> = case.measure.iter().map(|m| what(&case, m)).collect();
        assert!(said[0].ends_with(" of stone") && said[1].ends_with(" of particle 1"), "{said:?}");
    }

    #[test]
    fn report_digits_and_shell_quoting() {
        assert_eq!(
            [0.0, 100.0, 0.25, 1234.5, 3.14234, 5e-5, 2e6].map(short).join(" "),
            "0 100 0.25 1234 3.142 5.000e-5 2.000e6"
        );
        assert_eq!(
            ["--set", "a=[1, 2]", "it's", ""].map(quoted).join(" "),
            r"--set 'a=[1, 2]' 'it'\''s' ''"
        );
    }
}
