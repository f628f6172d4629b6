//! Ways to break a good case: its text, keys, ranges and contradictions, drives and measures of the
//! box.

/// A way to break the good case: the text to replace, its replacement, the text that the line named
/// must begin with (empty: no line is named), the key named, and what else the message must say.
pub type Row = (&'static str, &'static str, &'static str, &'static str, &'static [&'static str]);

/// Message on keys that once were choices of the paper's method.
const AS_PRINTED: &[&str] =
    &["wall = \"mixing\" is the paper's method as printed", "no choices", "leave this key out"];

#[rustfmt::skip]
pub const BAD_KEYS: &[Row] = &[
    // Measures of the box.
    (
        "kind = \"drag_coefficient\"",
        "kind = \"solid_fraction\"\nregion = { min = [0.0, 0.0], max = [0.01, 1.0] }", "region",
        "measure.0.region", &["no centre of a cell"],
    ),
    (
        "[time]", "[contact]\nrolling_friction = 2.0\n[time]", "rolling_friction",
        "contact.rolling_friction", &["at most 1"],
    ),
    ("[time]", "[initial]\nfrom = \"nowhere\"\n[time]", "from", "initial.from", &["holds no run"]),
    ("[time]", "[statistics]\nfrom = 1.0\n[time]", "from", "statistics.from", &["before"]),
    (
        "[time]", "[[probe]]\nname = \"a\"\nat = [9.0, 0.0]\n[time]", "at", "probe.0.at.0",
        &["outside"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\naxis = \"x\"", "axis",
        "measure.0.axis", &["flow_rate"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"flow_rate\"\naxis = \"z\"", "axis",
        "measure.0.axis", &["3D only"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drive_force\"", "kind", "measure.0.kind",
        &["[drive]"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"bed_height\"", "kind", "measure.0.kind",
        &["fluid.gravity"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"force\"\nparticles = [\"pier\"]", "particles",
        "measure.0.particles.0", &["no particle has the name \"pier\""],
    ),
    (
        "kind = \"drag_coefficient\"",
        "kind = \"solid_fraction\"\nregion = { min = [0.0, 0.0], max = [0.0, 1.0] }", "region",
        "measure.0.region", &["above its min"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nabout = [0.0, 0.0]", "about",
        "measure.0.about", &["is of torque only"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"torque\"\nabout = [0.0]", "about",
        "measure.0.about", &["2"],
    ),
    // The drive.
    (
        "[time]", "[drive]\nforce = [1.0, 0.0]\ngravity = true\n[time]", "[drive]", "drive",
        &["found `force` and `gravity`", "exactly one of `force`, `gravity`, `mean_velocity`"],
    ),
    ("[time]", "[drive]\n[time]", "[drive]", "drive", &["found none", "exactly one of"]),
    ("[time]", "[drive]\nforce = [1.0]\n[time]", "force", "drive.force", &["2"]),
    (
        "[time]", "[drive]\nmean_velocity = { axis = \"x\", value = 1.0 }\n[time]", "mean_velocity",
        "drive.mean_velocity.axis", &["x is not periodic"],
    ),
    (
        "[time]", "[drive]\nmean_velocity = { axis = \"z\", value = 1.0 }\n[time]", "mean_velocity",
        "drive.mean_velocity.axis", &["3D only"],
    ),
    ("[time]", "[drive]\ngravity = true\n[time]", "gravity", "drive.gravity", &["fluid.gravity"]),
    (
        "[time]", "[drive]\nhold_mixture = true\n[time]", "hold_mixture", "drive.hold_mixture",
        &["drive.mean_velocity = {"],
    ),
    // The text itself.
    ("end = 0.1", "end = ", "end =", "", &["not valid TOML"]),
    ("[time]", "[time", "[time", "", &["not valid TOML", "`]`"]),
    ("density = 1.0", "density = 1.0\ndensity = 2.0", "density = 2.0", "", &["duplicate key \
        `density`", "keep one of them"]),
    ("end = 0.1", "end = 0,1", "end = 0,1", "", &["end: `0,1` has a comma where a number has a \
        point: end = 0.1"]),
    ("end = 0.1", "end = .1", "end = .1", "", &["end: `.1` needs a digit on both sides of its \
        point: end = 0.1"]),
    (
        "viscosity = 0.1", "viscosity = 0.1 Pa s", "viscosity", "",
        &["words behind the number", "viscosity = 0.1"],
    ),
    ("viscosity = 0.1", "viscosity 0.1", "viscosity", "", &["`viscosity 0.1` has no `=`"]),
    (
        "name = \"small\"", "name = small", "name", "",
        &["name: text needs quotes: name = \"small\""],
    ),
    // Unknown, missing and mistyped keys.
    (
        "viscosity = 0.1", "viscosty = 0.1", "viscosty", "fluid.viscosty",
        &["unknown key `viscosty`", "did you mean `viscosity`?"],
    ),
    (
        "viscosity = 0.1", "colour = 0.1", "colour", "fluid.colour",
        &["unknown key `colour`", "`density`, `viscosity`, `gravity`"],
    ),
    ("[pressure]", "[presure]", "[presure]", "presure", &["did you mean `pressure`?"]),
    ("diameter = 0.2", "diametr = 0.2", "shape", "particle.0.shape.disc.diametr", &["did you mean \
        `diameter`?"]),
    // Keys of earlier versions.
    (
        "[time]", "[coupling]\nfraction = \"exact\"\n[time]", "fraction",
        "coupling.fraction", AS_PRINTED,
    ),
    (
        "[time]", "[coupling]\nforce = \"momentum\"\n[time]", "force",
        "coupling.force", AS_PRINTED,
    ),
    (
        "[time]", "[coupling]\nrotation = \"all\"\n[time]", "rotation",
        "coupling.rotation", AS_PRINTED,
    ),
    (
        "[time]", "[coupling]\nmix_pressure = true\n[time]", "mix_pressure",
        "coupling.mix_pressure", AS_PRINTED,
    ),
    (
        "[time]", "[coupling]\nbuoyancy = \"faces\"\n[time]", "buoyancy",
        "coupling.buoyancy", AS_PRINTED,
    ),
    (
        "[time]", "[coupling]\ngradient = \"cells\"\n[time]", "gradient",
        "coupling.gradient", AS_PRINTED,
    ),
    ("cfl = 0.4", "upwinding = 0.5", "upwinding", "time.upwinding", &["leave it out"]),
    (
        "cfl = 0.4", "advection = \"upwind5-advective\"", "advection", "time.advection",
        &["did you mean `upwind5`?"],
    ),
    ("cfl = 0.4", "max_stages = 2", "max_stages", "time.max_stages", &["3 to 50 stages"]),
    (
        "cfl = 0.4", "scheme = \"rk2\"\nmax_stages = 6", "max_stages", "time.max_stages",
        &["only time.scheme = \"rkl2\" and \"rkl3\""],
    ),
    (
        "cfl = 0.4", "scheme = \"rk4\"", "scheme", "time.scheme",
        &["unknown value `rk4`", "did you mean `rk"],
    ),
    (
        "divergence_limit = 1.0e-6", "solver = \"direct\"", "solver", "pressure.solver",
        &["unknown value `direct`", "`multigrid`"],
    ),
    (
        "divergence_limit = 1.0e-6", "solver = \"magic\"", "solver", "pressure.solver",
        &["unknown value `magic`", "`bcgs-boomeramg`"],
    ),
    ("east = \"outflow\"", "east = \"outlow\"", "east", "boundary.east", &["did you mean \
        `outflow`?"]),
    (
        "{ inflow = [1.0, 0.0] }", "{ inflw = [1.0, 0.0] }", "west", "boundary.west.inflw",
        &["did you mean `inflow`?"],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "\"inflow\"", "west", "boundary.west",
        &["`inflow` needs its value"],
    ),
    (
        "east = \"outflow\"", "east = { outflow = 1.0 }", "east", "boundary.east.outflow",
        &["takes no value", "write \"outflow\""],
    ),
    ("east = \"outflow\"", "east = 3", "east", "boundary.east", &["the number 3", "wanted a name \
        in quotes"]),
    (
        "{ disc = { diameter = 0.2 } }", "{ disk = { diameter = 0.2 } }", "shape",
        "particle.0.shape.disk", &["did you mean `disc`?"],
    ),
    (
        "{ disc = { diameter = 0.2 } }", "{ disc = { diameter = 0.2 } }\nname = \"a\\u0007b\"",
        "name", "particle.0.name", &["control character"],
    ),
    ("kind = \"drag_coefficient\"", "kind = \"drag\"", "kind", "measure.0.kind", &["did you mean \
        `drag_coefficient`?"]),
    (
        "viscosity = 0.1\n", "", "[fluid]", "fluid.viscosity",
        &["missing key `viscosity` in [fluid]"],
    ),
    ("[time]\nend = 0.1\ncfl = 0.4\n", "", "", "time", &["missing key `time`", "top level"]),
    ("viscosity = 0.1", "viscosity = \"thick\"", "viscosity", "fluid.viscosity", &["the text \
        \"thick\"", "wanted a number"]),
    ("size = [2.0, 1.0]", "size = 2.0", "size", "domain.size", &["wanted a list"]),
    (
        "cells = [32, 16]", "cells = [32.5, 16]", "cells", "domain.cells.0",
        &["the number 32.5", "wanted a whole number"],
    ),
    (
        "cells = [32, 16]", "cells = [-32, 16]", "cells", "domain.cells.0",
        &["the number -32", "wanted a whole number"],
    ),
    ("[fluid]", "[[fluid]]", "[[fluid]]", "fluid", &["found a list", "wanted a table", "[fluid]"]),
    ("[time]", "[[time]]", "[[time]]", "time", &["found a list", "wanted a table", "[time]"]),
    ("[[measure]]", "[measure]", "[measure]", "measure", &["found a table", "[[measure]]"]),
    // Values out of range.
    ("name = \"small\"", "name = \"../small\"", "name", "name", &["letters, digits"]),
    (
        "density = 1.0", "density = -1.0", "density", "fluid.density",
        &["must be positive", "kg/m3", "-1.0"],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "{ inflow = [-1e300, 0.0] }", "west", "boundary.west.inflow.0",
        &["beyond 1e30", "look at its exponent"],
    ),
    (
        "density = 1.0", "density = nan", "density", "fluid.density",
        &["must be positive and finite", "NaN"],
    ),
    ("density = 1.0", "density = 1e300", "density", "fluid.density", &["beyond 1e30", "look at its \
        exponent"]),
    ("viscosity = 0.1", "viscosity = -0.1", "viscosity", "fluid.viscosity", &["must be zero or \
        positive", "Pa s"]),
    ("viscosity = 0.1", "viscosity = inf", "viscosity", "fluid.viscosity", &["finite"]),
    (
        "viscosity = 0.1", "viscosity = 0.1\ngravity = [0.0, nan]", "gravity", "fluid.gravity.1",
        &["finite", "m/s2"],
    ),
    (
        "viscosity = 0.1", "viscosity = 0.1\ngravity = [-9.81]", "gravity", "fluid.gravity",
        &["a 2D case needs 2 numbers", "not 1"],
    ),
    (
        "size = [2.0, 1.0]", "size = [2.0, -1.0]", "size", "domain.size.1",
        &["must be positive", "-1.0"],
    ),
    ("size = [2.0, 1.0]", "size = [2.0, nan]", "size", "domain.size.1", &["must be positive and \
        finite"]),
    ("size = [2.0, 1.0]", "size = [2.0]", "size", "domain.size", &["2 numbers (m) for a 2D case or \
        3 for a 3D one", "not 1"]),
    ("cells = [32, 16]", "cells = [32, 0]", "cells", "domain.cells.1", &["at least 6", "not 0"]),
    ("cells = [32, 16]", "cells = [32, 8]", "cells", "domain.cells.1", &["at least 11 with sharp \
        surfaces", "not 8", "coupling.wall = \"mixing\""]),
    ("cells = [32, 16]", "cells = [32, 16, 16]", "cells", "domain.cells", &["one for each in \
        domain.size"]),
    ("cells = [32, 16]", "cells = [65536, 65536]", "cells", "domain.cells", &["2^31"]),
    (
        "divergence_limit = 1.0e-6", "divergence_limit = 0.0", "divergence_limit",
        "pressure.divergence_limit", &["must be positive", "1/s"],
    ),
    (
        "divergence_limit = 1.0e-6", "tightening = 2.0", "tightening", "pressure.tightening",
        &["at most 1"],
    ),
    ("end = 0.1", "end = 0.0", "end", "time.end", &["must be positive", "(s)"]),
    ("cfl = 0.4", "step = -0.001", "step", "time.step", &["must be positive", "(s)"]),
    // Contradictions.
    ("cfl = 0.4", "cfl = 0.4\nstep = 0.001", "step", "time.step", &["time.step and time.cfl \
        exclude each other"]),
    (
        "cfl = 0.4", "advection = \"qsi\"", "advection", "time.advection",
        &["time.scheme = \"euler\"", "upwind5"],
    ),
    ("south = \"periodic\"", "south = \"wall\"", "north", "boundary.north", &["north is periodic \
        and south is not", "or neither"]),
    (
        "north = \"periodic\"", "north = { moving_wall = [0.0, 1.0] }\nbottom = \"wall\"", "south",
        "boundary.south", &["south is periodic"],
    ),
    (
        "north = \"periodic\"", "north = \"periodic\"\ntop = \"wall\"", "top", "boundary.top",
        &["3D only", "remove it"],
    ),
    (
        "size = [2.0, 1.0]\ncells = [32, 16]", "size = [2.0, 1.0, 1.0]\ncells = [32, 16, 16]",
        "west", "boundary.west.inflow", &["a 3D case needs 3 numbers"],
    ),
    (
        "east = \"outflow\"", "east = \"wall\"", "west", "boundary.west",
        &["inflow without outflow", "set east = \"outflow\""],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "{ moving_wall = [1.0, 0.0] }", "west",
        "boundary.west.moving_wall.0", &["its own plane", "set x to 0.0"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow_profile = { at = [0.5, 0.5], velocity = [[1, 0], [1, 0]] } }", "west",
        "boundary.west.inflow_profile.at", &["must increase"],
    ),
    // Profiles over the height, and tables over time.
    (
        "{ inflow = [1.0, 0.0] }", "{ inflow_log = { velocity = [1.0, 0.0], roughness = 0.0 } }",
        "west", "boundary.west.inflow_log.roughness", &["must be positive", "(m)", "0.0"],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "{ inflow_log = { velocity = [1.0, 0.0] } }", "west",
        "boundary.west.inflow_log.roughness", &["missing key `roughness`"],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "{ inflow_half_parabola = [1.0] }", "west",
        "boundary.west.inflow_half_parabola", &["a 2D case needs 2 numbers"],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "{ inflow = { velocty = [1.0, 0.0] } }", "west", "boundary.west",
        &["a number for each axis", "velocity = [1.0, 0.0], over_time"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow = [1.0, 0.0], over_time = { time = [0, 1], factor = [0, 1] } }", "west",
        "boundary.west", &["found `inflow` and `over_time`", "`over_time` stands within it"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow = { velocity = [1.0], over_time = { time = [0, 1], factor = [0, 1] } } }", "west",
        "boundary.west.inflow.velocity", &["a 2D case needs 2 numbers"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow = { velocity = [1.0, 0.0], over_time = { time = [1, 1], factor = [0, 1] } } }",
        "west", "boundary.west.inflow.over_time.time", &["the times (s) must increase"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow = { velocity = [1.0, 0.0], over_time = { time = [0, 1], factor = [1] } } }",
        "west", "boundary.west.inflow.over_time.factor",
        &["needs 2 factors, one for each in `time`, not 1"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow = { velocity = [1.0, 0.0], over_time = { time = [0, 1], factor = [0, nan] } } }",
        "west", "boundary.west.inflow.over_time.factor.1", &["must be a finite number"],
    ),
    (
        "{ inflow = [1.0, 0.0] }", "{ inflow = { velocity = [1.0, 0.0], over_time = {} } }", "west",
        "boundary.west.inflow.over_time", &["needs exactly one of `time` with `factor` and `file`"],
    ),
    (
        "{ inflow = [1.0, 0.0] }",
        "{ inflow = { velocity = [1.0, 0.0], over_time = { file = \"flood.csv\" } } }", "west",
        "boundary.west.inflow.over_time.file", &["flood.csv", "there is no such file"],
    ),
    (
        "east = \"outflow\"",
        "east = { inflow = { velocity = [1.0, 0.0], over_time = { time = [0, 1], factor = [1, 2] } \
        } }", "east", "boundary.east", &["another table over_time", "give all inflows the same"],
    ),
    (
        "[time]",
        "[drive]\nforce = { value = [1.0], over_time = { time = [0, 1], factor = [0, 1] } }\n\
        [time]",
        "force", "drive.force.value", &["a 2D case needs 2 numbers", "N/m3"],
    ),
    (
        "[time]",
        "[drive.mean_velocity]\naxis = \"y\"\nvalue = 1.0\nover_time = { time = [0], factor = [1] \
        }\n[time]", "over_time", "drive.mean_velocity.over_time.time", &["at least 2 times (s)"],
    ),
];
