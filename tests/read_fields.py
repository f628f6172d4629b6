"""Reads run folders' fields with VTK and compares them with what the runs say of themselves; reads the newest with PyVista
too, and by way of it with meshio, which has no reader of image data of its own."""

import csv
import json
import math
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import meshio
import numpy
import pyvista
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

passed = 0


def expect(condition, message):
    global passed
    if not condition:
        sys.exit(f"read_fields: {message}")
    passed += 1


lists = {"--runs": [], "--surfaces": [], "--tractions": []}
kind = "--runs"
for word in sys.argv[1:]:
    if word in lists:
        kind = word
    else:
        lists[kind].append(word)
runs, shapes, tractions = lists.values()
for run in map(Path, runs):
    summary = json.loads((run / "summary.json").read_text())
    steps = list(csv.DictReader((run / "steps.csv").open()))
    series = ElementTree.parse(run / "fields/series.pvd").getroot().findall("Collection/DataSet")
    expect(len(series) >= 3, f"{run}: the series holds {len(series)} snapshots")
    for entry in series:
        reader = vtkXMLImageDataReader()
        reader.SetFileName(str(run / "fields" / entry.get("file")))
        reader.Update()
        image = reader.GetOutput()
        cells = image.GetCellData()
        names = {cells.GetArrayName(k) for k in range(cells.GetNumberOfArrays())}
        expect({"velocity", "pressure", "vorticity", "solid_fraction"} <= names, f"{run}: arrays {names}")
        n = image.GetNumberOfCells()
        expect(n == summary["cells"], f"{run}: {n} cells")
        time = image.GetFieldData().GetArray("TimeValue").GetValue(0)
        expect(time == float(entry.get("timestep")), f"{run}: time {time}")
        volume = math.prod(h for h, c in zip(image.GetSpacing(), image.GetDimensions()) if c > 2)
        # The kinetic energy of the fields, of what is fluid of each cell, is that of the log but for the part of cut cells that are
        # shown with the particle's motion, which is none; the fraction's sum is the particle's volume.
        velocity, fraction = cells.GetArray("velocity"), cells.GetArray("solid_fraction")
        square = [sum(v * v for v in velocity.GetTuple3(c)) for c in range(n)]
        energy = 0.5 * 1000.0 * volume * sum((1 - fraction.GetValue(c)) * square[c] for c in range(n))
        logged = next(float(s["kinetic_energy"]) for s in steps if float(s["time"]) == time)
        expect(abs(energy - logged) < 1e-3 * logged, f"{run}: energy {energy} against {logged}")
        inside = [c for c in range(n) if fraction.GetValue(c) > 0.5]
        expect(inside and all(square[c] == 0 for c in inside), f"{run}: the fluid moves inside a particle that is held")
        solid = volume * sum(fraction.GetValue(c) for c in range(n))
        flat = image.GetDimensions()[2] == 2
        exact = math.pi * 0.1**2 if flat else 4 / 3 * math.pi * 0.1**3
        expect(abs(solid - exact) < 1e-8 * exact, f"{run}: solid volume {solid} against {exact}")
    # The bodies of the newest snapshot are where the log has them.
    bodies = ElementTree.parse(run / "fields/bodies.pvd").getroot().findall("Collection/DataSet")
    expect([b.get("timestep") for b in bodies] == [s.get("timestep") for s in series], f"{run}: times of bodies.pvd")
    points = pyvista.read(run / "fields" / bodies[-1].get("file"))
    row = [r for r in csv.DictReader((run / "particles.csv").open()) if float(r["time"]) == float(bodies[-1].get("timestep"))][-1]
    expect(list(points.points[0]) == [float(row[c]) for c in "xyz"] or
           max(abs(points.points[0] - numpy.array([float(row[c]) for c in "xyz"]))) < 1e-6, f"{run}: a body's place")
    force = points.point_data["force"][0]
    expect(list(force) == [float(row["fluid_f" + c]) for c in "xyz"], f"{run}: a body's force {force}")
    expect(abs(points.point_data["radius"][0] - 0.1) < 1e-12 and list(points.point_data["orientation"][0]) == [1, 0, 0, 0], f"{run}: a body")
    # Values, 8 bytes each, and a head: what a snapshot takes on the disk.
    newest = run / "fields" / series[-1].get("file")
    mesh = pyvista.read(newest)
    numbers = sum(mesh.cell_data[name].size for name in mesh.cell_data)
    expect(0 < newest.stat().st_size - 8 * numbers < 4096, f"{run}: {newest.stat().st_size} bytes for {numbers} numbers")
    with tempfile.TemporaryDirectory() as folder:
        other = f"{folder}/fields.vtu"
        pyvista.save_meshio(other, mesh)
        cells = meshio.read(other).cell_data
        for name in mesh.cell_data:
            expect(numpy.array_equal(numpy.concatenate(cells[name]), mesh.cell_data[name]), f"{run}: {name} by way of meshio")
# Surfaces of bodies that are not round: a sphere, an ellipsoid that moves and turns, a cube.
for run in map(Path, shapes):
    newest = sorted((run / "fields").glob("bodies-*.vtp"))[-1]
    mesh = pyvista.read(newest)
    time = mesh.field_data["TimeValue"][0]
    ids = mesh.point_data["id"]
    expect(mesh.n_verts == 3 and mesh.n_faces > 12 and list(mesh.point_data["radius"][:3]) == [0.01, 0, 0], f"{run}: centres")
    expect(set(ids) == {0, 1, 2} and sum(ids == 0) == 1, f"{run}: points of the bodies")
    exact = [None, math.pi / 6 * 0.03 * 0.02 * 0.015, 0.02**3]
    for k, corners in ((1, None), (2, 8)):
        surface = mesh.extract_points(numpy.flatnonzero(ids == k)[1:], adjacent_cells=False).extract_surface(algorithm="dataset_surface")
        expect(corners is None or surface.n_points == corners, f"{run}: {surface.n_points} corners of body {k}")
        expect(abs(surface.volume / exact[k] - 1) < 0.02, f"{run}: volume {surface.volume} of body {k} against {exact[k]}")
        expect(abs(mesh.point_data["diameter"][k] - (6 / math.pi * exact[k]) ** (1 / 3)) < 1e-9, f"{run}: diameter of body {k}")
    centre = mesh.points[1]
    expect(abs(centre[0] - 0.06 - time) < 1e-6, f"{run}: the ellipsoid's place {centre}")
    for k in numpy.flatnonzero(ids == 1)[1:]:
        arm, v = mesh.points[k] - centre, mesh.point_data["velocity"][k]
        expect(max(abs(v - numpy.array([1 - 10 * arm[1], 10 * arm[0], 0]))) < 1e-5, f"{run}: velocity {v} at {arm}")
# Pressure and shear on the surfaces of all bodies: integrated over the triangles they are the forces of the log (sphere
# 3 %, ellipsoid 2 %, cube with its edges 14 %).
for run in map(Path, tractions):
    mesh = pyvista.read(sorted((run / "fields").glob("bodies-*.vtp"))[-1])
    ids, pressure, shear = (mesh.point_data[name] for name in ("id", "pressure", "shear"))
    expect(pressure.shape == ids.shape and shear.shape == (len(ids), 3), f"{run}: shapes {pressure.shape}, {shear.shape}")
    rows = list(csv.DictReader((run / "particles.csv").open()))[-3:]
    corners = mesh.faces.reshape(-1, 4)[:, 1:]
    for k, row in enumerate(rows):
        own = corners[ids[corners[:, 0]] == k]
        a, b, c = (mesh.points[own[:, n]].astype(float) for n in range(3))
        areas = 0.5 * numpy.cross(b - a, c - a)
        pushed = -(areas * pressure[own].mean(axis=1)[:, None]).sum(axis=0)
        rubbed = (numpy.linalg.norm(areas, axis=1)[:, None] * shear[own].mean(axis=1)).sum(axis=0)
        for force, part in ((pushed, "pressure"), (rubbed, "viscous")):
            logged = numpy.array([float(row[f"{part}_f{axis}"]) for axis in "xyz"])
            size = max(numpy.linalg.norm(logged), 1e-3 * numpy.linalg.norm(numpy.array([float(row["fluid_f" + axis]) for axis in "xyz"])))
            apart = numpy.linalg.norm(force - logged) / size
            print(f"body {k}: {part} {force} N of the surface, {logged} N logged")
            expect(len(own) > 12 and apart < 0.2, f"{run}: {part} of body {k} {apart} apart")
    mean = shear[ids == 1][0]
    expect(0.0 < numpy.linalg.norm(mean) < numpy.linalg.norm(shear[ids == 1][1:], axis=1).max(), f"{run}: mean shear {mean}")
print(f"{passed} passed, 0 failed")
