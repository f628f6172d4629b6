"""Compares numbers of the pages with fresh runs.

1. A table that a study makes stands below a line `<!-- mics study FILE -->`, one of a script below `<!-- cases/NAME/SCRIPT OPTIONS -->`
   (with --full only). Its columns are some of those of the study's study.md, in
   their order there. A number has moved where it differs by more than 0.5 % of itself, a percentage by more than 0.1; where the table of
   the page has other columns than there are, or other rows, that is said. --write writes these tables.
2. What is typed beside its command is in CLAIMS: the page's own words, with # for each number, and where these come from. A number has moved
   where it differs by more than 0.5 % of itself and by more than one of its last digit. Times and memory
   are not typed but in docs/cost.md. Words that are no longer in the page are a fault. --quick: those that take seconds; --full: those of studies of
   more than two minutes too.
3. Tests that pages name exist.

Not in here, and only as good as whoever typed them: numbers of offsets-32.study.toml (80 minutes), of scripts beside cases (they judge
themselves), of tests that print none (they hold them by their bounds), medians of `cargo bench`, and pages of cases outside such tables.
"""

import csv
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

MARK = re.compile(r"^<!-- (?:mics study )?(cases/\S+(?: --\S+)*) -->\n+((?:\|.*\n)+)", re.M)
NUMBER = r"([-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?)"


def words_with_numbers(words):
    """A pattern for words in which # is a number and a space any space."""
    return NUMBER.join(r"\s+".join(map(re.escape, part.split(" "))) for part in words.split("#"))


class Runs:
    """What commands print, each run once."""

    def __init__(self, mics, out):
        self.mics, self.out, self.done = mics, out, {}

    def once(self, key, make):
        if key not in self.done:
            self.done[key] = make()
        return self.done[key]

    def study(self, file):
        """The folder of a study; runs that are done are kept."""
        folder = self.out / file.replace("/", "-").removesuffix(".study.toml")
        call = lambda: subprocess.run([self.mics, "study", file, "--out", folder], check=True, stdout=subprocess.DEVNULL)
        self.once(file, call)
        return folder

    def script(self, command):
        """What a script beside a case prints."""
        words = command.split()
        out = self.out.absolute() / re.sub(r"[^\w.-]+", "-", command)
        call = lambda: subprocess.run([words[0], out, *words[1:]], capture_output=True, text=True, env={**os.environ, "MICS": str(self.mics)}).stdout
        return self.once(command, call)

    def rows(self, file):
        """A study's rows, numbers as numbers."""
        return [{name: number(text) for name, text in row.items()} for row in table(self.study(file) / "study.csv")]

    def run(self, case, *settings):
        """The folder of a run of cases/CASE.toml."""
        folder = self.out / "runs" / re.sub(r"[^\w.-]+", "-", " ".join([case, *settings]))
        words = [self.mics, "run", f"cases/{case}.toml", "--quiet", "--force", "--out", folder, "--set", "output.figures=false"]
        words += [word for given in settings for word in ("--set", given)]
        self.once(folder, lambda: subprocess.run(words, check=True, stdout=subprocess.DEVNULL))
        return folder

    def summary(self, case, *settings):
        return json.loads((self.run(case, *settings) / "summary.json").read_text())

    def test(self, name):
        """What the tests whose names contain this print."""
        words = ["cargo", "test", "--release", "--quiet", "--test", "suite", name, "--", "--nocapture"]
        return self.once(name, lambda: subprocess.run(words, check=True, capture_output=True, text=True).stdout)


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def table(path):
    """The rows of a CSV file."""
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def method_loss(case, *settings):
    """The energy that the method took, in percent of what was there and went in."""

    def find(runs):
        last = {name: float(text) for name, text in table(runs.run(case, *settings) / "steps.csv")[-1].items()}
        first = table(runs.run(case, *settings) / "steps.csv")[0]
        works = ["gravity_work", "border_work", "prescribed_work", "drive_work"]
        given = float(first["kinetic_energy"]) + sum(max(0.0, last.get(name, 0.0)) for name in works)
        return [100 * last["method_loss"] / given]

    return find


def chosen_rows(runs, study, labels):
    rows = [row for row in runs.rows(study) if all(row[name] == value for name, value in labels.items())]
    if not rows:
        raise LookupError(f"{study} has no run with {labels}")
    return rows


def of_each(study, column, scale=1.0, **labels):
    """A column of a study's runs with these labels, in their order."""
    return lambda runs: [scale * row[column] for row in chosen_rows(runs, study, labels)]


def worst(study, measure, **labels):
    """The worst error of a measure over a study's runs with these labels, in percent."""
    return lambda runs: [100 * max((row[f"{measure}_error"] for row in chosen_rows(runs, study, labels)), key=abs)]


def extremes(study, column, scale=1.0, **labels):
    """The least and the largest of a column."""
    return lambda runs: [scale * pick(row[column] for row in chosen_rows(runs, study, labels)) for pick in (min, max)]


def spread(study, measure, last=4, **labels):
    """Least, largest, and worst and mean error (percent) of a measure, or the last so many of these."""

    def find(runs):
        errors = [100 * row[f"{measure}_error"] for row in chosen_rows(runs, study, labels)]
        return (extremes(study, measure, **labels)(runs) + [max(errors, key=abs), sum(errors) / len(errors)])[-last:]

    return find


def lattice(runs):
    """The error of the drag of each lattice of spheres, by the gradient, at N = 16 against Zick & Homsy, in percent."""
    known = [(float(row["phi"]), float(row["K"])) for row in table("cases/sphere-array/sphere_arrays.csv")]
    errors = []
    for phi, k in known:
        row = min((row for row in runs.rows(ARRAYS) if abs(row["phi"] - phi) < 1e-3), key=lambda row: abs(row["N"] - 16))
        diameter, speed = (6 * phi / math.pi) ** (1 / 3), 0.01
        errors.append(100 * (row["gradient"] / (3 * math.pi * diameter * speed * k) - 1))
    return errors


def order_and_limit(phi):
    """Order of the error of the drag of that lattice and limit of K, by the gradient on the three finest grids of its study."""

    def find(runs):
        rows = sorted(chosen_rows(runs, FINE_ARRAYS, {"phi": phi}), key=lambda row: row["N"])[-3:]
        diameter, speed = (6 * phi / math.pi) ** (1 / 3), 0.01
        (a, ka), (b, kb), (c, kc) = [(row["N"], row["gradient"] / (3 * math.pi * diameter * speed)) for row in rows]
        excess = lambda p: (ka - kb) * (b**-p - c**-p) - (kb - kc) * (a**-p - b**-p)
        low, high = 0.1, 8.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if excess(low) * excess(middle) > 0 else (low, middle)
        return [low, kc - (kb - kc) / (b**-low - c**-low) * c**-low]

    return find


def error(case, measure, *settings):
    """A measure's difference from the case's reference, in percent."""
    return lambda runs: [100 * runs.summary(case, *settings)["comparisons"][measure]["error"]]


def measured(measure, case, *settings):
    return lambda runs: [runs.summary(case, *settings)["measures"][measure]]


def printed(test, pattern):
    """The numbers that a test prints where the pattern, with # for each, is, line by line."""
    regex = re.compile(words_with_numbers(pattern))
    return lambda runs: [float(text) for found in regex.finditer(runs.test(test)) for text in found.groups()]


def set_off(runs):
    """How far the first acceleration of discs of all densities is from theory at worst on 8, 16, 32 cells, in percent."""
    test = "set_off_with"
    eight = printed(test, "a/g #, # % of")(runs)[1::2]
    finer = printed(test, "# % on 16 cells, # % on 32")(runs)
    return [max(map(abs, values)) for values in (eight, finer[::2], finer[1::2])]


def pick(part, *places):
    """The numbers at these places of what a part finds."""

    def find(runs):
        found = part(runs)
        return [found[place] for place in places]

    return find


def excess(part):
    """Ratios as percentages over 1."""
    return lambda runs: [100 * (value - 1) for value in part(runs)]


def beside_symmetry_plane(runs):
    """How much less a disc spins beside a plane of symmetry than in its pair, in percent: gaps of 0.01 and 0.1 d at N = 8, 0.01 d at N = 16."""
    rows = printed("disc_beside_symmetry_plane", "# rad/s and # m/s, # and # in the pair")(runs)
    return [100 * (1 - spin / pair) for spin, pair in zip(rows[::4], rows[2::4])]


def multigrid(runs):
    """The most iterations of the multigrid with free bodies: s = 0.1 and more, and with 8 cells a diameter at s = 0.01 and at 0.001."""
    rows = printed("multigrid", "s = #, N = #: [#, #]")(runs)
    rows = list(zip(*(rows[k::4] for k in range(4))))
    most = lambda some: max(max(row[2:]) for row in rows if some(row))
    return [most(lambda row: row[0] >= 0.1), *(most(lambda row: row[:2] == (s, 8)) for s in (0.01, 0.001))]


def krylov_a_step(case, *settings):
    """Linear iterations a step."""

    def find(runs):
        rows = table(runs.run(case, *settings) / "steps.csv")
        return [sum(float(row["krylov_iterations"]) for row in rows) / (len(rows) - 1)]

    return find


def bytes_a_cell(case, pattern, *settings):
    """The size of the newest file of a run over its cells."""

    def find(runs):
        files = sorted(runs.run(case, *settings).glob(pattern))
        return [files[-1].stat().st_size / runs.summary(case, *settings)["cells"]]

    return find


def false_lift(re, n):
    """The mean lift coefficient of the cylinder with its centre 3/8 of a spacing off the middle."""
    settings = [f"fluid.viscosity={200 / re}", f"particle.0.position=[0.8,{0.8 + 0.375 * 0.2 / n}]", "time.end=40.0",
                f"domain.cells=[{20 * n},{8 * n}]", 'measure=[{name="lift",kind="lift_coefficient",from=20.0}]']
    return size(measured("lift", WAKE, *settings))


def both(*parts):
    return lambda runs: [value for part in parts for value in part(runs)]


def size(part):
    return lambda runs: [abs(value) for value in part(runs)]


def scaled(scale, part):
    return lambda runs: [scale * value for value in part(runs)]


def in_percent(part):
    return scaled(100, part)


def settles(re, column):
    """A column of settling-sphere's runs at N = 8.1, in percent of the reference."""
    return of_each(OILS, column, 100.0, Re=re, N=8.1)


def let_go(column):
    return both(*(of_each(LET_GO, column, 100.0, s=s, N=8, dt="t/20", place="corner of cells") for s in (0.001, 0.1, 1.5, 8, 1000)))


def mixed(re, *columns):
    """The cells of the table of section3.study.toml: a drag and its error for each of these, or the frequency and its."""
    parts = [(of_each(MIXED, column, Re=re), of_each(MIXED, column + "_error", 100.0, Re=re)) for column in columns]
    return both(*(part for pair in parts for part in pair))


README, ENERGY, MEASURED, MIXTURE = "README.md", "docs/output.md", "docs/measured.md", "docs/mixture.md"
LIMITS, CHOOSING, PETSC, RESTART = "docs/limits.md", "docs/choosing.md", "docs/petsc.md", "docs/restart.md"
MIXING, SORTING, SPHERE = 'coupling.wall="mixing"', "size-sorting/case", "sphere-stream/case"
IN_TIME, SWINGS = "rk#: #, #, observed order in time #", "rkl2: observed orders of the flow [#, #], force [#, #], impulse [#, #]"
WAKE, SETTLING, N16 = "cylinder-wake/case", "settling-disc/case", "domain.cells=[128,384]"
OFFSETS, FINER = "cases/cylinder-wake/offsets.study.toml", "cases/cylinder-wake/offsets-16.study.toml"
MIXED, SHEARED = "cases/cylinder-wake/section3.study.toml", "cases/sphere-in-couette/walls.study.toml"
OILS, LET_GO = "cases/settling-sphere/numbers.study.toml", "cases/sphere-let-go/densities.study.toml"
ARRAYS, RANDOM = "cases/sphere-array/fractions.study.toml", "cases/random-array/equilibrium.study.toml"
FINE_ARRAYS = "cases/sphere-array/order.study.toml"
PLACES, NOISE = "cases/sphere-stream/places.study.toml", "cases/translating-disc/noise.study.toml"
QUICK, SLOW, LONG = range(3)
DRAG, EIGHT = "drag_coefficient", "at eight places within a cell"

# When it is run (see main), the page, its words with # for each number, and what finds these.
CLAIMS = [
    (QUICK, README, "| largest speed of a settling disc, 8 cells a diameter | within # % |", size(error(SETTLING, "largest_speed"))),
    (QUICK, README, "beside potential flow | within #, #, # % on 8, 16, 32 cells a diameter |", set_off),
    (LONG, README, f"{EIGHT} | within # % |", size(worst(FINER, DRAG))),
    (LONG, README, "| speed of settling spheres as measured, Re = 1.5 to 32, 8 cells a diameter | within # % |", size(worst(OILS, "largest_speed", N=8.1))),
    (SLOW, ENERGY, "| lid-driven-cavity, 8,000 steps | # % |", method_loss("lid-driven-cavity/case")),
    (QUICK, ENERGY, "| cylinder-wake, Re 100, N = 8 | # % |", method_loss(WAKE)),
    (SLOW, ENERGY, "| settling-disc, N = 8; N = 16 | # %; # % |", both(method_loss(SETTLING), method_loss(SETTLING, N16))),
    (SLOW, ENERGY, "| drafting-kissing-tumbling | # % |", method_loss("drafting-kissing-tumbling/case")),
    (SLOW, ENERGY, "| wall-fall, N = 24 | # %:", method_loss("wall-fall/case")),
    (SLOW, ENERGY, "| crowd | # % |", method_loss("crowd/case")),
    (QUICK, ENERGY, "| size-sorting | # %:", method_loss("size-sorting/case")),
    (SLOW, ENERGY, "| steel-in-air | # % |", method_loss("steel-in-air/case")),
    (QUICK, ENERGY, "Settling with the mixture method is # %.", method_loss(SETTLING, 'coupling.wall="mixing"')),
    (QUICK, ENERGY, "the method takes # % on 24 cells, # % on 48.", in_percent(printed("decaying_vortices", "takes [#, #] of the start"))),
    *((LONG, MEASURED, f"| {re} | # ... # | # % | # % |", spread(OFFSETS, DRAG, Re=re)) for re in (10, 20, 40, 100, 200)),
    *((LONG, MEASURED, f"| {re} | #, # % | #, # % |", both(spread(OFFSETS, DRAG, 2, Re=re), spread(FINER, DRAG, 2, Re=re))) for re in (40, 100)),
    *((SLOW, MIXTURE, f"| {re} | {step} | # | # % | # | # % |", mixed(re, DRAG, "drag_coefficient_eq19"))
      for re, step in ((10, 0.199), (20, 0.252), (40, "0.240"), (100, 0.219), (200, 0.198))),
    *((SLOW, MIXTURE, f"| {drag} | # | # % | {reference} |", mixed(re, "strouhal")) for re, drag, reference in ((100, 1.5576, 0.1849), (200, "1.5130", 0.2122))),
    (LONG, MEASURED, "| #, #, #, # %; at N = 12 #", both(*(settles(re, "largest_speed_error") for re in (1.5, 4.1, 11.6, 31.9)),
                                                        of_each(OILS, "largest_speed_error", 100.0, Re=1.5, N=12))),
    (LONG, MEASURED, "spin of G/2 | # and # % at two places", in_percent(of_each(SHEARED, "spin_error", gap="6 d", Re_G=0.1))),
    (SLOW, MEASURED, "against Boussinesq-Basset | #, #, #, #, # %; #, #, #, #, # %; #, #, #, #, # % |",
     both(let_go("v_first_error"), let_go("v_half_error"), let_go("v_error"))),
    (LONG, MEASURED, "| # to # % at five places within a cell |", extremes(PLACES, "drag_coefficient_error", 100.0)),
    (LONG, MEASURED, "of K (15.4, 42.1) | # and #; # and # |", both(order_and_limit(0.343), order_and_limit(0.5236))),
    (LONG, MEASURED, "by two correlations | #, #, #; #, #, # |", both(of_each(RANDOM, "drag", 1 / 1.55083, phi=0.2, N=10), of_each(RANDOM, "drag", 1 / 1.95392, phi=0.4, N=10))),
    (SLOW, MEASURED, "against Zick & Homsy, N = 16 | #, #, #, #, # %,", lattice),
    (SLOW, README, "up to spheres that touch, 16 cells a diameter | within # % |", lambda runs: [max(map(abs, lattice(runs)))]),
    (QUICK, MEASURED, "| Taylor-Green vortex carried by a stream | order #, # (24^2", printed("taylor_green", "orders #, #")),
    (QUICK, MEASURED, "energy at t = 1 | # in # steps of rk2 |", pick(printed("vortex", "rk2: # in # steps, off by #"), 2, 1)),
    (QUICK, MEASURED, "| advection alone, in space | order # (2 where",
     pick(printed("fifth_order_in_space", "conservative, vortex in a stream: [#, #, #], order #"), 3)),
    (QUICK, MEASURED, "| in time, 128^2 | rk2 #, rk3 # |", pick(printed("first_order_in_time", IN_TIME), 3, 7)),
    (QUICK, MEASURED, "times the limit of rk2 | order #; impulse on a swinging disc #, # |",
     both(pick(printed("legendre_stages", "rkl2: errors #, #, #, order in time #"), 3), pick(printed("time_order", SWINGS), 4, 5))),
    (QUICK, MEASURED, "| pressure across a density jump of 1000 | order #, #, # |", printed("poisson", "orders [#, #, #]")),
    (QUICK, MEASURED, "| torque on a disc that is spun up | # % at N = 8, # % at 16 |",
     pick(printed("spun_up", "N = #: torque #, exact #, # %"), 3, 7)),
    (QUICK, MEASURED, "gaps of 0.2, 0.1 radii, N = 8; 0.1, N = 16 | #, #; # % |",
     excess(pick(printed("over_sliding_wall_has_stokes_drag", "gap # radii, # cells: # of the exact force"), 2, 5, 8))),
    (QUICK, MEASURED, "| # % of the drag (rms) at cfl 0.4, # % at 0.05 |", of_each(NOISE, "noise", 100.0)),
    (SLOW, MEASURED, "is #, #, #, # at `cfl` 0.05, 0.2, 0.8, 1.1, and at Re 100 #, #, #, #",
     both(*(measured(DRAG, WAKE, f"fluid.viscosity={viscosity}", f"time.cfl={cfl}") for viscosity in (5.0, 2.0) for cfl in (0.05, 0.2, 0.8, 1.1)))),
    (SLOW, MEASURED, "14.06, 17.78 mm at N = 137 | #, # at N = 24;",
     both(*(scaled(1e3, measured(f"x_at_{y}_mm", "wall-fall/case")) for y in (75, 60)))),
    (QUICK, LIMITS, "surface speed # % of its fall at N = 8, # % at 16", printed("falls_off_the_middle", "turns with # and # % of")),
    (QUICK, LIMITS, "gap 0.01 d: # % at N = 8, # % at 16; 0.1 d: # %", pick(beside_symmetry_plane, 0, 2, 1)),
    (SLOW, LIMITS, "lift coefficient # at Re = 100 with N = 8, # with 12, # with 16; # at Re = 40 with 8",
     both(false_lift(100, 8), false_lift(100, 12), false_lift(100, 16), false_lift(40, 8))),
    (QUICK, CHOOSING, "# a step in `size-sorting`, where 1e-4 takes #.",
     both(krylov_a_step(SORTING, "pressure.divergence_limit=1e-6"), krylov_a_step(SORTING, "pressure.divergence_limit=1e-4"))),
    (QUICK, PETSC, "takes at most # iterations to 1e-8 for s = 0.1 to 1e4 on any grid. Packed free discs of 8 cells take # at s = 0.01 and # at 0.001",
     multigrid),
    (QUICK, RESTART, "# bytes a cell in 2D, # in 3D",
     both(bytes_a_cell(SETTLING, "checkpoint/*"), bytes_a_cell(SPHERE, "checkpoint/*", "time.end=0.05", "measure=[]"))),
    (QUICK, ENERGY, ", # bytes a cell in 2D, # in 3D, 8 more where density varies",
     both(bytes_a_cell(SETTLING, "fields/0*.vti"), bytes_a_cell(SPHERE, "fields/0*.vti", "time.end=0.05", "measure=[]"))),
    (QUICK, MIXTURE, "| measured | # | # | # | # | # | # | # | # | # |", printed("set_off_stably", "a/g #, (s-1)/(s+1)")),
    (SLOW, MIXTURE, "kiss at 0.17 s | # s |", measured("kiss", "drafting-kissing-tumbling/case", MIXING)),
    (SLOW, MIXTURE, "5.575 cm/s | #, #, # at N = 8, 16, 24 |",
     both(*(measured("largest_speed", SETTLING, 'coupling.wall="mixing"', *cells) for cells in ((), (N16,), ("domain.cells=[192,576]",))))),
]


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def fresh(runs, source):
    """Header and rows of a study's study.md, or of the first table that a script prints."""
    text = (runs.study(source) / "study.md").read_text() if source.endswith(".toml") else runs.script(source)
    first = re.search(r"(?:^\|.*\n)+", text, re.M)
    header, _, *rows = first[0].splitlines() if first else ["||", ""]
    return cells(header), [cells(row) for row in rows]


def chosen(wanted, there):
    """Where the wanted columns are among those that are there, in order."""
    places, at = [], 0
    for name in wanted:
        at = there.index(name, at)
        places.append(at)
        at += 1
    return places


def moved(old, new):
    if old == new:
        return False
    try:
        a, b = (float(text.removesuffix(" %")) for text in (old, new))
    except ValueError:
        return True
    # What is zero but for rounding is as good as any other such number.
    return abs(a - b) > (0.1 if old.endswith("%") else max(0.005 * abs(a), 1e-9))


def compare_tables(runs, some, write, scripts):
    """How many tables of studies, and of scripts if wanted, there are in the pages of cases, and what has moved in them."""
    news, count = [], 0
    for page in sorted(Path("cases").glob("*/README.md")):
        text = page.read_text()
        for match in list(MARK.finditer(text)):
            study, lines = match[1], match[2].splitlines()
            if (some and study not in some) or not (scripts or study.endswith(".toml")):
                continue
            count += 1
            there, rows = fresh(runs, study)
            wanted = cells(lines[0])
            try:
                places = chosen(wanted, there)
            except ValueError as error:
                news.append(f"{page}: {study} has no such column: {error}")
                continue
            now = [[row[place] for place in places] for row in rows]
            before = [cells(line) for line in lines[2:]]
            if len(now) != len(before):
                news.append(f"{page}: {study} has {len(now)} rows, the page {len(before)}")
            for old, new in zip(before, now):
                differ = [f"{name} {b}, was {a}" for name, a, b in zip(wanted, old, new) if moved(a, b)]
                if differ:
                    news.append(f"{page}: {study}, {', '.join(old[:2])}: {'; '.join(differ)}")
            if write:
                made = lines[:2] + ["| " + " | ".join(row) + " |" for row in now]
                text = text.replace(match[2], "\n".join(made) + "\n")
        if write:
            page.write_text(text)
    return count, news


def off(text, value):
    """Whether a typed number is another than this one, by more than 0.5 % and more than one of its last digit."""
    digits = re.fullmatch(r"[-+]?[\d,]+(?:\.(\d+))?(?:e([-+]?\d+))?", text)
    last = 10.0 ** (int(digits[2] or 0) - len(digits[1] or ""))
    typed = float(text.replace(",", ""))
    return abs(typed - value) > max(0.005 * abs(typed), 1.01 * last)


def compare_claims(runs, some, most):
    """How many claims there are that take no longer than this, and what has moved in them."""
    news, count = [], 0
    for when, page, words, find in CLAIMS:
        if (some and page not in some) or when > most:
            continue
        count += 1
        found = list(re.finditer(words_with_numbers(words), Path(page).read_text()))
        if len(found) != 1:
            news.append(f"{page}: `{words}` is there {len(found)} times")
            continue
        try:
            values = find(runs)
        except (LookupError, TypeError, subprocess.CalledProcessError) as error:
            news.append(f"{page}: {found[0][0]}: {error!r}")
            continue
        typed = found[0].groups()
        said = f"{page}: `{found[0][0]}`: found {', '.join(f'{value:.5g}' for value in values)}"
        if len(typed) != len(values) or any(map(off, typed, values)):
            news.append(said)
        print(said, flush=True)
    return count, news


def missing_tests():
    """Names of tests, or parts of them, that pages quote and no test has."""
    names = []
    for path in sorted([*Path("tests").rglob("*.rs"), *Path("src").rglob("*.rs"), *Path("crates").rglob("*.rs")]):
        names += [f"{path.stem}::{name}" for name in re.findall(r"#\[test\]\n(?:\s*(?:#\[|//).*\n)*\s*fn (\w+)", path.read_text())]
    news = []
    for page in [Path(README), *sorted(Path("docs").glob("*.md")), *sorted(Path("cases").glob("*/README.md"))]:
        text = page.read_text()
        quoted = re.findall(r"`([\w:]+)`", " ".join(re.findall(r"\btests?\s+(?:NAME\s+)?((?:`[\w:]+`(?:,\s+|\s+and\s+)?)+)", text)))
        quoted += re.findall(r"--test\s+suite\s+([a-z_:0-9]+)", text)
        news += [f"{page}: no test has `{name}` in its name" for name in quoted if not any(name in test for test in names)]
    return news


def main(mics, out, options):
    flags = {"--write", "--quick", "--full"} & set(options)
    some = [name for name in options if name not in flags]
    runs = Runs(mics, out)
    tables, news = (0, []) if "--quick" in flags else compare_tables(runs, some, "--write" in flags, "--full" in flags)
    if "--write" in flags:
        print(f"{tables} tables written, {len(news)} rows had moved", *news, sep="\n")
        return 0 if tables else 1
    claims, more = compare_claims(runs, some, QUICK if "--quick" in flags else LONG if "--full" in flags else SLOW)
    news += more + missing_tests()
    print(f"\n{tables} tables and {claims} claims, {len(news)} have moved", *news, sep="\n")
    return 1 if tables + claims == 0 or news else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:]))
