"""Scenes and measuring points that every program gets alike."""
import json
import struct

import numpy as np


class Scene:
    """Triangles by material, and points with normals and reflectances at which irradiance is asked for."""

    def __init__(self, name, argument, parts, is_two_sided, bounces):
        self.name = name
        self.argument = argument  # What umbrage is given; none for its built-in scene.
        self.parts = parts  # (triangles n × 3 × 3, reflectance, radiance)
        self.is_two_sided = is_two_sided
        self.bounces = bounces


def read_obj(path):
    """Parts of an OBJ with convex polygons, by material."""
    materials, name = {}, None
    text = path.read_text()
    library = next(line.split()[1] for line in text.splitlines() if line.startswith("mtllib"))
    for words in map(str.split, (path.parent / library).read_text().splitlines()):
        if words[:1] == ["newmtl"]:
            name = words[1]
            materials[name] = {"Kd": [0.5] * 3, "Ke": [0.0] * 3}
        elif words[:1] in (["Kd"], ["Ke"]):
            materials[name][words[0]] = [float(w) for w in words[1:4]]
    points, faces, current = [], {}, None
    for words in map(str.split, text.splitlines()):
        if words[:1] == ["v"]:
            points.append([float(w) for w in words[1:4]])
        elif words[:1] == ["usemtl"]:
            current = words[1]
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) for w in words[1:]]
            corners = [points[c - 1 if c > 0 else c] for c in corners]
            fan = [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
            faces.setdefault(current, []).extend(fan)
    return [(np.array(t), np.array(materials[m]["Kd"]), np.array(materials[m]["Ke"])) for m, t in faces.items()]


def read_lit(path):
    """Parts of a lit glTF: triangles, reflectance, radiance."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    gltf, blob = json.loads(data[20 : 20 + length]), data[28 + length :]

    def accessor(i):
        a = gltf["accessors"][i]
        view = gltf["bufferViews"][a["bufferView"]]
        kind = {5126: np.float32, 5125: np.uint32, 5123: np.uint16, 5121: np.uint8}[a["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        return np.frombuffer(blob, kind, a["count"] * width, start).reshape(-1, width)

    root = gltf["nodes"][gltf["scenes"][gltf.get("scene", 0)]["nodes"][0]]
    origin = np.array(root.get("translation", [0.0] * 3))
    parts = []
    for node in (gltf["nodes"][i] for i in root.get("children", [])):
        for p in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            corners = accessor(p["attributes"]["POSITION"]).astype(float) + origin
            triangles = corners[accessor(p["indices"]).ravel()].reshape(-1, 3, 3)
            extras = p.get("extras") or {}
            colour = gltf["materials"][p["material"]]["pbrMetallicRoughness"].get("baseColorFactor", [1.0] * 4)[:3]
            radiance = np.array(extras.get("exitance", [0.0] * 3)) / np.pi
            parts.append((triangles, np.array(extras.get("reflectance", colour)), radiance))
    return parts


def spread(parts, count, seed=1):
    """Random points on what reflects and does not emit, evenly by area: positions, unit normals, reflectances."""
    triangles = np.concatenate([t for t, _, m in parts if not m.any()])
    reflectance = np.concatenate([np.tile(r, (len(t), 1)) for t, r, m in parts if not m.any()])
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    cross = np.cross(b - a, c - a)
    size = np.linalg.norm(cross, axis=1)
    rng = np.random.default_rng(seed)
    chosen = rng.choice(len(size), count, p=size / size.sum())
    u, v = np.sqrt(rng.random(count))[:, None], rng.random(count)[:, None]
    points = (1 - u) * a[chosen] + u * (1 - v) * b[chosen] + u * v * c[chosen]
    return points, cross[chosen] / size[chosen, None], reflectance[chosen]


def whole(triangles):
    """The convex polygon that coplanar triangles make up together, or the triangles one by one when they make none.

    Radiance samples a rectangular lamp evenly, but not the triangles that it may be cut into.
    """
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(cross, axis=1).sum() / 2
    n = cross.sum(axis=0) / np.linalg.norm(cross.sum(axis=0))
    u = triangles[0, 1] - triangles[0, 0]
    u = u / np.linalg.norm(u)
    v = np.cross(n, u)
    corners = triangles.reshape(-1, 3)
    flat = corners @ np.array([u, v]).T
    turn = lambda a, b, c: (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    # Andrew's monotone chain; what is straight to a millionth of the area is no corner.
    order = sorted(range(len(flat)), key=lambda i: tuple(flat[i]))
    hull = []
    for half in (order, order[::-1]):
        chain = []
        for i in half:
            while len(chain) > 1 and turn(flat[chain[-2]], flat[chain[-1]], flat[i]) <= 1e-6 * area:
                chain.pop()
            chain.append(i)
        hull += chain[:-1]
    around = [(flat[a], flat[b]) for a, b in zip(hull, hull[1:] + hull[:1])]
    inside = sum(a[0] * b[1] - a[1] * b[0] for a, b in around) / 2
    is_flat = np.ptp(corners @ n) <= 1e-5 * np.sqrt(area)
    return [corners[hull]] if is_flat and abs(inside - area) <= 1e-3 * area else list(triangles)
