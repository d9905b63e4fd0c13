"""Strikes objects with balls by Hertz's theory, and balances the energies of the results.

Usage: ledger.py SHATTERD SHATTER STRIKES OBJECT.., in an empty folder with the environment of a test. Bakes generated shapes, serves them
by the criterion of strength, and strikes each STRIKES times at random. Prints a JSON list with a row per object: worst ratios. The script
knows nothing of the service but its commands and files.

Source: H. Hertz, On the contact of elastic solids (1881); K. L. Johnson, Contact Mechanics (1985), section 11.4: the impact of spheres.
"""

import json
import math
import random
import struct
import subprocess
import sys

PROGRAMS = {"shatterd": sys.argv[1], "shatter": sys.argv[2]}
STRIKES, NAMES = int(sys.argv[3]), sys.argv[4:]
# Strikes of an object of which one is recomputed from the file of its fragments.
READ_EVERY = 10

# E, Poisson's ratio, density of the balls.
BALLS = {"steel": (2.0e11, 0.30, 7850), "glass": (7.0e10, 0.22, 2500), "concrete": (3.0e10, 0.20, 2400)}

VERTEX_LINE = "v {0} {1} {2}\n"
FACES = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"

# Object: half sides of a box, or None for the generated shape of that name, and material.
OBJECTS = {
    "mug": (None, "ceramic"),
    "horseshoe": (None, "glass"),
    "statue": (None, "marble"),
    "pane": ((0.2, 0.15, 0.005), "glass"),
    "wall": ((0.5, 0.25, 0.05), "concrete"),
}

FREE = """[objects.{}]
criterion = "strength"
effects = ["elastic", "interior", "release"]
"""

HELD = """[objects.wall]
criterion = "strength"
anchors = [{ min = [-1.0, -1.0, -1.0], max = [1.0, -0.24, 1.0] }]
effects = ["elastic", "interior", "anchored", "release"]
"""


def run(program, *arguments, codes=(0,)):
    """Runs a command with --json; returns its document."""
    command = [PROGRAMS[program], *map(str, arguments), "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode not in codes:
        raise SystemExit(f"{command}: {done.returncode}: {done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def bake(name, half, material):
    common = ["--name", name, "--material", material, "--quality", "draft", "--surface", "lattice", "--examples", "0"]
    if half is None:
        return run("shatterd", "bake", "--shape", name, *common)
    with open(f"{name}.obj", "w") as file:
        for corner in range(8):
            file.write(VERTEX_LINE.format(*((2 * (corner >> 2 - axis & 1) - 1) * half[axis] for axis in range(3))))
        file.write(FACES)
    return run("shatterd", "bake", f"{name}.obj", *common)


def struck(ball, radius, speed, body_mass, body):
    """Impulse, duration, contact radius and mass of a ball that bounces off a half-space of the body's material."""
    young, poisson, density = ball
    mass = density * 4 / 3 * math.pi * radius**3
    reduced_mass = 1 / (1 / mass + 1 / body_mass)
    modulus = 1 / ((1 - poisson**2) / young + (1 - body["poisson"] ** 2) / body["young_pa"])
    stiffness = 4 / 3 * modulus * math.sqrt(radius)
    depth = (5 * reduced_mass * speed**2 / (4 * stiffness)) ** 0.4
    return 2 * reduced_mass * speed, 2.943 * depth / speed, math.sqrt(radius * depth), mass


def accessor(document, binary, index):
    own = document["accessors"][index]
    view = document["bufferViews"][own["bufferView"]]
    kind = {5126: "f", 5125: "I", 5123: "H"}[own["componentType"]]
    width = {"SCALAR": 1, "VEC3": 3}[own["type"]]
    start = view.get("byteOffset", 0) + own.get("byteOffset", 0)
    values = struct.unpack_from(f"<{own['count'] * width}{kind}", binary, start)
    return values if width == 1 else [values[first : first + 3] for first in range(0, len(values), 3)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def fragments(path):
    """Of every fragment: area of its cracks, volume, second moments of the volume about its center."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    crack = [material["name"] for material in document["materials"]].index("crack")
    for node in document["nodes"]:
        if "mesh" not in node:
            continue
        area, volume, moments, first = 0.0, 0.0, [[0.0] * 3 for _ in range(3)], [0.0] * 3
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            points = accessor(document, binary, primitive["attributes"]["POSITION"])
            corners = accessor(document, binary, primitive["indices"])
            for start in range(0, len(corners), 3):
                a, b, c = (points[corner] for corner in corners[start : start + 3])
                normal = cross([y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)])
                if primitive["material"] == crack:
                    area += 0.5 * math.sqrt(dot(normal, normal))
                # The tetrahedron from the origin: its sums of the corners have closed forms.
                own = dot(a, cross(b, c)) / 6
                volume += own
                total = [x + y + z for x, y, z in zip(a, b, c)]
                for i in range(3):
                    first[i] += own * total[i] / 4
                    for j in range(3):
                        squares = a[i] * a[j] + b[i] * b[j] + c[i] * c[j]
                        moments[i][j] += own * (squares + total[i] * total[j]) / 20
        center = [value / volume for value in first]
        for i in range(3):
            for j in range(3):
                moments[i][j] -= volume * center[i] * center[j]
        yield area, volume, moments


def recomputed(path, result, density, toughness):
    """Energies of surface and release, from the closed meshes and the velocities of the document."""
    area, released = 0.0, 0.0
    for (own, volume, moments), fragment in zip(fragments(path), result["fragments"]):
        area += own
        linear, spin = fragment["velocity"]["linear_m_s"], fragment["velocity"]["angular_rad_s"]
        squares = sum(moments[axis][axis] for axis in range(3))
        turned = dot(spin, spin) * squares - sum(spin[i] * moments[i][j] * spin[j] for i in range(3) for j in range(3))
        released += 0.5 * density * (volume * dot(linear, linear) + turned)
    return 0.5 * toughness * area, released


def aim(low, high):
    """A ray from far away to a random place in a box."""
    target = [random.uniform(*pair) for pair in zip(low, high)]
    while True:
        direction = [random.gauss(0, 1) for _ in range(3)]
        size = math.sqrt(dot(direction, direction))
        if size > 0.1:
            break
    direction = [own / size for own in direction]
    return ",".join(f"{value:.9g}" for value in [t - 9 * d for t, d in zip(target, direction)] + direction)


def strike(name, baked, extent, strikes):
    material = baked["parameters"]["material"]
    mass = baked["input_volume_m3"] * material["density_kg_m3"] if name != "wall" else math.inf
    row = {"object": name, "strikes": 0, "broken": 0, "limited": 0, "read": 0}
    row |= {"strain_over_impactor": 0.0, "impactor_over_ball": 0.0, "spent_over_strain": 0.0}
    row |= {"surface_error": 0.0, "released_error": 0.0}
    while row["strikes"] < strikes:
        ball, radius = BALLS[random.choice(list(BALLS))], 0.005 * 10 ** random.random()
        speed = 0.5 * 100 ** random.random()
        impulse, duration, contact, ball_mass = struck(ball, radius, speed, mass, material)
        reads = row["strikes"] % READ_EVERY == 0
        options = ["--out", f"{name}.glb"] if reads else []
        hit = ["impact", name, f"--ray={aim(*extent)}", "--impulse-ns", impulse, "--duration-s", duration]
        hit += ["--radius-m", contact, "--speed", speed, "--impactor-mass", ball_mass]
        result = run("shatter", *hit, *options, codes=(0, 3))
        if result.get("error"):
            # The ray passes beside the object.
            assert result["error"]["kind"] == "ray_missed", result
            continue
        ledger = result["ledger"]
        row["strikes"] += 1
        strain, impactor = ledger["strain_j"], ledger["impactor_j"]
        row["impactor_over_ball"] = max(row["impactor_over_ball"], impactor / (0.5 * ball_mass * speed**2))
        if strain is None:
            continue
        row["strain_over_impactor"] = max(row["strain_over_impactor"], strain / impactor)
        row["limited"] += ledger["load_factor"] < 1
        if not result["fragments"]:
            continue
        row["broken"] += 1
        assert ledger["stress_over_strength"] >= 1, ledger
        released = ledger["released_j"] or 0.0
        spent = ledger["surface_j"] + released
        row["spent_over_strain"] = max(row["spent_over_strain"], spent / strain)
        if reads:
            row["read"] += 1
            own = recomputed(f"{name}.glb", result, material["density_kg_m3"], material["toughness_j_m2"])
            row["surface_error"] = max(row["surface_error"], abs(own[0] / ledger["surface_j"] - 1))
            row["released_error"] = max(row["released_error"], abs(own[1] - released) / max(released, 1e-12))
    return row


def main():
    random.seed(1)
    for name in NAMES:
        bake(name, *OBJECTS[name])
    with open("ledger.toml", "w") as file:
        file.writelines(HELD if name == "wall" else FREE.format(name) for name in NAMES)
    run("shatterd", "bake", "--scene", "ledger.toml")
    baked = {name: run("shatterd", "inspect", name) for name in NAMES}
    daemon = subprocess.Popen(
        [PROGRAMS["shatterd"], "serve", "--scene", "ledger.toml"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        run("shatter", "status", "--wait", 60)
        bounds = {own["object"]: own["bounds_m"] for own in run("shatter", "list")["objects"]}
        print(json.dumps([strike(name, baked[name], bounds[name], STRIKES) for name in NAMES]))
    finally:
        daemon.terminate()
        daemon.wait()


main()
