"""Compares the strain energies of `shatter impact --json` with closed forms.

Usage: closed_forms.py SHATTERD SHATTER, in an empty folder with the environment of a test. Writes meshes, bakes them at the preset `game`,
serves and strikes them. Prints a JSON list of cases: energy, closed form, ratio. The script knows nothing of the service but its commands.

Sources: S. Timoshenko, Strength of Materials I (1940): beams, with the shear of A. Foppl's factor 6/5; S. Timoshenko and
S. Woinowsky-Krieger, Theory of Plates and Shells (1959), section 19: circular plates; G. Lame, lectures on elasticity (1852): the hollow
sphere; A. I. Lur'e, Three-Dimensional Problems of the Theory of Elasticity (1964), chapter 6: the solid sphere; K. L. Johnson,
Contact Mechanics (1985), chapter 3: the half-space.
"""

import json
import math
import os
import subprocess
import sys
import time

PROGRAMS = {"shatterd": sys.argv[1], "shatter": sys.argv[2]}
IMPULSE_NS = 1.0
DURATION_S = 1e-3
# A half-sine pulse of this impulse and duration.
FORCE_N = math.pi * IMPULSE_NS / (2 * DURATION_S)


def run(program, *arguments):
    """Runs a command with --json; returns its document."""
    command = [PROGRAMS[program], *map(str, arguments), "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{command}: {done.returncode}: {done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def write_obj(name, points, triangles):
    with open(f"{name}.obj", "w") as file:
        file.writelines("v {:.17g} {:.17g} {:.17g}\n".format(*point) for point in points)
        file.writelines("f {} {} {}\n".format(*(1 + corner for corner in triangle)) for triangle in triangles)


def turned(points):
    """Points in directions that no lattice shares."""
    for axis, angle in ((0, 0.4), (1, 1.1), (2, -0.7)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        cos, sin = math.cos(angle), math.sin(angle)
        points = [list(point) for point in points]
        for point in points:
            point[i], point[j] = cos * point[i] - sin * point[j], sin * point[i] + cos * point[j]
    return points


def cuboid(size):
    points = [[(2 * (corner >> axis & 1) - 1) * 0.5 * size[axis] for axis in range(3)] for corner in range(8)]
    quads = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    return points, [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]


def disc(radius, thick, corners=256):
    points, triangles = [[0, 0, -0.5 * thick], [0, 0, 0.5 * thick]], []
    for index in range(corners):
        angle = 2 * math.pi * index / corners
        points += [[radius * math.cos(angle), radius * math.sin(angle), side * thick] for side in (-0.5, 0.5)]
        here, following = 2 + 2 * index, 2 + 2 * ((index + 1) % corners)
        triangles += [(0, following, here), (1, here + 1, following + 1)]
        triangles += [(here, following, following + 1), (here, following + 1, here + 1)]
    return points, triangles


def sphere(radius, halvings):
    """An octahedron whose triangles are divided into four and moved onto the sphere."""
    points = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(halvings):
        middles, smaller = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                place = [x + y for x, y in zip(points[a], points[b])]
                length = math.hypot(*place)
                middles[key] = len(points)
                points.append([x / length for x in place])
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            smaller += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = smaller
    return [[radius * x for x in point] for point in points], triangles


def hollow_sphere(inner, outer, halvings):
    points, triangles = sphere(outer, halvings)
    hollow, faces = sphere(inner, halvings)
    first = len(points)
    return points + hollow, triangles + [(first + a, first + c, first + b) for a, b, c in faces]


def bell(distance, radius):
    """Pressure of a contact, over that in its middle."""
    return max(math.exp(-0.5 * (distance / radius) ** 2) - math.exp(-4.5), 0.0)


def free_beam(young, poisson, length, width, thick):
    """A beam whose middle is pushed, and whose inertia is a uniform load."""
    bending = length**3 / (640 * young * width * thick**3 / 12)
    shear = length / (20 * young / (2 * (1 + poisson)) * width * thick)
    return FORCE_N**2 * (bending + shear)


def cantilever(young, poisson, span, width, thick):
    """A beam that is held at its root and pushed at its tip."""
    bending = span**3 / (6 * young * width * thick**3 / 12)
    shear = 0.6 * span / (young / (2 * (1 + poisson)) * width * thick)
    return FORCE_N**2 * (bending + shear)


def free_plate(young, poisson, radius, thick, contact_radius, steps=20000):
    """A round plate whose middle a bell pushes, and whose inertia is an even pressure.

    The slope f of its deflection satisfies D (f' + f / r)' = Q, with Q the load inside r over 2 pi r, and f' + nu f / r = 0 at the rim.
    """
    step, load, curvature, moment, parts = radius / steps, 0.0, 0.0, 0.0, []
    places = [(index + 0.5) * step for index in range(steps)]
    rings = [bell(r, contact_radius) * r for r in places]
    total = sum(rings)
    for r, ring in zip(places, rings):
        load += ring / total
        curvature += step * (load - (r / radius) ** 2) / (2 * math.pi * r)
        moment += step * r * curvature
        parts.append((r, curvature - moment / r**2, moment / r**2))
    _, along, around = parts[-1]
    even, energy = -(along + poisson * around) / (1 + poisson), 0.0
    for r, along, around in parts:
        along, around = along + even, around + even
        energy += step * r * (along**2 + around**2 + 2 * poisson * along * around)
    return FORCE_N**2 * math.pi * energy * 12 * (1 - poisson**2) / (young * thick**3)


def hollow_sphere_outside(young, poisson, inner, outer, contacts, radius):
    """A hollow sphere that contacts in the directions of a cube's corners press: the part of their load that is an even pressure.

    Each presses along one direction, so its bell counts with the cosine. What is left has the harmonics of degree 4 and higher.
    """
    steps = 2000
    total = normal = 0.0
    for index in range(steps):
        angle = (index + 0.5) * 3 * radius / outer / steps
        ring = bell(angle * outer, radius) * math.sin(angle)
        total += ring
        normal += ring * math.cos(angle)
    pressure = contacts * FORCE_N * normal / total / (4 * math.pi * outer**2)
    inward = (1 - 2 * poisson) * outer**3 + 0.5 * (1 + poisson) * inner**3
    inward *= pressure * outer / (young * (outer**3 - inner**3))
    return 0.5 * pressure * inward * 4 * math.pi * outer**2


def half_space(young, poisson, radius):
    """Energy below one contact with the pressure exp(-r^2 / 2 a^2) of the half-space, without its cut at 3 a."""
    return FORCE_N**2 * (1 - poisson**2) / (4 * math.sqrt(math.pi) * young * radius)


def pressed_sphere(young, poisson, radius, contact_radius, terms=300, steps=3000):
    """A sphere that two opposite contacts press together, by Legendre series of their tractions.

    With p_n P_n the normal traction and q_n dP_n/dt that along the meridian: u_r = (A (n+1)(n-2+4v) + B n) P_n and
    u_t = (A (n+5-4v) + B) dP_n/dt, with p_n = 2G (A (n+1)(n^2-n-2-2v) + B n(n-1)), q_n = 2G (A (n^2+2n-1+2v) + B (n-1)).
    """
    share = contact_radius / radius
    normal, along, total = [0.0] * (terms + 1), [0.0] * (terms + 1), 0.0
    step = 3 * share / steps
    for index in range(steps):
        angle = (index + 0.5) * step
        sin, cos = math.sin(angle), math.cos(angle)
        ring = bell(angle, share) * sin * step
        total += 2 * math.pi * ring
        before, slope_before, last, slope = 1.0, 0.0, cos, 1.0
        for n in range(terms + 1):
            if n == 0:
                value, incline = 1.0, 0.0
            elif n == 1:
                value, incline = cos, 1.0
            else:
                value = ((2 * n - 1) * cos * last - (n - 1) * before) / n
                incline = cos * slope + n * last
                before, last, slope = last, value, incline
            normal[n] -= ring * cos * value
            along[n] -= ring * sin * sin * incline
    shear, energy = 0.5 / (1 + poisson), 0.0
    # The opposite force doubles the even terms and cancels the odd ones.
    for n in range(0, terms + 1, 2):
        weight = 2 * n + 1
        p = normal[n] * weight / total / (2 * shear)
        q = along[n] * weight / (n * (n + 1)) / total / (2 * shear) if n else 0.0
        a1, b1 = (n + 1) * (n * n - n - 2 - 2 * poisson), n * (n - 1)
        a2, b2 = n * n + 2 * n - 1 + 2 * poisson, n - 1
        if n == 0:
            a, b = p / a1, 0.0
        else:
            determinant = a1 * b2 - b1 * a2
            a, b = (p * b2 - q * b1) / determinant, (q * a1 - p * a2) / determinant
        radial = a * (n + 1) * (n - 2 + 4 * poisson) + b * n
        meridian = a * (n + 5 - 4 * poisson) + b
        energy += 0.5 * 2 * shear * 4 * math.pi / weight * (p * radial + q * meridian * n * (n + 1))
    return FORCE_N**2 * energy / (young * radius)


class Service:
    """A daemon that serves a scene until the end of the block."""

    def __init__(self, scene):
        self.scene = scene

    def __enter__(self):
        with open("scene.toml", "w") as file:
            file.write(self.scene)
        command = [PROGRAMS["shatterd"], "serve", "--scene", "scene.toml"]
        self.daemon = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        if not any(line.strip() == "ready" for line in self.daemon.stdout):
            raise SystemExit("the daemon ended before it was ready")

    def __exit__(self, *_):
        self.daemon.terminate()
        self.daemon.wait()


def struck(name, contacts, radius):
    """Strikes an object at points along directions; returns the document."""
    arguments = []
    for point, direction in contacts:
        arguments += ["--point=" + ",".join(f"{x:.17g}" for x in point)]
        arguments += ["--impulse=" + ",".join(f"{IMPULSE_NS * x:.17g}" for x in direction)]
    # With a number of sites, the daemon computes the displacement however weak the impulse is.
    document = run("shatter", "impact", name, *arguments, "--radius-m", radius, "--duration-s", DURATION_S, "--degree", 2)
    if abs(document["radius_m"] / radius - 1) > 1e-6:
        raise SystemExit(f"{name}: a contact of {radius} m became one of {document['radius_m']} m")
    return document


BAKE = ["--material", "glass", "--quality", "game", "--surface", "lattice"]
# Without a basis of displacements of the free body, which its anchors do not use.
OPTIONS = {"thin_beam": ["--elastic", "solve"]}
HELD = ("beam", "thin_beam")

STRIP = [1.0, 0.1, 0.01]
BEAM = [1.0, 0.08, 0.08]
ROOT = -0.4
PLATE = [0.55, 0.022]
BALL = 0.5
HOLLOW = [0.25, 0.5]


def bake():
    """Bakes all objects; returns E, nu and facts of each."""
    meshes = {
        "strip": cuboid(STRIP),
        "beam": cuboid(BEAM),
        "thin_beam": cuboid(STRIP),
        "plate": disc(*PLATE),
        "ball": sphere(BALL, 5),
        "hollow": hollow_sphere(*HOLLOW, 4),
    }
    facts = {}
    for name, (points, triangles) in meshes.items():
        write_obj(name, turned(points) if name in ("strip", "plate") else points, triangles)
        start = time.monotonic()
        baked = run("shatterd", "bake", f"{name}.obj", "--name", name, *BAKE, *OPTIONS.get(name, []))
        document = run("shatterd", "inspect", baked["file"])
        material, body = document["parameters"]["material"], document["elastic"][0]
        facts[name] = {
            "constants": [material["young_pa"], material["poisson"]],
            "elements": f"{body['order']}, {body['elements_across']:.1f} across",
            "nodes": document["elastic_nodes"],
            "bake_s": round(time.monotonic() - start, 2),
        }
    return facts


def cases():
    """Object, contacts, contact radius and closed form of every case."""
    down, middle = turned([[0, 0, -1]])[0], turned([[0, 0, 0.5 * STRIP[2]], [0, 0, 0.5 * PLATE[1]]])
    corners = [[sign / math.sqrt(3) for sign in (x, y, z)] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    tip = 0.45
    yield "strip", [(middle[0], down)], 0.01, lambda e, v: free_beam(e, v, *STRIP)
    yield "beam", [([tip, 0, 0.5 * BEAM[2]], [0, 0, -1])], 0.04, lambda e, v: cantilever(e, v, tip - ROOT, *BEAM[1:])
    yield "thin_beam", [([tip, 0, 0.5 * STRIP[2]], [0, 0, -1])], 0.01, lambda e, v: cantilever(e, v, tip - ROOT, *STRIP[1:])
    yield "plate", [(middle[1], down)], 0.02, lambda e, v: free_plate(e, v, *PLATE, 0.02)
    for direction in ([1, 0, 0], [x / math.sqrt(14) for x in (1, 2, 3)]):
        opposite = [([side * BALL * x for x in direction], [-side * x for x in direction]) for side in (1, -1)]
        for radius in (0.075, 0.15):
            yield "ball", opposite, radius, lambda e, v, radius=radius: pressed_sphere(e, v, BALL, radius)
    pressed = [([HOLLOW[1] * x for x in corner], [-x for x in corner]) for corner in corners]
    yield "hollow", pressed, 0.3, lambda e, v: hollow_sphere_outside(e, v, *HOLLOW, len(corners), 0.3)


def main():
    facts = bake()
    held = f"anchors = [{{ min = [-1.0, -1.0, -1.0], max = [{ROOT}, 1.0, 1.0] }}]\neffects = [\"elastic\", \"interior\", \"anchored\"]\n"
    scene = "".join(f"[objects.{name}]\n{held if name in HELD else ''}" for name in facts)
    found = []
    with Service(scene):
        for name, contacts, radius, closed_form in cases():
            young, poisson = facts[name]["constants"]
            document = struck(name, contacts, radius)
            strain_j, exact_j = document["ledger"]["strain_j"], closed_form(young, poisson)
            row = {"object": name, "contacts": len(contacts), "radius_m": radius, "strain_j": strain_j, "closed_form_j": exact_j}
            row |= {"ratio": strain_j / exact_j, "elastic": document["elastic"], "error_estimate": document["error_estimate"]}
            if name == "ball":
                # Of the same order: the indentation below both contacts, without the rest of the ball.
                row["half_spaces_j"] = 2 * half_space(young, poisson, radius)
            found.append(row | {key: value for key, value in facts[name].items() if key != "constants"})
    print(json.dumps(found))


if __name__ == "__main__":
    main()
