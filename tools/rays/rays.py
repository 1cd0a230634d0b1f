#!/usr/bin/env python3
"""Any-hit rays a second on one core: umbrage's ray caster beside Embree, on the same rays.

    pip install -r tools/rays/requirements.txt
    python3 tools/rays/rays.py SCENE.obj [SCENE.glb ...]

Builds and runs the example `rays` for each scene, gives the rays that it wrote to Embree (embreex, its single-precision
triangle test), and prints both rates, their ratio, and on how many rays the two do not agree.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

# One core for both.
os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROUNDS = 5


def ours(scene, out):
    """Runs the example; returns its rate in millions a second and its line."""
    command = ["cargo", "run", "--release", "--quiet", "--example", "rays", "--", scene, out]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr.strip())
    return float(re.search(r"([0-9.]+) million", done.stdout).group(1)), done.stdout.strip()


def read(path):
    """Triangles, ray starts and ways, and what the example found."""
    data = pathlib.Path(path).read_bytes()
    triangles, rays = np.frombuffer(data, "<u4", 2)
    at = 8
    corners = np.frombuffer(data, "<f4", triangles * 9, at).reshape(-1, 3, 3)
    at += triangles * 36
    both = np.frombuffer(data, "<f4", rays * 6, at).reshape(-1, 2, 3)
    at += rays * 24
    return corners, both[:, 0].copy(), both[:, 1].copy(), np.frombuffer(data, "u1", rays, at) == 1


def embree(corners, starts, ways):
    """Its best rate in millions a second, and which rays are hidden."""
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, corners)
    lengths = np.ones(len(starts), "f4")
    best, hits = float("inf"), None
    for _ in range(ROUNDS):
        start = time.perf_counter()
        hits = scene.run(starts, ways, dists=lengths, query="OCCLUDED")
        best = min(best, time.perf_counter() - start)
    return len(starts) / best / 1e6, np.asarray(hits) == 0


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__.strip())
    for scene in map(os.path.abspath, sys.argv[1:]):
        with tempfile.TemporaryDirectory() as directory:
            out = os.path.join(directory, "rays.bin")
            rate, line = ours(scene, out)
            corners, starts, ways, hidden = read(out)
            their_rate, their_hidden = embree(corners, starts, ways)
        off = np.count_nonzero(hidden != their_hidden) / len(hidden)
        print(f"{os.path.basename(scene)}: {line}")
        print(
            f"  Embree {their_rate:.3f} million rays a second, {np.mean(their_hidden):.3f} hidden; "
            f"ours is {rate / their_rate:.2f} of that; they differ on {off:.2e} of the rays",
            flush=True,
        )


if __name__ == "__main__":
    main()
