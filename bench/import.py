#!/usr/bin/env python3
"""Loads one glTF file with etendue and with Blender's importer, interleaved, and prints what each took.

    cargo run --release -p etendue --example big_asset -- DIR
    python3 bench/import.py DIR/big.gltf [--repeat 3]

    import     etendue: `info`, which loads all geometry and decodes all pictures. Blender: `import_scene.gltf` in an empty
               scene, which leaves pictures in their files until somebody looks at them.
    pictures   Blender: a look at each picture, which decodes it.

CPU seconds are those of all threads; peak is the largest resident memory of the process. Needs Python 3.9 with Blender as a
module (`pip install bpy`) for Blender.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

BLENDER = r"""
import json, resource, sys, time
import bpy
def cost():
    r = resource.getrusage(resource.RUSAGE_SELF)
    return time.time(), r.ru_utime + r.ru_stime, r.ru_maxrss / 1024
def spent(a):
    b = cost()
    return {"wall": b[0] - a[0], "cpu": b[1] - a[1], "peak": b[2]}
bpy.ops.wm.read_factory_settings(use_empty=True)
start = cost()
bpy.ops.import_scene.gltf(filepath=sys.argv[1])
imported = spent(start)
start = cost()
for image in bpy.data.images:
    image.pixels[0]
pictures = spent(start)
print("RESULT " + json.dumps({"version": bpy.app.version_string, "import": imported, "pictures": pictures,
    "triangles": sum(len(m.loop_triangles) or len(m.polygons) for m in bpy.data.meshes)}))
"""

ETENDUE = r"""
import json, resource, subprocess, sys, time
start = time.time()
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
r = resource.getrusage(resource.RUSAGE_CHILDREN)
print("RESULT " + json.dumps({"import": {"wall": time.time() - start, "cpu": r.ru_utime + r.ru_stime, "peak": r.ru_maxrss / 1024}}))
"""


def measured(code, *arguments):
    """What the child says of itself; None if it fails."""
    p = subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)
    lines = [l for l in p.stdout.splitlines() if l.startswith("RESULT ")]
    if p.returncode or not lines:
        print(p.stderr.strip().splitlines()[-1:] or "no result", file=sys.stderr)
        return None
    return json.loads(lines[-1][7:])


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("model", type=Path)
    p.add_argument("--binary", type=Path, default=ROOT / "target/release/etendue")
    p.add_argument("--repeat", type=int, default=3)
    args = p.parse_args()
    runs = {}
    for _ in range(args.repeat):
        for name, code, rest in [("etendue", ETENDUE, [args.binary, "info", args.model]), ("blender", BLENDER, [args.model])]:
            result = measured(code, *rest)
            if result is None:
                continue
            name += " " + result.get("version", "")
            for part in ("import", "pictures"):
                if part in result:
                    runs.setdefault((name.strip(), part), []).append(result[part])
    ours = statistics.median(r["cpu"] for r in runs[("etendue", "import")])
    print(f"{args.model}, {os.cpu_count()} processors, medians of {args.repeat}")
    print(f"{'':24}{'wall s':>10}{'CPU s':>10}{'ratio':>8}{'peak MB':>10}")
    for (name, part), all_of_it in runs.items():
        median = {k: statistics.median(r[k] for r in all_of_it) for k in ("wall", "cpu", "peak")}
        print(f"{name + ', ' + part:24}{median['wall']:10.1f}{median['cpu']:10.1f}{median['cpu'] / ours:8.2f}{median['peak']:10.0f}")


if __name__ == "__main__":
    main()
