"""Shared by scripts of this folder: writes small cases, runs them, reads their energy budget."""

import argparse
import concurrent.futures
import csv
import json
import os
import subprocess
import time

GRAVITY = 9.81  # m/s2
WALLS_2D = {side: "wall" for side in ("west", "east", "south", "north")}
WALLS_3D = {**WALLS_2D, "bottom": "wall", "top": "wall"}
BODIES = "time id x y z vx vy vz wx wy wz contact_fx contact_fy contact_fz".split()
LOSSES = ("viscous_loss", "contact_loss", "friction_loss", "method_loss")


def arguments(doc, out, groups):
    """Parses the options that the scripts have in common; `groups` are the choices of `--only`."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=doc, formatter_class=form)
    parser.add_argument("--binary", help="the program; default MICS, or the one that is built here")
    parser.add_argument("--only", choices=groups, help="run the scenes of one group")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("out", nargs="?", default=out, help="the folder of cases and runs")
    parser.add_argument("--quick", action="store_true", help="a few scenes")
    parser.add_argument("--read", action="store_true", help="judge the runs that are in DIR")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    return parser


def program(options):
    """Returns the program to run: the given one, `MICS`, or the one that cargo builds here."""
    found = options.binary or os.environ.get("MICS") or ""
    if not found and not options.read:
        subprocess.run(["cargo", "build", "--release", "--quiet"], check=True)
        found = "target/release/mics"
    return os.path.abspath(found)


def disc(diameter, density, position, **more):
    """A body of a case: a disc for two coordinates and a sphere for three."""
    return dict(diameter=diameter, density=density, position=position, **more)


def toml(value):
    """Writes a Python value as TOML does."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)


def write(path, name, scene):
    """Writes a scene as a case file: bodies, size, cells, fluid, boundary, contact and time."""
    dimension = len(scene["size"])
    fluid = dict(scene["fluid"])
    fluid.setdefault("gravity", [0.0, -GRAVITY] + [0.0] * (dimension - 2))
    boundary = scene.get("boundary") or (WALLS_2D if dimension == 2 else WALLS_3D)
    particles = {"every": scene.get("every", 1)}
    lines = [
        f'name = "{name}"',
        f"domain = {toml({'size': scene['size'], 'cells': scene['cells']})}",
        f"fluid = {toml(fluid)}",
        f"boundary = {toml(boundary)}",
        f"contact = {toml(scene['contact'])}",
        f"time = {toml(scene['time'])}",
        f"pressure = {toml({'divergence_limit': scene.get('divergence_limit', 1e-2)})}",
        f"output = {toml({'figures': False, 'particles': particles})}",
    ]
    if scene.get("drive"):
        lines.append(f"drive = {toml(scene['drive'])}")
    for body in scene["bodies"]:
        more = dict(body)
        shape = {("disc" if dimension == 2 else "sphere"): {"diameter": more.pop("diameter")}}
        lines += ["", "[[particle]]", f"shape = {toml(shape)}"]
        lines += [f"{key} = {toml(value)}" for key, value in more.items()]
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


def columns(path, wanted=None):
    """Reads a CSV file of numbers into a list for each column, or for each wanted one."""
    with open(path) as file:
        rows = csv.reader(file)
        names = next(rows)
        kept = [k for k, name in enumerate(names) if wanted is None or name in wanted]
        table = list(zip(*([float(row[k]) for k in kept] for row in rows)))
        return dict(zip((names[k] for k in kept), table))


def run(binary, options, name, scene):
    """Runs a scene and returns its exit status, message, seconds, steps and bodies.

    `steps` holds the columns of steps.csv, `bodies` some columns of particles.csv for each body.
    Both are None where the run wrote no table. With `--read` nothing runs: the run is in DIR.
    """
    out, ended = options.out, f"{options.out}/{name}.json"
    if options.read:
        with open(ended) as file:
            found = json.load(file)
    else:
        write(f"{out}/{name}.toml", name, scene)
        command = [binary, "run", f"{out}/{name}.toml", "--quiet", "--force"]
        command += ["--out", f"{out}/{name}"]
        command += [word for one in options.set for word in ("--set", one)]
        start = time.monotonic()
        said = subprocess.run(command, capture_output=True, text=True)
        message = " ".join(said.stderr.split())
        found = dict(status=said.returncode, message=message, seconds=time.monotonic() - start)
        with open(ended, "w") as file:
            json.dump(found, file)
    found["steps"] = found["bodies"] = None
    try:
        found["steps"] = columns(f"{out}/{name}/steps.csv")
        rows, count = columns(f"{out}/{name}/particles.csv", BODIES), len(scene["bodies"])
        # Each step has a row for every body, in their order.
        found["bodies"] = [
            {key: column[body::count] for key, column in rows.items()} for body in range(count)
        ]
    except (OSError, StopIteration):
        pass
    return found


def each(jobs, work, scenes):
    """Calls `work` for every scene, so many at a time, and returns the results in order."""
    with concurrent.futures.ThreadPoolExecutor(max(1, jobs)) as pool:
        return list(pool.map(work, scenes))


def energy_rise(steps, more=(), floor=0.0):
    """Finds the largest rise of the total energy of a run, as a part of what was put in.

    The energy is that of fluid, bodies and normal springs less the work of gravity and the sides of the box.
    Nothing may raise it. The rise at a time is the energy then over the least before; it is
    divided by the energy at the start and the largest work of gravity until then. Returns the
    rise, the time of the least energy, that of the rise, and what each loss gave back between
    these two times, as parts of the same; further the rise as a part of all that was put in, and
    how much the loss of contacts and of the method ever fell below its largest value before.
    `more` are columns to count as energy: friction_loss holds the tangential springs as well.
    `floor` is the least energy to divide by (J).
    """
    worst = dict(rise=0.0, since=0.0, time=0.0, scale=0.0, given={key: 0.0 for key in LOSSES})
    kept = ("fluid_energy", "bodies_energy", "spring_energy", *more)
    total = [sum(parts) for parts in zip(*(steps[key] for key in kept))]
    energy = [e - g - b for e, g, b in zip(total, steps["gravity_work"], steps["boundary_work"])]
    least, scale = 0, max(total[0], floor)
    for now in range(1, len(energy)):
        scale = max(scale, total[0] + steps["gravity_work"][now])
        if energy[now] < energy[least]:
            least = now
        rise = (energy[now] - energy[least]) / scale if scale > 0 else 0.0
        if rise > worst["rise"]:
            given = {key: (steps[key][least] - steps[key][now]) / scale for key in LOSSES}
            times = dict(since=steps["time"][least], time=steps["time"][now])
            worst = dict(rise=rise, scale=scale, given=given, **times)
    worst["back"] = {key: given_back(steps[key], total[0], steps["gravity_work"]) for key in LOSSES}
    worst["of_all"] = worst["rise"] * worst["scale"] / scale if scale > 0 else 0.0
    return worst


def given_back(loss, start, work):
    """Finds the largest fall of a loss, as a part of what was put in until then."""
    most, scale, back = loss[0], start, 0.0
    for value, given in zip(loss, work):
        most, scale = max(most, value), max(scale, start + given)
        back = max(back, (most - value) / scale if scale > 0 else 0.0)
    return back
