"""Strikes the top of an object of a running shatterd: python strike.py OBJECT OUT.glb"""

import sys

import shatter

name, out = sys.argv[1:3]
body = shatter.connect().object(name)
whole = body.even(1).wait()[0]
top = whole.center_m + whole.positions[whole.positions[:, 1].argmax()]
broken = body.strike(shatter.Contact(top, (0.0, -2.0, 0.0)), degree=24).wait()
print(f"{len(broken)} fragments, {sum(f.mass_kg for f in broken):.4f} kg, {broken.summary.time_s * 1e3:.1f} ms")
broken.write_glb(out)
