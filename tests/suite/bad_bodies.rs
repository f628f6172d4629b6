//! Ways to break a good case: particles, swarms, contacts, presets, measures and output.

use crate::bad_keys::Row;

#[rustfmt::skip]
pub const BAD_BODIES: &[Row] = &[
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
        "[time]", "[numerics]\nshared_aperture = 0.2\n[time]", "[numerics]", "numerics",
        &["no keys any more", "src/numerics.rs", "docs/method.md"],
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
        &["must be before time.end", "time.end is 0.1 s"],
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
        "output.fields", &["exactly one of `every`, `every_time`"],
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
    // Only the scene can tell: it finds the limit of a step, and names it.
    ("cfl = 0.4", "step = 0.09", "step", "time.step", &["limit"]),
];
