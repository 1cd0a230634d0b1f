#!/usr/bin/env python3
"""Writes every file under fixtures/scenes: python3 tools/make_fixtures.py [--check | --table]

Without an option the files are (re)written, always with the same bytes. --check writes nothing and exits with 1 when a
file differs; --table prints the scenes with their polygon counts, as in fixtures/README.md. Standard library only.

Coordinates are metres, y up. All are rounded to multiples of 2^-16 m, so that rotating never leaves a face bent out of
an axis-parallel plane, and so that moving a scene by 10^6 times its size is exact in double precision.
"""

import math
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent / "fixtures" / "scenes"
GRID = 65536.0
UP, DOWN = (0, 1, 0), (0, -1, 0)
EAST, WEST = (1, 0, 0), (-1, 0, 0)
SOUTH, NORTH = (0, 0, 1), (0, 0, -1)

# Emission (Ke) is radiance, W/(m2 sr). In the furnace every surface leaves 1 W/m2: exitance 1 - rho, radiance (1 - rho)/pi.
FURNACE = [("r10", 0.1), ("r50", 0.5), ("r90", 0.9), ("r99", 0.99)]
MATERIALS = [
    ("floor", (0.5, 0.5, 0.5), (0, 0, 0)),
    ("blocker", (0.3, 0.3, 0.3), (0, 0, 0)),
    ("wall", (0.7, 0.7, 0.7), (0, 0, 0)),
    ("red-wall", (0.6, 0.1, 0.1), (0, 0, 0)),
    ("green-wall", (0.1, 0.5, 0.1), (0, 0, 0)),
    ("wood", (0.5, 0.35, 0.2), (0, 0, 0)),
    ("lamp", (0, 0, 0), (1, 1, 1)),
    ("white-lamp", (0.7, 0.7, 0.7), (1, 1, 1)),
    ("red-lamp", (0, 0, 0), (2, 0.25, 0.125)),
    ("blue-lamp", (0, 0, 0), (0.125, 0.25, 2)),
    ("window", (0, 0, 0), (20, 20, 20)),
] + [("furnace-" + n, (r, r, r), ((1 - r) / math.pi,) * 3) for n, r in FURNACE]


def number(x):
    return "%.17g" % (x + 0.0)  # + 0.0: no "-0"


def snap(x):
    return round(x * GRID) / GRID


class Scene:
    """Objects, each with its own vertices and its polygons."""

    def __init__(self, about):
        self.about = about
        self.objects = []

    def object(self, name):
        self.objects.append((name, {}, []))
        return self

    def polygon(self, material, towards, *corners):
        """A convex polygon of the current object whose front (counter-clockwise) side faces `towards`."""
        corners = [tuple(snap(x) for x in c) for c in corners]
        if dot(newell(corners), towards) < 0:
            corners.reverse()
        _, vertices, polygons = self.objects[-1]
        polygons.append((material, [vertices.setdefault(c, len(vertices)) for c in corners]))
        return self

    def polygons(self):
        return sum(len(polygons) for _, _, polygons in self.objects)

    def text(self, move=lambda x: x):
        lines = ["# " + line for line in self.about] + ["mtllib ../common.mtl"]
        first = 1
        for name, vertices, polygons in self.objects:
            lines.append("o " + name)
            lines += ["v " + " ".join(number(move(x)) for x in v) for v in vertices]
            last_material = None
            for material, corners in polygons:
                if material != last_material:
                    lines.append("usemtl " + material)
                    last_material = material
                lines.append("f " + " ".join(str(first + c) for c in corners))
            first += len(vertices)
        return "\n".join(lines) + "\n"


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def newell(corners):
    n = [0.0, 0.0, 0.0]
    for a, b in zip(corners, corners[1:] + corners[:1]):
        for i, (j, k) in enumerate([(1, 2), (2, 0), (0, 1)]):
            n[i] += (a[j] - b[j]) * (a[k] + b[k])
    return n


def turned(x, z, angle, at=(0, 0)):
    """A point turned about the vertical through `at` (seen from above, from +z towards +x)."""
    c, s = math.cos(angle), math.sin(angle)
    return at[0] + c * x + s * z, at[1] - s * x + c * z


def level(scene, material, towards, y, half_x, half_z, at=(0, 0), angle=0.0):
    """A horizontal rectangle."""
    corners = [turned(sx * half_x, sz * half_z, angle, at) for sx, sz in [(-1, -1), (1, -1), (1, 1), (-1, 1)]]
    return scene.polygon(material, towards, *[(x, y, z) for x, z in corners])


def upright(scene, material, towards, a, b, y0, y1):
    """A vertical rectangle over the ground segment a-b."""
    return scene.polygon(material, towards, (a[0], y0, a[1]), (b[0], y0, b[1]), (b[0], y1, b[1]), (a[0], y1, a[1]))


def prism(scene, material, footprint, y0, y1, inward=False, bottom=True, top=True):
    """A vertical prism over a convex footprint; fronts face outwards, or inwards for a room."""
    sign = -1 if inward else 1
    centre = [sum(p[i] for p in footprint) / len(footprint) for i in (0, 1)]
    for a, b in zip(footprint, footprint[1:] + footprint[:1]):
        middle = ((a[0] + b[0]) / 2 - centre[0], 0, (a[1] + b[1]) / 2 - centre[1])
        n = newell([(a[0], y0, a[1]), (b[0], y0, b[1]), (b[0], y1, b[1]), (a[0], y1, a[1])])
        outward = 1 if dot(n, middle) > 0 else -1
        upright(scene, material, tuple(sign * outward * x for x in n), a, b, y0, y1)
    if bottom:
        scene.polygon(material, (0, -sign, 0), *[(x, y0, z) for x, z in footprint])
    if top:
        scene.polygon(material, (0, sign, 0), *[(x, y1, z) for x, z in footprint])
    return scene


def rectangle(half_x, half_z, at=(0, 0), angle=0.0):
    return [turned(sx * half_x, sz * half_z, angle, at) for sx, sz in [(-1, -1), (1, -1), (1, 1), (-1, 1)]]


def floor(scene, half=3.0):
    return level(scene.object("floor"), "floor", UP, 0, half, half)


def lamp(scene, y=2.0, half=0.5, material="lamp", at=(0, 0)):
    return level(scene.object(material), material, DOWN, y, half, half, at)


# --- shadow scenes: a floor, an emitter, blockers -------------------------------------------------------------------


def square_over_square():
    s = Scene([
        "Square emitter of side a = 1 at H = 2 over a parallel, centred square blocker of side b = 1 at h = 1.",
        "On the floor the penumbra's outer half side is (b/2) H/(H-h) + (a/2) h/(H-h) = 1.5, the umbra's 0.5.",
    ])
    level(lamp(floor(s)).object("blocker"), "blocker", UP, 1, 0.5, 0.5)
    return s


def rotated_blocker():
    s = Scene(["As square-over-square, but the blocker is turned by 0.3 rad: no edge is parallel to an emitter edge."])
    level(lamp(floor(s)).object("blocker"), "blocker", UP, 1, 0.5, 0.5, angle=0.3)
    return s


def tilted_triangle():
    s = Scene(["A triangle with corners at three different heights under a square emitter: all events are generic."])
    lamp(floor(s)).object("blocker")
    return s.polygon("blocker", UP, (-0.5, 0.7, -0.4), (0.6, 1.1, -0.2), (-0.1, 1.4, 0.55))


def crossing_blockers():
    s = Scene([
        "Two bars at different heights that cross when seen from the emitter but do not touch:",
        "skew edges of emitter, upper and lower bar make EEE events, edge over edge makes NVE events.",
    ])
    lamp(floor(s))
    level(s.object("lower-bar"), "blocker", UP, 0.75, 1.0, 0.15, angle=0.3)
    level(s.object("upper-bar"), "blocker", UP, 1.25, 0.15, 0.8, angle=0.45)
    return s


def blocker_touching_floor():
    s = Scene(["A wall that stands on the floor: a D0 contact line where the light jumps, in the floor's interior."])
    lamp(floor(s), at=(0.75, 0.5)).object("wall")
    return upright(s, "blocker", EAST, turned(0, -0.8, 0.2), turned(0, 0.8, 0.2), 0, 1)


def box_on_table():
    s = Scene([
        "A slab table with two boxes on it: one without a bottom, one whose bottom is coplanar with the table top.",
    ])
    lamp(floor(s), y=2.5)
    prism(s.object("table-top"), "wood", rectangle(0.8, 0.5), 0.7, 0.75)
    prism(s.object("open-box"), "blocker", rectangle(0.15, 0.1, (-0.35, 0.05), 0.4), 0.75, 1.05, bottom=False)
    prism(s.object("closed-box"), "blocker", rectangle(0.1, 0.2, (0.4, -0.1)), 0.75, 1.25)
    return s


def wall_piercing_floor():
    s = Scene([
        "A wall that goes through the floor, from half a metre below it to one metre above:",
        "the contact line is where two faces cross and no vertex of the wall lies on it.",
    ])
    lamp(floor(s), at=(0.75, 0.5)).object("wall")
    return upright(s, "blocker", EAST, turned(0, -0.8, 0.2), turned(0, 0.8, 0.2), -0.5, 1)


def coplanar_edges():
    s = Scene([
        "Every blocker edge lies in one plane with an emitter edge, two of them without being parallel to it:",
        "the left edges share the plane x = -0.5, the right ones the plane x = 0.5 - (2 - y)/4. Each pair makes one D1 line.",
    ])
    lamp(floor(s)).object("blocker")
    return s.polygon("blocker", UP, (-0.5, 0.875, -0.5), (0.21875, 0.875, -0.5), (0.28125, 1.125, 0.5), (-0.5, 1.125, 0.5))


def receiver_through_emitter():
    s = Scene([
        "The plane of the floor cuts the upright emitter in half: only the part above the horizon lights the floor.",
        "The floor ends before the emitter; a low post stands between.",
    ])
    s.object("floor").polygon("floor", UP, (-2, 0, -2), (1, 0, -2), (1, 0, 2), (-2, 0, 2))
    upright(s.object("lamp"), "lamp", WEST, (1.5, -0.5), (1.5, 0.5), -0.5, 0.5)
    return upright(s.object("post"), "blocker", EAST, (0.25, -0.125), (0.375, 0.125), 0, 0.25)


def emitter_plane_on_receiver():
    s = Scene([
        "The emitter's plane x = (y - 1)/2 meets the floor along x = -0.5: beyond that line the emitter shows its dark back.",
        "A D1 line without any blocker.",
    ])
    floor(s).object("lamp")
    return s.polygon("lamp", (2, -1, 0), (0, 1, -0.5), (0.25, 1.5, -0.5), (0.25, 1.5, 0.5), (0, 1, 0.5))


def back_facing_emitter():
    s = Scene([
        "An emitter that faces up: the floor behind it gets no direct light, the ceiling before it does;",
        "a blocker between emitter and ceiling throws its shadow upwards, one below the emitter throws none.",
    ])
    floor(s)
    level(s.object("ceiling"), "floor", DOWN, 3, 3, 3)
    level(s.object("lamp"), "lamp", UP, 1, 0.5, 0.5)
    level(s.object("upper-blocker"), "blocker", UP, 2, 0.25, 0.25, (0.25, 0.125))
    level(s.object("lower-blocker"), "blocker", UP, 0.5, 0.25, 0.25, (0.25, 0.125))
    return s


def tiles(scene, material, towards, y, size, cells):
    """Squares of side `size` on a grid; neighbours share their corners."""
    for i, k in cells:
        x, z = i * size, k * size
        scene.polygon(material, towards, (x, y, z), (x + size, y, z), (x + size, y, z + size), (x, y, z + size))
    return scene


def non_convex_emitter():
    s = Scene(["An L-shaped emitter made of three squares which merge into one face with a reflex corner."])
    floor(s)
    tiles(s.object("lamp"), "lamp", DOWN, 2, 0.5, [(-1, -1), (0, -1), (-1, 0)])
    level(s.object("blocker"), "blocker", UP, 1, 0.4, 0.3, angle=0.3)
    return s


def emitter_with_hole():
    s = Scene(["A square emitter with a square hole, made of a ring of eight squares which merge into one face."])
    floor(s)
    ring = [(i, k) for k in (-1, 0, 1) for i in (-1, 0, 1) if (i, k) != (0, 0)]
    s.object("lamp")
    for i, k in ring:
        x, z = (i - 0.5) * 0.375, (k - 0.5) * 0.375
        s.polygon("lamp", DOWN, (x, 2, z), (x + 0.375, 2, z), (x + 0.375, 2, z + 0.375), (x, 2, z + 0.375))
    level(s.object("blocker"), "blocker", UP, 1, 0.5, 0.25, angle=0.3)
    return s


def two_emitters():
    s = Scene(["A red and a blue emitter over one blocker: the light is the sum of what each gives alone, each with its own lines."])
    floor(s)
    lamp(s, 2.0, 0.25, "red-lamp", (-1, 0))
    lamp(s, 2.5, 0.375, "blue-lamp", (0.875, 0.5))
    level(s.object("blocker"), "blocker", UP, 1, 0.5, 0.5, angle=0.3)
    return s


# --- closed rooms ---------------------------------------------------------------------------------------------------


def furnace_box(material):
    s = Scene(["A closed box 2 x 1.5 x 1 m in which every surface leaves 1 W/m2 whatever its reflectance."])
    return prism(s.object("room"), material, [(0, 0), (2, 0), (2, 1), (0, 1)], 0, 1.5, inward=True)


def furnace_l_room(material):
    s = Scene(["A closed L-shaped room, not convex: some walls do not see each other. Every surface leaves 1 W/m2."])
    return l_shell(s.object("room"), material, material, material, 1.0, 1.5)


def l_shell(s, floor_material, wall_material, ceiling_material, side, height):
    """Room over three squares in an L: floor and ceiling in squares, walls one quad for each square's outer side."""
    cells = [(0, 0), (1, 0), (0, 1)]
    tiles(s, floor_material, UP, 0, side, cells)
    tiles(s, ceiling_material, DOWN, height, side, cells)
    for i, k in cells:
        for (di, dk), inward in [((-1, 0), EAST), ((1, 0), WEST), ((0, -1), SOUTH), ((0, 1), NORTH)]:
            if (i + di, k + dk) in cells:
                continue
            if di:
                x = (i + (di + 1) // 2) * side
                a, b = (x, k * side), (x, (k + 1) * side)
            else:
                z = (k + (dk + 1) // 2) * side
                a, b = (i * side, z), ((i + 1) * side, z)
            upright(s, wall_material, inward, a, b, 0, height)
    return s


def furnace_cornell(material):
    s = Scene([
        "A closed cube with a low and a tall box standing on its floor, all surfaces alike: every point that light can reach",
        "leaves 1 W/m2. The boxes have no bottoms; inside of them and under them (which nothing outside sees) it is darker.",
    ])
    prism(s.object("room"), material, [(-1, -1), (1, -1), (1, 1), (-1, 1)], 0, 2, inward=True)
    prism(s.object("low-box"), material, rectangle(0.3, 0.3, (0.35, 0.4), -0.3), 0, 0.6, bottom=False)
    prism(s.object("tall-box"), material, rectangle(0.3, 0.3, (-0.35, -0.3), 0.35), 0, 1.2, bottom=False)
    return s


def l_room():
    s = Scene(["An L-shaped room of three 2 m squares with one lamp at the end of one arm: the other arm has only indirect light."])
    l_shell(s.object("room"), "floor", "wall", "wall", 2.0, 2.5)
    level(s.object("lamp"), "lamp", DOWN, 2.25, 0.25, 0.25, (3.25, 1.0))
    return s


def blinds():
    s = Scene([
        "A room 4 x 3 x 3 m lit through 20 slats by a 1.5 x 1.5 m window: narrow penumbrae, many parallel edges, contacts.",
    ])
    prism(s.object("room"), "wall", [(0, 0), (4, 0), (4, 3), (0, 3)], 0, 3, inward=True)
    upright(s.object("window"), "window", EAST, (1 / 64, 0.75), (1 / 64, 2.25), 0.75, 2.25)
    # A slat's cross-section is a rectangle 70 mm deep, 4 mm thick, hanging towards the room.
    deep, thick = (1 / 16, -1 / 32), (1 / 512, 1 / 256)
    for i in range(20):
        s.object("slat-%02d" % (i + 1))
        x, y = 1 / 16, 0.8 + 0.075 * i
        x, y = snap(x), snap(y)
        section = [(x, y), (x + deep[0], y + deep[1]), (x + deep[0] + thick[0], y + deep[1] + thick[1]), (x + thick[0], y + thick[1])]
        z0, z1 = 0.6875, 2.3125
        for j in range(4):
            (ax, ay), (bx, by) = section[j], section[(j + 1) % 4]
            s.polygon("blocker", (by - ay, ax - bx, 0), (ax, ay, z0), (bx, by, z0), (bx, by, z1), (ax, ay, z1))
        s.polygon("blocker", NORTH, *[(x, y, z0) for x, y in section])
        s.polygon("blocker", SOUTH, *[(x, y, z1) for x, y in section])
    prism(s.object("table-top"), "wood", rectangle(0.7, 0.4, (2, 1.5)), 0.7, 0.75)
    for i, (x, z) in enumerate([(1.4, 1.2), (2.6, 1.2), (2.6, 1.8), (1.4, 1.8)]):
        prism(s.object("leg-%d" % (i + 1)), "wood", rectangle(0.03, 0.03, (x, z)), 0, 0.7, bottom=False, top=False)
    prism(s.object("box-on-table"), "red-wall", rectangle(0.15, 0.1, (1.8, 1.45), 0.3), 0.75, 1.0)
    prism(s.object("box-1"), "green-wall", rectangle(0.25, 0.25, (3.2, 0.6), 0.2), 0, 0.5, bottom=False)
    prism(s.object("box-2"), "blocker", rectangle(0.2, 0.3, (3.1, 2.3), -0.4), 0, 0.8, bottom=False)
    prism(s.object("box-3"), "blocker", rectangle(0.2, 0.2, (0.9, 2.5)), 0, 0.4, bottom=False)
    prism(s.object("shelf"), "wood", rectangle(0.125, 0.75, (3.875, 1.5)), 1.5, 1.53125)
    return s


# --- files ----------------------------------------------------------------------------------------------------------

SIMPLE = [
    square_over_square, rotated_blocker, tilted_triangle, crossing_blockers, blocker_touching_floor, box_on_table,
    wall_piercing_floor, coplanar_edges, receiver_through_emitter, emitter_plane_on_receiver, back_facing_emitter,
    non_convex_emitter, emitter_with_hole, two_emitters, l_room, blinds,
]  # fmt: skip
# Size in metres (a power of two near the largest extent: the move is then a whole number of metres).
MOVED = {"square-over-square": 8, "rotated-blocker": 8, "box-on-table": 8, "blinds": 4}


def all_scenes():
    """(name, polygons, text) of each scene."""
    for make in SIMPLE:
        name, scene = make.__name__.replace("_", "-"), make()
        yield name, scene.polygons(), scene.text()
        if name in MOVED:
            for suffix, times in [("t1e4", 1e4), ("t1e6", 1e6)]:
                offset = times * MOVED[name]

                def move(x):
                    assert (x + offset) - offset == x, "the move has to be exact"
                    return x + offset

                yield name + "-" + suffix, scene.polygons(), scene.text(move)
            yield name + "-s1e-3", scene.polygons(), scene.text(lambda x: x / 1000.0)
            yield name + "-s1e3", scene.polygons(), scene.text(lambda x: x * 1000.0)
    for make in [furnace_box, furnace_l_room, furnace_cornell]:
        for suffix, _ in FURNACE:
            scene = make("furnace-" + suffix)
            yield make.__name__.replace("_", "-") + "-" + suffix, scene.polygons(), scene.text()


def material_text():
    lines = ["# Kd is the diffuse reflectance, Ke the emitted radiance in W/(m2 sr)."]
    for name, reflectance, emission in MATERIALS:
        lines += ["newmtl " + name, "Kd " + " ".join(map(repr, reflectance)), "Ke " + " ".join(map(repr, emission))]
    return "\n".join(lines) + "\n"


def main():
    option = sys.argv[1] if len(sys.argv) > 1 else ""
    if option not in ("", "--check", "--table"):
        sys.exit(__doc__)
    if option == "--table":
        for name, polygons, _ in all_scenes():
            print("| `%s` | %d |" % (name, polygons))
        return
    files = [(ROOT / "common.mtl", material_text())]
    files += [(ROOT / name / (name + ".obj"), text) for name, _, text in all_scenes()]
    wrong = 0
    for path, text in files:
        data = text.encode("ascii")
        if option == "--check":
            if not path.exists() or path.read_bytes() != data:
                print("differs: %s" % path.relative_to(ROOT.parent.parent))
                wrong += 1
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
