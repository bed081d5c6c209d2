#!/usr/bin/env python3
"""Renders one job with etendue and with other path tracers, interleaved, and prints what each cost and how they agree.

    python3 bench/peers.py --peers DIR --model helmet.glb --env sky.hdr [--size 512x512] [--spp 32] [--repeat 3]

DIR holds the peers' scripts (`blender_cycles.py`, `mitsuba3.py`): each takes a JSON job, writes a linear picture `OUT.npy`
and prints its seconds and peak memory as a line of JSON. A peer whose Python package is not installed is left out.

A repetition renders the job twice with each program, with two seeds, one program after the other, so that a machine that
grows slower or faster does so for all. Columns:

    seconds   median. Ours: building the acceleration structure, and rendering; Cycles: synchronisation, its structure, and
              rendering; Mitsuba: rendering alone, its structure built and its kernels compiled. Nobody's has reading files.
    relvar    mean over pixels and channels of ((a - b)^2 / 2) / (((a + b) / 2)^2 + 0.01) for the two seeds' pictures a and b:
              the variance of one picture relative to its squared mean. Median over the repetitions.
    cost      relvar x seconds: the time to a given error. `ratio` is this over ours.
    peak MB   largest resident memory of the process.
    mean      of the linear picture and of the crop, per channel, with the difference from ours.

Needs Python 3.9 and numpy.
"""
import argparse
import importlib.util
import json
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
# Script, Python package that it needs, further arguments.
PEERS = {
    "mitsuba": ("mitsuba3.py", "mitsuba", ["llvm_ad_rgb"]),
    "cycles": ("blender_cycles.py", "bpy", []),
}


def arguments():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    numbers = lambda n: lambda text: [float(v) for v in text.split(",", n - 1)]
    p.add_argument("--peers", type=Path, metavar="DIR", help="folder of the peers' scripts; without it only etendue runs")
    p.add_argument("--only", default="", help="peers to run, comma-separated: " + ", ".join(PEERS))
    p.add_argument("--model", type=Path, required=True)
    p.add_argument("--env", type=Path, required=True, help="latitude-longitude .hdr or .exr")
    p.add_argument("--binary", type=Path, default=ROOT / "target/release/etendue")
    p.add_argument("--size", default="512x512", metavar="WxH")
    p.add_argument("--spp", type=int, default=32)
    p.add_argument("--peer-spp", type=int, help="samples of the peers, if others than ours")
    p.add_argument("--repeat", type=int, default=3)
    p.add_argument("--bounces", type=int, default=8)
    p.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    p.add_argument("--eye", type=numbers(3), default=[0.0, 0.0, 3.0], metavar="X,Y,Z")
    p.add_argument("--target", type=numbers(3), default=[0.0, 0.0, 0.0], metavar="X,Y,Z")
    p.add_argument("--vfov", type=float, default=45.0)
    # The part of the picture that lies on the helmet: rows 70 to 170, columns 90 to 175 of 256.
    p.add_argument("--crop", type=numbers(4), default=[70 / 256, 170 / 256, 90 / 256, 175 / 256],
                   metavar="T,B,L,R", help="rows and columns of the crop, as shares of height and width")
    p.add_argument("--keep", type=Path, metavar="DIR", help="keeps the pictures (.npy) here")
    p.add_argument("--json", type=Path, metavar="FILE", help="writes the table here as well")
    return p.parse_args()


def read_exr(path):
    """R, G, B of an OpenEXR file as this project writes it: scan lines, 32-bit floats, ZIP over 16 rows."""
    data = path.read_bytes()
    if data[:4] != b"\x76\x2f\x31\x01":
        raise ValueError(f"{path}: not an OpenEXR file")
    at, header = 8, {}

    def text():
        nonlocal at
        end = data.index(0, at)
        out, at = data[at:end].decode(), end + 1
        return out

    while data[at]:
        name, _ = text(), text()
        size = struct.unpack_from("<i", data, at)[0]
        header[name], at = data[at + 4:at + 4 + size], at + 4 + size
    at += 1
    if header["compression"][0] != 3:
        raise ValueError(f"{path}: not compressed as expected")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    w, h = x1 - x0 + 1, y1 - y0 + 1
    channels, rest = [], header["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        if struct.unpack_from("<i", rest)[0] != 2:
            raise ValueError(f"{path}: channel {name.decode()} is not 32-bit float")
        channels.append(name.decode())
        rest = rest[16:]
    rows = []
    for (offset,) in struct.iter_unpack("<q", data[at:at + 8 * -(-h // 16)]):
        y, size = struct.unpack_from("<2i", data, offset)
        count = min(16, h - (y - y0))
        want = count * w * 4 * len(channels)
        code = data[offset + 8:offset + 8 + size]
        if size < want:
            # Differences of bytes, of which first the even, then the odd ones are stored.
            raw = np.frombuffer(zlib.decompress(code), np.uint8).astype(np.int64)
            raw[1:] -= 128
            split = (np.cumsum(raw) & 255).astype(np.uint8)
            code = np.empty(want, np.uint8)
            code[0::2], code[1::2] = split[:(want + 1) // 2], split[(want + 1) // 2:]
        rows.append(np.frombuffer(bytes(code), "<f4").reshape(count, len(channels), w))
    picture = np.concatenate(rows).transpose(0, 2, 1)
    return picture[:, :, [channels.index(c) for c in "RGB"]]


def run(command, what):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not lines:
        raise RuntimeError(f"{what} ended with {done.returncode}:\n{(done.stderr or done.stdout).strip()[-2000:]}")
    return json.loads(lines[-1])


def etendue(a, seed, folder):
    out = folder / "etendue.exr"
    triple = lambda v: ",".join(map(str, v))
    report = run([a.binary, "render", a.model, "--env", a.env, f"--eye={triple(a.eye)}", f"--target={triple(a.target)}",
                  "--vfov", a.vfov, "--size", a.size, "--spp", a.spp, "--seed", seed, "--bounces", a.bounces,
                  "--threads", a.threads, "--filter", "box", "--bits", 32, "--json", "-o", out], "etendue")
    seconds = report["seconds"]["build"] + report["seconds"]["render"]
    return read_exr(out), seconds, (report["peak_memory_bytes"] or 0) / 2**20


def peer(a, name, seed, folder):
    script, _, more = PEERS[name]
    width, height = map(int, a.size.split("x"))
    job = dict(model=str(a.model.resolve()), env=str(a.env.resolve()), width=width, height=height,
               spp=a.peer_spp or a.spp, seed=seed, bounces=a.bounces, threads=a.threads, out=str(folder / name),
               camera=dict(eye=a.eye, target=a.target, up=[0, 1, 0], vfov_deg=a.vfov))
    path = folder / f"{name}.json"
    path.write_text(json.dumps(job))
    report = run([sys.executable, a.peers / script, path, *more], name)
    return np.load(folder / f"{name}.npy").astype(np.float32), report["render_s"], report["max_rss_mb"]


def available(a):
    wanted = [n for n in a.only.split(",") if n] or list(PEERS)
    for name in wanted:
        if name not in PEERS:
            sys.exit(f"there is no peer {name}; there are {', '.join(PEERS)}")
        script, package, _ = PEERS[name]
        if not a.peers or not (a.peers / script).is_file():
            print(f"{name}: left out, there is no {script} in the folder of peers")
        elif importlib.util.find_spec(package) is None:
            print(f"{name}: left out, Python has no package {package}")
        else:
            yield name


def relvar(a, b):
    a, b = a.astype(np.float64), b.astype(np.float64)
    return float(np.mean((a - b) ** 2 / 2 / (((a + b) / 2) ** 2 + 0.01)))


def measure(a, names, folder):
    """Per program: seconds, peaks, relvars, and the mean of all pictures."""
    got = {n: dict(seconds=[], peak=[], relvar=[], pictures=0, total=0.0) for n in names}
    for repetition in range(a.repeat):
        pairs = {n: [] for n in got}
        for half in (1, 2):
            for name in list(got):
                # Far apart: some programs take a seed and its neighbour for related sequences.
                seed = 1000 * repetition + 500 * half
                try:
                    picture, seconds, mb = etendue(a, seed, folder) if name == "etendue" else peer(a, name, seed, folder)
                except (RuntimeError, OSError, ValueError, KeyError) as e:
                    if name == "etendue":
                        sys.exit(str(e))
                    print(f"{name}: left out, {e}")
                    del got[name]
                    continue
                g = got[name]
                g["seconds"].append(seconds)
                g["peak"].append(mb)
                g["total"] = g["total"] + picture.astype(np.float64)
                g["pictures"] += 1
                pairs[name].append(picture)
                print(f"  repetition {repetition + 1}, seed {seed}, {name}: {seconds:.2f} s", flush=True)
        for name, g in got.items():
            g["relvar"].append(relvar(*pairs[name]))
    return got


def table(a, got):
    width, height = map(int, a.size.split("x"))
    top, bottom, left, right = (round(share * n) for share, n in zip(a.crop, (height, height, width, width)))
    rows = []
    for name, g in got.items():
        picture = g["total"] / g["pictures"]
        seconds, noise = statistics.median(g["seconds"]), statistics.median(g["relvar"])
        spp = a.spp if name == "etendue" else a.peer_spp or a.spp
        rows.append(dict(program=name, seconds=seconds, mpaths_per_s=width * height * spp / seconds / 1e6, relvar=noise,
                         cost=noise * seconds, peak_mb=max(g["peak"]), mean=picture.mean((0, 1)).tolist(),
                         crop=picture[top:bottom, left:right].mean((0, 1)).tolist()))
    ours = rows[0]
    print(f"\n{a.size}, {a.spp} samples ({a.peer_spp or a.spp} of peers), {a.bounces} bounces, {a.threads} threads, "
          f"{a.repeat} x 2 runs; crop: rows {top}-{bottom}, columns {left}-{right}\n")
    print("| program | seconds | M paths/s | relvar | relvar x seconds | ratio | peak MB |")
    print("|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['program']} | {r['seconds']:.2f} | {r['mpaths_per_s']:.2f} | {r['relvar']:.2e} | {r['cost']:.2e} "
              f"| {r['cost'] / ours['cost']:.2f} | {r['peak_mb']:.0f} |")
    print("\n| program | mean of the whole | less ours, % | mean of the crop | less ours, % |")
    print("|---|---|---|---|---|")
    for r in rows:
        cells = [r["program"]]
        for part in ("mean", "crop"):
            cells.append(" ".join(f"{v:.4f}" for v in r[part]))
            cells.append(" ".join(f"{(v / o - 1) * 100:+.2f}" for v, o in zip(r[part], ours[part])))
        print("| " + " | ".join(cells) + " |")
    return rows


def main():
    a = arguments()
    if not a.binary.is_file():
        sys.exit(f"there is no {a.binary}; build it with `cargo build --release`, or name it with --binary")
    names = ["etendue", *available(a)]
    with tempfile.TemporaryDirectory() as folder:
        got = measure(a, names, Path(folder))
    if a.keep:
        a.keep.mkdir(parents=True, exist_ok=True)
        for name, g in got.items():
            np.save(a.keep / f"{name}.npy", (g["total"] / g["pictures"]).astype(np.float32))
    rows = table(a, got)
    if a.json:
        a.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
