#!/usr/bin/env python3
"""Bakes the scenes of a folder, draws each with its camera, and puts the pictures on one sheet.

    contact_sheet.py SCENES -o sheet.png [--umbrage PROGRAM] [--only NAME]... [--lit FOLDER] [--timeout S] [-- BAKE OPTIONS]

SCENES holds cameras.json: {"folder/scene.obj": {"eye": [x, y, z], "target": [x, y, z], "hfov_degrees": d}, ...}.
A scene that does not bake is a black tile that says why. Needs Pillow (pip install pillow).
"""

import argparse
import json
import pathlib
import resource
import subprocess
import sys

from PIL import Image, ImageDraw

TILE = (480, 320)
COLUMNS = 3
CAPTION = 34
# A picture of 256 steps shows bands when it is brightened more.
MOST_GAIN = 16


def arguments():
    own, bake = sys.argv[1:], []
    if "--" in own:
        cut = own.index("--")
        own, bake = own[:cut], own[cut + 1 :]
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("scenes", type=pathlib.Path)
    p.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("sheet.png"))
    p.add_argument("--umbrage", default="target/release/umbrage")
    p.add_argument("--only", action="append", default=[], help="part of a scene's path; may be repeated")
    p.add_argument("--lit", type=pathlib.Path, default=pathlib.Path("lit"), help="keeps baked files and pictures; what is there is not baked again")
    p.add_argument("--timeout", type=float, default=900, help="seconds of wall clock a scene")
    args = p.parse_args(own)
    args.bake = bake or ["--error", "0.03"]
    return args


def run(command, timeout):
    """None when all went well, else what went wrong; and the CPU seconds it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        lines = done.stderr.strip().splitlines()
        fault = None if done.returncode == 0 else (lines or ["no message"])[-1]
    except subprocess.TimeoutExpired:
        fault = f"not done after {timeout:.0f} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return fault, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def facts(report, seconds):
    """A line about a bake from its summary for machines."""
    s = json.loads(report.read_text())["summary"]
    peak = max((t["peak_memory_bytes"] or 0) for t in s["stages"])
    cpu = "" if seconds is None else f", {seconds:.0f} s CPU"
    return f"{s['elements']} elements, {100 * s['measured']['relative_rms']:.2f} %, {peak / 1e6:.0f} MB{cpu}"


def vector(v):
    return ",".join(str(x) for x in v)


def tile(args, name, camera):
    """The picture of one scene, and what to write below it."""
    stem = args.lit / pathlib.Path(name).name
    lit, report, picture = (stem.with_suffix(s) for s in (".lit.glb", ".json", ".png"))
    seconds = None
    if not lit.exists():
        bake = [args.umbrage, "bake", str(args.scenes / name), "-o", str(lit), "--json", str(report)]
        fault, seconds = run(bake + args.bake, args.timeout)
        if fault:
            return None, fault
    draw = [args.umbrage, "render", str(lit), "-o", str(picture), "--size", "{}x{}".format(*TILE)]
    view = [f"--eye={vector(camera['eye'])}", f"--target={vector(camera['target'])}"]
    fault, _ = run(draw + view + ["--hfov", str(camera["hfov_degrees"])], args.timeout)
    if fault:
        return None, fault
    shown, gain = brightened(Image.open(picture).convert("RGB"))
    return shown, facts(report, seconds) + ("" if gain == 1 else f", shown {gain:.0f} times as bright")


def brightened(picture):
    """A dark picture with its brightest hundredth at white, and by what its light was multiplied."""
    counts = picture.convert("L").histogram()
    seen, level = 0, 255
    while level > 1 and seen + counts[level] < 0.01 * sum(counts):
        seen += counts[level]
        level -= 1
    gain = min(MOST_GAIN, 1 / linear(level / 255))
    if gain < 2:
        return picture, 1
    table = [round(255 * encoded(min(1, gain * linear(i / 255)))) for i in range(256)]
    return picture.point(table * 3), gain


def linear(x):
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


def encoded(x):
    return 12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055


def sheet(tiles):
    width, height = TILE[0], TILE[1] + CAPTION
    rows = -(-len(tiles) // COLUMNS)
    page = Image.new("RGB", (COLUMNS * width, rows * height), "white")
    pen = ImageDraw.Draw(page)
    for i, (name, picture, text) in enumerate(tiles):
        x, y = i % COLUMNS * width, i // COLUMNS * height
        page.paste(picture or Image.new("RGB", TILE, "black"), (x, y))
        pen.text((x + 6, y + TILE[1] + 3), name, fill="black")
        pen.text((x + 6, y + TILE[1] + 17), text[:80], fill="black" if picture else "red")
    return page


def main():
    args = arguments()
    cameras = json.loads((args.scenes / "cameras.json").read_text())
    args.lit.mkdir(parents=True, exist_ok=True)
    tiles = []
    for name, camera in cameras.items():
        if args.only and not any(part in name for part in args.only):
            continue
        picture, text = tile(args, name, camera)
        print(f"{name}: {text}", flush=True)
        tiles.append((name, picture, text))
    if not tiles:
        sys.exit("no scene of cameras.json has such a name")
    sheet(tiles).save(args.output)
    print(f"written {args.output}")
    sys.exit(0 if all(picture for _, picture, _ in tiles) else 1)


if __name__ == "__main__":
    main()
