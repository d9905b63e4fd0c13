"""Strikes the top of an object of a running shatterd: python strike.py OBJECT OUT.glb"""

import sys

import shatter

name, out = sys.argv[1:3]
body = shatter.connect().object(name)
whole = body.even(1).wait()[0]
top = whole.center_m + whole.positions[whole.positions[:, 1].argmax()]
result = body.strike(shatter.Contact(top, (0.0, -2.0, 0.0)), degree=24).wait()
print(f"{len(result)} fragments, {sum(f.mass_kg for f in result):.4f} kg, {result.summary.time_s * 1e3:.1f} ms")
result.write_glb(out)
