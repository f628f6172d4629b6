//! What a wrong case or command line gets: exit status 2, one message that says where and what
//! would be right, and nothing written. Each row breaks a good case in one way.

use crate::support::mics_command;
use std::fs;
use std::path::Path;
use std::process::Output;

pub const GOOD: &str = r#"name = "small"

[domain]
size = [2.0, 1.0]
cells = [32, 16]

[fluid]
density = 1.0
viscosity = 0.1

[boundary]
west = { inflow = [1.0, 0.0] }
east = "outflow"
south = "periodic"
north = "periodic"

[[particle]]
shape = { disc = { diameter = 0.2 } }
position = [0.5, 0.5]
motion = "fixed"

[[particle]]
shape = { disc = { diameter = 0.3 } }
position = [1.2, 0.5]
motion = "fixed"

[time]
end = 0.1
cfl = 0.4

[pressure]
divergence_limit = 1.0e-6

[[measure]]
name = "drag"
kind = "drag_coefficient"
"#;

/// A way to break the good case: the text to replace, its replacement, the text that the line named
/// must begin with (empty: no line is named), the key named, and what else the message must say.
type Row = (&'static str, &'static str, &'static str, &'static str, &'static [&'static str]);

#[rustfmt::skip]
const BAD_CASES: &[Row] = &[
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
    // The drive.
    (
        "[time]", "[drive]\nforce = [1.0, 0.0]\ngravity = true\n[time]", "[drive]", "drive",
        &["exactly one of", "there are 2"],
    ),
    ("[time]", "[drive]\n[time]", "[drive]", "drive", &["there are 0"]),
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
        "viscosity = 0.1", "viscosity = 0.1\ngravity = [0.0, -1.0]\n[drive]\nhold_mixture = true",
        "hold_mixture", "drive.hold_mixture", &["free particles"],
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
    ("cfl = 0.4", "upwinding = 0.5", "upwinding", "time.upwinding", &["three stages alone", "rk3"]),
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
        &["sharp walls close some", "choose \"auto\""],
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
        walls", "not 8", "coupling.wall = \"mixing\""]),
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
    // Particles.
    (
        "position = [0.5, 0.5]", "position = [0.05, 0.5]", "position = [0.05",
        "particle.0.position", &["particle 0 reaches from -0.05", "outside the domain", "2.0 m"],
    ),
    (
        "position = [0.5, 0.5]", "position = [0.5, 1.0]", "position = [0.5, 1",
        "particle.0.position", &["particle 0", "outside the domain", "0 <= y < 1.0 m"],
    ),
    (
        "position = [1.2, 0.5]", "position = [0.7, 0.5]", "position = [0.7", "particle.1.position",
        &["particle 1 overlaps particle 0", "0.246"],
    ),
    (
        "position = [1.2, 0.5]\nmotion = \"fixed\"", "position = [1.2, 0.5]\ndensity = 1e12",
        "density = 1e12", "particle.1.density",
        &["1.0e12 times the fluid's", "units of both densities"],
    ),
    (
        "position = [1.2, 0.5]", "position = [1.2, 0.5, 0.5]", "position = [1.2",
        "particle.1.position", &["a 2D case needs 2 numbers", "not 3"],
    ),
    (
        "diameter = 0.2", "diameter = 0.0", "shape", "particle.0.shape.disc.diameter",
        &["must be positive", "(m)"],
    ),
    (
        "diameter = 0.2", "diameter = 1.0", "shape", "particle.0.shape.disc.diameter",
        &["must be below"],
    ),
    (
        "{ disc = { diameter = 0.2 } }", "{ sphere = { diameter = 0.2 } }", "shape",
        "particle.0.shape", &["a disc is for 2D"],
    ),
    (
        "position = [0.5, 0.5]\nmotion = \"fixed\"", "position = [0.5, 0.5]\ndensity = 0.0",
        "density = 0", "particle.0.density", &["must be positive", "kg/m3"],
    ),
    (
        "position = [0.5, 0.5]", "position = [0.5, 0.5]\nvelocity = [1.0, 0.0]", "velocity",
        "particle.0.velocity", &["how a free particle starts", "\"free\"", "prescribed"],
    ),
    (
        "position = [0.5, 0.5]", "position = [0.5, 0.5]\nlocked = [\"x\"]", "locked",
        "particle.0.locked", &["for free particles"],
    ),
    (
        "position = [0.5, 0.5]\nmotion = \"fixed\"", "position = [0.5, 0.5]\nlocked = [\"z\"]",
        "locked", "particle.0.locked.0", &["3D only", "x, y and rotation"],
    ),
    ("position = [0.5, 0.5]\nmotion = \"fixed\"", "position = [0.5, 0.5]\n\
        locked = [\"x\", \"y\", \"x\"]", "locked", "particle.0.locked.2", &["given twice"]),
    (
        "position = [0.5, 0.5]\nmotion = \"fixed\"", "position = [0.5, 0.5]\nlocked = [\"w\"]",
        "locked", "particle.0.locked.0", &["unknown value `w`", "`rotation`"],
    ),
    (
        "position = [0.5, 0.5]\nmotion = \"fixed\"",
        "position = [0.5, 0.5]\nspin = [0.0, 0.0, 1.0]", "spin", "particle.0.spin",
        &["one number in 2D"],
    ),
    (
        "position = [0.5, 0.5]", "position = [0.5, 0.5]\nmaterial = \"\"", "material",
        "particle.0.material", &["is empty"],
    ),
    (
        "motion = \"fixed\"",
        "motion = { prescribed = { oscillation = { amplitude = [0.1], frequency = 1.0 } } }",
        "motion", "particle.0.motion.prescribed.oscillation.amplitude",
        &["a 2D case needs 2 numbers", "(m)", "not 1"],
    ),
    (
        "motion = \"fixed\"",
        "motion = { prescribed = { oscillation = { amplitude = [0.1, nan], frequency = 1.0 } } }",
        "motion", "particle.0.motion.prescribed.oscillation.amplitude.1", &["finite", "(m)"],
    ),
    (
        "motion = \"fixed\"",
        "motion = { prescribed = { oscillation = { amplitude = [0.1, 0.0], frequency = 0.0 } } }",
        "motion", "particle.0.motion.prescribed.oscillation.frequency",
        &["must be positive", "(1/s)"],
    ),
    (
        "motion = \"fixed\"",
        "motion = { prescribed = { oscillation = { amplitude = [0.1, 0.0] } } }", "motion",
        "particle.0.motion.prescribed.oscillation.frequency", &["missing key `frequency`"],
    ),
    (
        "motion = \"fixed\"",
        "motion = { prescribed = { oscillation = { amplitude = [0.1, 0.0], period = 1.0 } } }",
        "motion", "particle.0.motion.prescribed.oscillation.period",
        &["unknown key `period`", "`frequency`"],
    ),
    (
        "motion = \"fixed\"",
        "motion = { oscillation = { amplitude = [0.1, 0.0], frequency = 1.0 } }", "motion",
        "particle.0.motion.oscillation", &["unknown value `oscillation`", "`prescribed`"],
    ),
    // Swarms.
    (
        "[time]",
        "[[swarm]]\ncount = 90\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\ndiameter = 0.1\n\
         [time]",
        "count", "swarm.0.count", &["90 do not fit", "% of the region", "fewer or smaller"],
    ),
    (
        "[time]",
        "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.5, 1.0] }\ndiameter = 0.1\n\
         [time]",
        "region", "swarm.0.region.max.0", &["outside the domain", "0 <= x <= 2.0 m"],
    ),
    ("[time]", "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.5], max = [2.0, 0.2] }\n\
        diameter = 0.1\n[time]", "region", "swarm.0.region", &["no room", "along y", "widen it"]),
    ("[time]", "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n\
        diameter = 0.1\nfeed = { rate = 0.0 }\n\
        [time]", "feed = { rate", "swarm.0.feed.rate", &["must be positive", "(1/s)"]),
    ("[time]", "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n\
        diameter = 0.1\nmotion = \"fixed\"\nfeed = { rate = 1.0 }\n\
        [time]", "feed", "swarm.0.feed", &["is for free particles"]),
    (
        "motion = \"fixed\"", "motion = \"fixed\"\nenter = { time = 1.0 }", "enter",
        "particle.0.enter", &["is for free particles"],
    ),
    ("[time]", "[[swarm]]\ncount = 0\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n\
        diameter = 0.1\n[time]", "count", "swarm.0.count", &["from 1 to 1000000"]),
    (
        "[time]", "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n[time]",
        "[[swarm]]", "swarm.0.diameter", &["missing key `diameter`", "from = "],
    ),
    (
        "[time]",
        "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n\
         diameter = { uniform = [0.2, 0.1] }\n[time]",
        "diameter", "swarm.0.diameter", &["the least, 0.2 m, comes first"],
    ),
    (
        "[time]",
        "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n\
         diameter = { normal = [0.2, 0.1] }\n[time]",
        "diameter", "swarm.0.diameter", &["one number or { uniform = [least, largest] }"],
    ),
    ("[time]", "[[swarm]]\ncount = 9\nregion = { min = [1.5, 0.0], max = [2.0, 1.0] }\n\
        diameter = 0.1\nmotion = \"fixed\"\nspin = 1.0\n\
        [time]", "spin", "swarm.0.spin", &["how a free particle starts"]),
    (
        "[time]", "[[swarm]]\nfrom = \"\"\n[time]", "from", "swarm.0.from",
        &["is empty", "particles.csv"],
    ),
    (
        "[time]", "[[swarm]]\nfrom = \"gravel.csv\"\ngap = 0.1\n[time]", "gap", "swarm.0.gap",
        &["exclude each other"],
    ),
    (
        "[time]", "[[swarm]]\nfrom = \"gravel.csv\"\n[time]", "from", "swarm.0.from",
        &["gravel.csv", "no such file", "the case file's folder"],
    ),
    (
        "[time]", "[numerics]\nshared_aperture = 2.0\n[time]", "shared_aperture",
        "numerics.shared_aperture", &["2.0 is out of its range, from 0.001 to 0.9"],
    ),
    (
        "[time]", "[numerics]\nshared_apertur = 0.1\n[time]", "shared_apertur",
        "numerics.shared_apertur", &["unknown key", "did you mean `shared_aperture`?"],
    ),
    // Contact and materials.
    ("[time]", "[contact]\nnormal_stiffness = 1.0\nrestitution = 0.5\n\
        damping = { normal = 1.0, tangential = 1.0 }\n\
        [time]", "damping", "contact.damping", &["exclude each other"]),
    (
        "[time]",
        "[contact]\nnormal_stiffness = 1.0\n[contact.pair]\nbetween = [\"default\", \"wall\"]\n\
         [time]",
        "[contact.pair]", "contact.pair", &["a list", "[[contact.pair]]"],
    ),
    (
        "[time]", "[contact]\nnormal_stiffness = \"soft\"\n[time]", "normal_stiffness",
        "contact.normal_stiffness", &["auto"],
    ),
    (
        "[time]", "[contact]\nnormal_stiffness = 1.0\nexponent = 0.5\n[time]", "exponent",
        "contact.exponent", &["from 1 to 3"],
    ),
    (
        "[time]", "[contact]\nnormal_stiffness = 1.0\ntangential_ratio = inf\n[time]",
        "tangential_ratio", "contact.tangential_ratio", &["finite"],
    ),
    (
        "[time]", "[contact]\nnormal_stiffness = 1.0\nrestitution = 0.0\n[time]", "restitution",
        "contact.restitution", &["at least 0.001 and at most 1"],
    ),
    (
        "[time]", "[contact]\nnormal_stiffness = 1.0\nsubsteps = 0\n[time]", "substeps",
        "contact.substeps", &["\"auto\"", "from 1 to 1000000", "not 0"],
    ),
    (
        "[time]", "[contact]\nnormal_stiffness = 1.0\nsubsteps = 1000000000000\n[time]", "substeps",
        "contact.substeps", &["from 1 to 1000000"],
    ),
    ("[time]", "[[probe]]\nname = \"a\"\nat = [0.0, 0.0]\n[[probe]]\nname = \"a\"\n\
        at = [0.0, 0.1]\n[time]", "name = \"a\"", "probe.1.name", &["names another probe already"]),
    (
        "[time]", "[contact]\nnormal_stiffness = 1.0\nsubsteps = \"many\"\n[time]", "substeps",
        "contact.substeps", &["\"auto\" or a whole number, 1 or more"],
    ),
    (
        "[time]",
        "[contact]\nnormal_stiffness = 1.0\n[[contact.pair]]\nbetween = [\"steel\", \"wall\"]\n\
         [time]",
        "between", "contact.pair.0.between.0", &["\"steel\"", "known here: \"default\", \"wall\""],
    ),
    (
        "[time]",
        "[contact]\nnormal_stiffness = 1.0\n[[contact.pair]]\nbetween = [\"wall\"]\n[time]",
        "between", "contact.pair.0.between", &["2 materials", "not 1"],
    ),
    (
        "[time]",
        "[contact]\nnormal_stiffness = 1.0\n[[contact.pair]]\nbetween = [\"wall\", \"wall\"]\n\
         [time]",
        "between", "contact.pair.0.between", &["walls do not meet"],
    ),
    ("[time]", "[contact]\nnormal_stiffness = 1.0\n\
        pair = [{ between = [\"default\", \"wall\"] }, { between = [\"wall\", \"default\"] }]\n\
        [time]", "pair", "contact.pair.1.between", &["contact.pair.0 is of these two already"]),
    ("[time]", "[contact]\nnormal_stiffness = 1.0\n\
        pair = [{ between = [\"default\", \"wall\"], friction = -1.0 }]\n\
        [time]", "pair", "contact.pair.0.friction", &["zero or positive"]),
    // Presets.
    (
        "name = \"small\"", "name = \"small\"\npreset = \"mics-2002\"", "preset", "preset",
        &["unknown value `mics-2002`", "mics-2003"],
    ),
    // Measures and output.
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nparticle = 2", "particle",
        "measure.0.particle", &["no particle 2", "has 2"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"strouhal\"\nfrom = 5.0", "from", "measure.0.from",
        &["before time.end = 0.1 s"],
    ),
    ("kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\n[[measure]]\nname = \"drag\"\n\
        kind = \"max_speed\"", "name = \"drag\"", "measure.1.name", &["names another measure"]),
    (
        "kind = \"drag_coefficient\"", "kind = \"position_z\"", "kind", "measure.0.kind",
        &["3D only"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"morison_drag\"", "kind", "measure.0.kind",
        &["a particle that swings", "oscillation"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\ntolerance = 0.1", "tolerance",
        "measure.0.tolerance", &["is of a reference", "give `reference`"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nsource = \"a book\"", "source",
        "measure.0.source", &["that of a reference", "give `reference`"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nreference = 1.5",
        "[[measure]]", "measure.0.tolerance", &["is missing", "tolerance = 0.02 is 2 %"],
    ),
    (
        "kind = \"drag_coefficient\"",
        "kind = \"drag_coefficient\"\nreference = 0.0\ntolerance = 0.1", "reference",
        "measure.0.reference", &["not 0", "a band [low, high]"],
    ),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nreference = [2.0, 1.0]",
        "reference", "measure.0.reference", &["a band is [low, high]"],
    ),
    ("kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nreference = [1.0, 2.0]\n\
        tolerance = -0.1", "tolerance", "measure.0.tolerance", &["zero or positive"]),
    (
        "kind = \"drag_coefficient\"", "kind = \"drag_coefficient\"\nreference = \"1.5\"",
        "reference", "measure.0.reference", &["one number or a band [low, high]"],
    ),
    (
        "[[measure]]", "[output]\nfields = { every = 0 }\n[[measure]]", "fields",
        "output.fields.every", &["1 step or more"],
    ),
    (
        "[[measure]]", "[output]\nfields = { every = 1, every_time = 0.1 }\n[[measure]]", "fields",
        "output.fields", &["exactly one of"],
    ),
    (
        "[[measure]]", "[output]\ncheckpoint = { every_steps = 0 }\n[[measure]]", "checkpoint",
        "output.checkpoint.every_steps", &["1 step or more"],
    ),
    (
        "[[measure]]", "[output]\ncheckpoint = {}\n[[measure]]", "checkpoint", "output.checkpoint",
        &["exactly one of"],
    ),
    (
        "[[measure]]", "[output]\ncheckpoint = { every_wall_minutes = -1 }\n[[measure]]",
        "checkpoint", "output.checkpoint.every_wall_minutes", &["positive", "minutes"],
    ),
    (
        "size = [2.0, 1.0]\ncells = [32, 16]", "size = [2.0, 1.0]\ncells = [40000, 40000]", "cells",
        "domain.cells", &["GB", "fewer cells"],
    ),
    ("cfl = 0.4", "cfl = 0.6\nscheme = \"rk2\"", "cfl", "time.cfl", &["over the limit of this \
        scheme", "0.5", "rk3"]),
    ("cfl = 0.4", "cfl = 1.3", "cfl", "time.cfl", &["over the limit of this scheme", "1.2; lower \
        it"]),
    // What only the scene can tell: it finds the limit of a step, and names it.
    ("cfl = 0.4", "step = 0.09", "step", "time.step", &["limit"]),
];

/// Overrides of the good case that are refused, and what the message must say.
const BAD_OVERRIDES: &[(&str, &[&str])] = &[
    ("fluid.viscosity", &["key.path=value"]),
    ("fluid.viscosity=", &["no value"]),
    ("=2.0", &["key.path=value"]),
    ("time.end=0,2", &["`0,2` has a comma where a number has a point: --set time.end=0.2"]),
    ("fluid.viscosity=5.0 Pa s", &["words behind the number", "--set fluid.viscosity=5.0"]),
    ("time.scheme=euler", &[r#"--set 'time.scheme="euler"'"#]),
    ("domain.cells=[32", &["not a TOML value"]),
    ("particle.5.density=2.0", &["no entry 5", "has 2"]),
    ("particle.density=2.0", &["`particle.0.density`"]),
    (
        "fluid.viscosity=-2.0",
        &["small.toml", "fluid.viscosity", "zero or positive", "(given by --set)"],
    ),
    ("fluid.viscosty=2.0", &["small.toml", "did you mean `viscosity`?", "(given by --set)"]),
    ("preset=\"mics-2004\"", &["small.toml", "preset", "mics-2003", "(given by --set)"]),
    ("domain.cells=\"many\"", &["small.toml", "domain.cells", "wanted a list", "(given by --set)"]),
];

/// `mics run CASE --out DIR` and these further arguments.
fn mics(case: &Path, out: &Path, arguments: &[&str]) -> Output {
    let mut command = mics_command();
    command.arg("run").arg(case).arg("--out").arg(out).args(arguments);
    command.output().expect("the binary runs")
}

/// What is wrong with a refusal: its status, its message or what it left in `out`; empty where all
/// is as it should be.
pub fn shortcomings(output: &Output, out: &Path, says: &[&str]) -> Vec<String> {
    let message = String::from_utf8_lossy(&output.stderr);
    let mut wrong = Vec::new();
    if output.status.code() != Some(2) {
        wrong.push(format!("exit status {:?}, expected 2", output.status.code()));
    }
    if message.lines().filter(|line| line.starts_with("error: ")).count() != 1
        || !message.starts_with("error: ")
    {
        wrong.push("expected one message".into());
    }
    wrong.extend(
        says.iter()
            .filter(|part| !message.contains(**part))
            .map(|part| format!("does not say `{part}`")),
    );
    if out.exists() {
        wrong.push("the output folder was made".into());
    }
    if !wrong.is_empty() {
        wrong.push(format!("it printed: {message}"));
    }
    wrong
}

/// Runs `text` as a case file and expects a refusal that says all of `says`.
fn refused(text: &[u8], arguments: &[&str], says: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    fs::write(&case, text).expect("the scratch folder takes a file");
    shortcomings(&mics(&case, &out, arguments), &out, says)
}

/// Fails with every shortcoming of every row, so that one run shows all.
pub fn expect_none(shortcomings: impl IntoIterator<Item = (String, Vec<String>)>) {
    let failed = shortcomings.into_iter().filter(|(_, wrong)| !wrong.is_empty());
    let report: Vec<_> =
        failed.map(|(row, wrong)| format!("{row}\n    {}", wrong.join("\n    "))).collect();
    assert!(report.is_empty(), "{} rows fall short:\n{}", report.len(), report.join("\n"));
}

#[test]
fn the_case_that_the_bad_ones_are_made_from_is_good() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let case = folder.path().join("small.toml");
    fs::write(&case, GOOD).expect("the scratch folder takes a file");
    let output = mics_command().arg("check").arg(case).output().expect("the binary runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_bad_case_is_refused_with_one_message_that_names_file_line_key_and_cure() {
    expect_none(BAD_CASES.iter().map(|(from, to, line, key, says)| {
        assert!(GOOD.contains(from), "the good case has no `{from}`");
        let text = GOOD.replacen(from, to, 1);
        // Of several lines that begin so, the last one up to the end of the replacement is meant,
        // else the first.
        let changed = text[..GOOD.find(from).unwrap_or(0) + to.len()].lines().count();
        let begins_so = |(_, text): &(usize, &str)| !line.is_empty() && text.starts_with(line);
        let up_to_change = text.lines().enumerate().take(changed).filter(begins_so).last();
        let place = match up_to_change.or_else(|| text.lines().enumerate().find(begins_so)) {
            Some((index, _)) => format!("small.toml:{}: ", index + 1),
            None => "small.toml: ".into(),
        };
        let mut all = vec![place.as_str(), key];
        all.extend(*says);
        (format!("`{from}` -> `{to}`"), refused(text.as_bytes(), &[], &all))
    }));
}

#[test]
fn a_bad_override_is_refused_with_one_message_that_names_it_and_the_right_form() {
    let row = |(given, says): &(&str, &[&str])| {
        (given.to_string(), refused(GOOD.as_bytes(), &["--set", given], says))
    };
    expect_none(BAD_OVERRIDES.iter().map(row));
}

#[test]
fn what_a_preset_gives_is_refused_at_its_line() {
    let text = GOOD
        .replacen('\n', "\npreset = \"mics-2003\"\n", 1)
        .replace("cfl = 0.4", "scheme = \"rk2\"");
    let says = ["small.toml:2: time.advection", "qsi is a one-step scheme", "(given by preset)"];
    expect_none([("rk2 with the preset".into(), refused(text.as_bytes(), &[], &says))]);
}

#[test]
fn a_bad_list_of_particles_is_refused_with_its_file_line_and_column() {
    let row = |csv: &str, says: &[&str]| {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
        let text = GOOD.replace("[time]", "[[swarm]]\nfrom = \"gravel.csv\"\n[time]");
        fs::write(&case, text).expect("the scratch folder takes a file");
        fs::write(folder.path().join("gravel.csv"), csv).expect("the scratch folder takes a file");
        let all = [&["small.toml:28: swarm.0.from: "], says].concat();
        (csv.to_owned(), shortcomings(&mics(&case, &out, &[]), &out, &all))
    };
    expect_none([
        row(
            "x,y,diamter\n1.7,0.2,0.1\n",
            &["gravel.csv:1", "`diamter`", "x, y, diameter, density, vx, vy, spin"],
        ),
        row("x,y\n1.7,0.2\n", &["gravel.csv:1", "`diameter` is missing", "x, y and diameter"]),
        row("x,y,y,diameter\n1.7,0.2,0.2,0.1\n", &["gravel.csv:1", "`y`", "twice"]),
        row(
            "x,y,diameter\n1.7,0.2,0.1\n1.7,high,0.1\n",
            &["gravel.csv:3", "`y`", "finite number", "\"high\""],
        ),
        row("x,y,diameter\n1.7,0.2,-0.1\n", &["gravel.csv:2", "`diameter`", "positive (m)"]),
        row("x,y,diameter\n1.7,0.2\n", &["gravel.csv:2", "has 2 columns, and the header 3"]),
        row("x,y,diameter\n1.99,0.2,0.1\n", &["gravel.csv:2", "along x", "outside the domain"]),
        row(
            "x,y,diameter\n1.8,0.9,0.1\n1.8,0.2,0.1\n1.75,0.2,0.1\n",
            &["gravel.csv:4", "that of line 3"],
        ),
        row("x,y,diameter\n1.2,0.5,0.1\n", &["gravel.csv:2", "overlaps particle 1"]),
        row("x,y,diameter\n", &["gravel.csv", "lists no particles"]),
    ]);
}

#[test]
fn a_case_file_that_cannot_be_read_as_text_is_refused() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let out = folder.path().join("out");
    let absent = folder.path().join("absent.toml");
    let latin1 = GOOD.replace("small", "sm\u{e5}ll").chars().map(|c| c as u8).collect::<Vec<_>>();
    expect_none([
        (
            "absent".into(),
            shortcomings(&mics(&absent, &out, &[]), &out, &["absent.toml", "no such file"]),
        ),
        (
            "a directory".into(),
            shortcomings(
                &mics(folder.path(), &out, &[]),
                &out,
                &["directory", "name the case file"],
            ),
        ),
        ("not UTF-8".into(), refused(&latin1, &[], &["small.toml:1", "UTF-8"])),
    ]);
}

#[test]
fn a_folder_that_holds_a_run_is_refused_and_left_as_it_was() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    fs::write(&case, GOOD).expect("the scratch folder takes a file");
    fs::create_dir(&out).expect("the scratch folder takes a folder");
    fs::write(out.join("run.json"), "{}").expect("the folder takes a file");
    let wrong = shortcomings(&mics(&case, &out, &[]), Path::new(""), &["exists", "--force"]);
    let left: Vec<_> = fs::read_dir(&out)
        .expect("the folder is still there")
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(left, [out.join("run.json")]);
    assert_eq!(fs::read_to_string(&left[0]).expect("it is text"), "{}");
    expect_none([("a folder with a run".into(), wrong)]);
}

#[test]
fn force_replaces_a_run_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let (case, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    fs::write(&case, GOOD).expect("the scratch folder takes a file");
    let short = [
        "--quiet",
        "--set",
        "time.end=0.02",
        "--set",
        "output.figures=false",
        "--set",
        "measure=[]",
    ];
    assert!(mics(&case, &out, &short).status.success());
    let (notes, stale) = (out.join("fields/notes.txt"), out.join("fields/99999999.vti"));
    fs::write(&notes, "mine").expect("the folder takes a file");
    fs::write(&stale, "old").expect("the folder takes a file");
    // Its own case would be deleted under it.
    let inside = mics(&out.join("case.toml"), &out, &["--force"]);
    let message = String::from_utf8_lossy(&inside.stderr);
    assert!(
        inside.status.code() == Some(2) && message.contains("would delete the case file"),
        "{message}"
    );
    assert!(mics(&case, &out, &[&short[..], &["--force"]].concat()).status.success());
    assert_eq!(fs::read_to_string(&notes).expect("it is still there"), "mine");
    assert!(!stale.exists(), "a field of the run before");
    // A folder with a case in it is not a run.
    let own = folder.path().join("own");
    fs::create_dir(&own).expect("the scratch folder takes a folder");
    fs::write(own.join("case.toml"), GOOD).expect("the folder takes a file");
    let refused = mics(&case, &own, &["--force"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(2) && message.contains("holds no run"), "{message}");
    assert_eq!(fs::read_to_string(own.join("case.toml")).expect("it is still there"), GOOD);
}

#[test]
fn a_petsc_option_that_cannot_be_is_refused_by_name() {
    let row = |options: &[&str], says: &[&str]| {
        (options.join(" "), refused(GOOD.as_bytes(), &[&["--"], options].concat(), says))
    };
    expect_none([
        row(&["-ksp_type", "nonsense"], &["nonsense"]),
        row(&["-pc_type", "nonsense"], &["nonsense"]),
        row(&["-pc_type", "lu", "-pc_factor_mat_solver_type", "nonsense"], &["nonsense"]),
        row(&["-options_file", "/nowhere/at/all"], &["/nowhere/at/all"]),
        row(&["-ksp_rtol", "small"], &["-ksp_rtol", "\"small\"", "not a tolerance"]),
        row(&["-ksp_rtol", "1.0"], &["-ksp_rtol", "no reduction", "1e-8"]),
        row(&["ksp_type", "cg"], &["\"ksp_type\"", "begin with a dash"]),
        row(&["-ksp_type", "cg", "pc_type", "gamg"], &["\"pc_type\"", "begin with a dash"]),
    ]);
}
