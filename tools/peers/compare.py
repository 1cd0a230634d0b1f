#!/usr/bin/env python3
"""Error against CPU time of umbrage and of its peers, on the same scenes and machine. Run by peers.py."""
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
ERRORS = [0.2, 0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002]
FINER = [0.001]  # Where there is direct light alone.
SAMPLES = [1, 4, 16, 64, 256, 1024, 4096, 16384]
PASS = 256  # Samples at a time: a wavefront of more does not fit into memory.
AMBIENT = [(32, 8, 0.4, 0.1), (128, 32, 0.3, 0.075), (512, 128, 0.2, 0.05)]
PARTS = [0.4, 0.2, 0.1, 0.05]  # Radiance makes at most 64 parts of a lamp.
# Samples of each of two references where light between surfaces is part of it, with fresh seeds.
REFERENCE_SAMPLES = 32768
BOUNCES = 8
# Errors at which the times are compared.
COMPARED = [0.03, 0.01, 0.003]
# Direct light alone is measured relative to itself, or in the dark to this share of the mean.
DARK_SHARE = 0.05


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
        for error in ERRORS if scene.bounces != "0" else [*ERRORS, *FINER]:
            yield f"--error {error}", *self.probe(scene, points, "--error", str(error))


class Mitsuba:
    name = "Mitsuba 3, path tracer"

    def __init__(self, folder):
        import mitsuba

        self.mi, self.folder = mitsuba, folder
        mitsuba.set_variant("llvm_ad_rgb")

    def scene(self, scene):
        made = {"type": "scene"}
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
        depth = 2 if scene.bounces == "0" else -1
        integrator = self.mi.load_dict({"type": "path", "max_depth": depth})
        # Rays start 9e-5 m after their origin (Mitsuba's epsilon in single precision): those that look at a point start higher.
        above = 1e-3 * np.ptp(np.concatenate([t.reshape(-1, 3) for t, _, _ in scene.parts]), axis=0).max()
        return self.mi.load_dict(made), integrator, above

    def irradiance(self, loaded, points, samples, seed):
        """From the radiance of a ray from just above each point straight down on it: ρ E / π."""
        mi, (scene, integrator, above) = self.mi, loaded
        positions, normals, rho = points
        before = cpu(resource.RUSAGE_SELF)
        sums, done = 0.0, 0
        while done < samples:
            count = min(samples - done, PASS)
            spread = lambda v: mi.Vector3f(*(mi.Float(np.repeat(c, count)) for c in v.T))
            ray = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(spread(positions + above * normals)), spread(-normals)))
            sampler = mi.load_dict({"type": "independent"})
            sampler.seed(seed + done, len(positions) * count)
            found, _, _ = integrator.sample(scene, sampler, ray)
            sums = sums + np.array(found).T.reshape(len(positions), count, 3).sum(axis=1)
            done += count
        seconds = cpu(resource.RUSAGE_SELF) - before
        return np.where(rho > 0, np.pi * sums / samples / np.maximum(rho, 1e-9), np.nan), seconds

    def runs(self, scene, points):
        loaded = self.scene(scene)
        self.irradiance(loaded, points, 1, 0)  # Compiling is not counted.
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
    for name, bounces in [("square-over-square", "0"), ("blinds", "all")]:
        path = ROOT / "fixtures" / "scenes" / name / f"{name}.obj"
        lit = umbrage.folder / f"{name}.glb"
        subprocess.run([umbrage.program, "bake", path, "--error", "0.5", "--bounces", "0", "-o", lit, "--quiet"], cwd=umbrage.folder, check=True)
        yield Scene(name, str(path), read_obj(path), True, bounces), read_lit(lit)


def relative_rms(found, references, is_direct):
    """RMS error relative to the mean; of direct light to each value, in the dark to DARK_SHARE of the mean.

    The product of the differences from two independent references is, in the mean, the squared error without their noise.
    """
    first, second = references
    known = ~(np.isnan(found) | np.isnan(first) | np.isnan(second))
    mean = np.mean((first + second)[known]) / 2
    scale = np.maximum((first + second)[known] / 2, DARK_SHARE * mean) if is_direct else mean
    products = (found - first)[known] * (found - second)[known] / scale**2
    # No less than the references can tell: the standard error of that mean.
    least = 0.0 if is_direct else np.std(products) / np.sqrt(products.size)
    return np.sqrt(max(np.mean(products), least))


def time_to(error, curve, is_sampled):
    """CPU seconds for an error, from log to log between runs, and whether that lies beyond them.

    Beyond its last run what is sampled takes four times the time for half of the error; others have no time for it.
    """
    best = []
    for seconds, rms in sorted(curve):
        if not best or rms < best[-1][1]:
            best.append((seconds, rms))
    if error >= best[0][1]:
        return best[0][0], True
    for (s, e), (t, f) in zip(best, best[1:]):
        if f <= error:
            return s * (t / s) ** (np.log(e / error) / np.log(e / f)), False
    return (best[-1][0] * (best[-1][1] / error) ** 2, True) if is_sampled else (None, True)


def ratios(name, curves):
    """Rows of CPU time over umbrage's at each error compared: scene, program, error, seconds, ratio, what it rests on."""
    ours = curves[0][1]
    for peer, curve in curves[1:]:
        for error in COMPARED:
            (time, is_beyond), (mine, is_less) = time_to(error, curve, peer.startswith("Mitsuba")), time_to(error, ours, False)
            if time is None or mine is None:
                yield name, peer, error, time, None, "not reached"
            else:
                said = ["beyond its runs"] * is_beyond + ["umbrage's coarsest run is finer"] * is_less
                yield name, peer, error, time, time / mine, ", ".join(said)


def write_rows(path, head, rows):
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("peers"))
    parser.add_argument("--points", type=int, default=5000, help="measuring points on each scene")
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
    rows, compared, panels = [], [], []
    for scene, surfaces in scenes(umbrage):
        points = spread(surfaces, args.points)
        is_direct = scene.bounces == "0"
        if is_direct:
            # Direct light from polygons is known in closed form.
            references = [umbrage.probe(scene, points, "--from", "exact")[0]] * 2
            light = "direct light"
        else:
            loaded = mitsuba.scene(scene)
            references = [mitsuba.irradiance(loaded, points, REFERENCE_SAMPLES, 10**6 * k)[0] for k in (1, 2)]
            light = "all bounces"
        print(f"{scene.name}, {light}", flush=True)
        curves = []
        for peer in peers:
            curve = []
            for what, found, seconds in peer.runs(scene, points):
                rms = relative_rms(found, references, is_direct)
                rows.append([scene.name, peer.name, what, f"{rms:.6f}", f"{seconds:.3f}"])
                print(f"  {peer.name:<24} {what:<20} {100 * rms:7.3f} %  {seconds:8.2f} s CPU", flush=True)
                curve.append((seconds, rms))
            curves.append((peer.name, curve))
        notes = []
        for row in ratios(scene.name, curves):
            compared.append(row)
            _, peer, error, _, ratio, said = row
            figure = f"{ratio:.3g} times umbrage's" if ratio else "not reached"
            notes.append((peer, error, f"{ratio:.3g}×" if ratio else "–", bool(ratio and said)))
            print(f"  {peer:<24} time to {100 * error:g} %: {figure}" + (f" ({said})" if ratio and said else ""), flush=True)
        scale = f"of E or {100 * DARK_SHARE:g} % of the mean" if is_direct else "of the mean"
        title = f"{scene.name}, {light}: irradiance at {args.points} points"
        panels.append(plot.Panel(title, "CPU seconds", f"RMS error, % {scale}", curves, notes))
        (args.output / "peers.svg").write_text(plot.svg(panels, COMPARED))
        write_rows(args.output / "peers.csv", ["scene", "program", "settings", "rms", "cpu_seconds"], rows)
        write_rows(args.output / "ratios.csv", ["scene", "program", "rms", "cpu_seconds", "over_umbrage", "note"], compared)
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
