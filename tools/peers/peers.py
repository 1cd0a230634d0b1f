#!/usr/bin/env python3
"""Error against CPU time of umbrage and of what one would use instead, on the same scenes and machine. See ../README.md."""
import argparse
import csv
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import plot
from scenes import Scene, read_lit, read_obj, spread, whole

ROOT = Path(__file__).resolve().parents[2]

# Errors that umbrage is asked for; samples a point of Mitsuba; of Radiance ambient divisions, super-samples, accuracy and the
# size of a lamp's parts over their distance, and where there is direct light alone these sizes.
ERRORS = [0.2, 0.1, 0.05, 0.02, 0.01, 0.005]
SAMPLES = [1, 4, 16, 64, 256, 1024]
AMBIENT = [(32, 8, 0.4, 0.1), (128, 32, 0.3, 0.075), (512, 128, 0.2, 0.05)]
PARTS = [0.4, 0.2, 0.1, 0.05]  # Radiance makes at most 64 parts of a lamp.
# Samples of the reference where light between surfaces is part of it, a fresh seed: a quarter of the noise of the best run.
REFERENCE_SAMPLES = 16384
BOUNCES = 8


def cpu(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


class Umbrage:
    name = "umbrage"

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def probe(self, scene, points, *options):
        normals = np.hstack(points[:2])
        np.savetxt(self.folder / "points.txt", normals, fmt="%.17g")
        words = [self.program, "probe", *([scene.argument] if scene.argument else []), "--points", "points.txt", *options]
        words += ["--quiet", "--bounces", scene.bounces]
        before = cpu(resource.RUSAGE_CHILDREN)
        run = subprocess.run(words, cwd=self.folder, check=True, capture_output=True, text=True)
        return np.array([l.split() for l in run.stdout.splitlines()], float), cpu(resource.RUSAGE_CHILDREN) - before

    def runs(self, scene, points):
        for error in ERRORS:
            yield f"--error {error}", *self.probe(scene, points, "--error", str(error))


class Mitsuba:
    name = "Mitsuba 3, path tracer"

    def __init__(self, folder):
        import mitsuba

        self.mi, self.folder = mitsuba, folder
        # Compiled C++ with Embree; the variants that compile while they run need an LLVM that not every system has.
        mitsuba.set_variant("scalar_rgb")

    def scene(self, scene, points):
        depth = 2 if scene.bounces == "0" else -1
        made = {"type": "scene", "integrator": {"type": "path", "max_depth": depth, "rr_depth": 20}}
        for i, (triangles, reflectance, radiance) in enumerate(scene.parts):
            path = self.folder / f"part{i}.ply"
            write_ply(path, triangles)
            bsdf = {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance.tolist()}}
            if scene.is_two_sided:
                bsdf = {"type": "twosided", "inner": bsdf}
            made[f"part{i}"] = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": bsdf}
            if radiance.any():
                emitter = {"type": "area", "radiance": {"type": "rgb", "value": radiance.tolist()}}
                made[f"part{i}"]["emitter"] = emitter
        positions, normals, _ = points
        # A ray from just above each point straight down on it: its radiance is ρ E / π. Rays start 9e-5 m after their
        # origin (Mitsuba's epsilon in single precision), so that it must be higher than that.
        above = 1e-3 * np.ptp(np.concatenate([t.reshape(-1, 3) for t, _, _ in scene.parts]), axis=0).max()
        one = {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}}
        sensor = {"type": "batch", "film": {**one, "width": len(positions), "component_format": "float32"}}
        for i, (p, n) in enumerate(zip(positions, normals)):
            sensor[f"s{i:06}"] = {"type": "radiancemeter", "origin": (p + above * n).tolist(), "direction": (-n).tolist(), "film": one}
        made["sensor"] = sensor
        return self.mi.load_dict(made)

    def irradiance(self, loaded, points, samples, seed):
        before = cpu(resource.RUSAGE_SELF)
        image = np.array(self.mi.render(loaded, spp=samples, seed=seed))[0]
        seconds = cpu(resource.RUSAGE_SELF) - before
        rho = points[2]
        return np.where(rho > 0, np.pi * image / np.maximum(rho, 1e-9), np.nan), seconds

    def runs(self, scene, points):
        loaded = self.scene(scene, points)
        for samples in SAMPLES:
            yield f"{samples} samples", *self.irradiance(loaded, points, samples, samples)


class Radiance:
    name = "Radiance, rtrace"

    def __init__(self, folder):
        self.folder = folder
        found = shutil.which("rtrace")
        if found is None:
            import pyradiance

            found = Path(pyradiance.__file__).parent / "bin" / "rtrace"
        self.bin = Path(found).parent

    def runs(self, scene, points):
        text = []
        for i, (triangles, reflectance, radiance) in enumerate(scene.parts):
            numbers = lambda v: " ".join(f"{x:.9g}" for x in np.ravel(v))
            if radiance.any():
                text.append(f"void light m{i}\n0\n0\n3 {numbers(radiance)}\n")
            else:
                text.append(f"void plastic m{i}\n0\n0\n5 {numbers(reflectance)} 0 0\n")
            polygons = whole(triangles) if radiance.any() else triangles
            text += [f"m{i} polygon p{i}.{k}\n0\n0\n{t.size} {numbers(t)}\n" for k, t in enumerate(polygons)]
        (self.folder / "scene.rad").write_text("\n".join(text))
        tree = subprocess.run([self.bin / "oconv", "scene.rad"], cwd=self.folder, check=True, capture_output=True).stdout
        (self.folder / "scene.oct").write_bytes(tree)
        lines = "\n".join(" ".join(f"{x:.9g}" for x in row) for row in np.hstack(points[:2]))
        is_direct = scene.bounces == "0"
        bounces = "0" if is_direct else str(BOUNCES)
        ladder = [(1, 0, 0, part) for part in PARTS] if is_direct else AMBIENT
        for divisions, samples, accuracy, part in ladder:
            words = ["-h", "-I", "-ab", bounces, "-ad", divisions, "-as", samples, "-aa", accuracy, "-ar", 256]
            words += ["-lw", 1 / divisions**2, "-ds", part, "-dj", 0.7, "-dt", 0, "-dc", 1]
            before = cpu(resource.RUSAGE_CHILDREN)
            run = subprocess.run([self.bin / "rtrace", *map(str, words), "scene.oct"], cwd=self.folder, check=True, capture_output=True, text=True, input=lines)
            seconds = cpu(resource.RUSAGE_CHILDREN) - before
            yield f"-ds {part}" if is_direct else f"-ad {divisions} -aa {accuracy}", np.array([l.split() for l in run.stdout.splitlines()], float), seconds


def write_ply(path, triangles):
    corners = triangles.reshape(-1, 3)
    head = f"ply\nformat ascii 1.0\nelement vertex {len(corners)}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = "".join("%.9g %.9g %.9g\n" % tuple(c) for c in corners)
    path.write_text(head + rows + "".join(f"3 {3 * i} {3 * i + 1} {3 * i + 2}\n" for i in range(len(triangles))))


def scenes(umbrage):
    lit = umbrage.folder / "cornell.glb"
    subprocess.run([umbrage.program, "bake", "--error", "0.5", "-o", lit, "--quiet"], cwd=umbrage.folder, check=True)
    yield Scene("cornell-box", None, read_lit(lit), False, "all"), read_lit(lit)
    for name in ["square-over-square", "blinds"]:
        path = ROOT / "fixtures" / "scenes" / name / f"{name}.obj"
        lit = umbrage.folder / f"{name}.glb"
        subprocess.run([umbrage.program, "bake", path, "--error", "0.5", "--bounces", "0", "-o", lit, "--quiet"], cwd=umbrage.folder, check=True)
        yield Scene(name, str(path), read_obj(path), True, "0"), read_lit(lit)


def relative_rms(found, reference):
    both = ~(np.isnan(found) | np.isnan(reference))
    return np.sqrt(np.mean((found - reference)[both] ** 2)) / np.mean(reference[both])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("peers"))
    parser.add_argument("--points", type=int, default=1000, help="measuring points on each scene")
    parser.add_argument("--umbrage", default=str(ROOT / "target" / "release" / "umbrage"))
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix="umbrage-peers-"))
    umbrage = Umbrage(args.umbrage, folder)
    mitsuba = Mitsuba(folder)
    peers = [umbrage, mitsuba]
    try:
        peers.append(Radiance(folder))
    except ImportError:
        print("Radiance is not here (pip install pyradiance): left out", file=sys.stderr)
    rows = []
    for scene, surfaces in scenes(umbrage):
        points = spread(surfaces, args.points)
        if scene.bounces == "0":
            # Direct light from polygons is known in closed form.
            reference, _ = umbrage.probe(scene, points, "--from", "exact")
            noise = 0.0
        else:
            # Two halves with fresh seeds: half of their difference is the noise of their mean.
            loaded = mitsuba.scene(scene, points)
            half = [mitsuba.irradiance(loaded, points, REFERENCE_SAMPLES // 2, 10**6 + k)[0] for k in (1, 2)]
            reference = (half[0] + half[1]) / 2
            noise = relative_rms(half[0], half[1]) / 2
        print(f"{scene.name}: reference with {100 * noise:.3f} % of noise")
        curves = []
        for peer in peers:
            curve = []
            for what, found, seconds in peer.runs(scene, points):
                rms = relative_rms(found, reference)
                rows.append([scene.name, peer.name, what, f"{rms:.6f}", f"{seconds:.3f}"])
                print(f"  {peer.name:<24} {what:<20} {100 * rms:7.3f} %  {seconds:8.2f} s CPU", flush=True)
                curve.append((seconds, 100 * rms))
            curves.append((peer.name, curve))
        title = f"{scene.name}: irradiance at {args.points} points"
        (args.output / f"{scene.name}.svg").write_text(plot.svg(title, "CPU seconds", "RMS error, % of the mean", curves))
    with open(args.output / "peers.csv", "w", newline="") as file:
        csv.writer(file).writerows([["scene", "program", "settings", "rms", "cpu_seconds"], *rows])
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
