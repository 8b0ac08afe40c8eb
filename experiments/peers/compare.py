#!/usr/bin/env python3
"""Times a plain C++ sweep, numba, Devito and Deepwave on the work of the fast field engine; prints a table of ratios.

    cargo build --release
    python3 experiments/peers/compare.py [--cells 1000] [--steps 2000] [--threads 1 2]
                                         [--echolot target/release/echolot] [--peers cpp numba devito deepwave]

The first run makes a virtual environment beside this file and installs the peers into it (about 6 GB, most of it
PyTorch); Devito and the C++ sweep need gcc. An engine that cannot be installed or fails is left out and named.

Same work: a square f32 field, the five-point leapfrog scheme, no output but a receiver. The engine under test has
everything on (absorbing layers, walls, moving source and receiver); C++, numba and Devito have a plain box, Deepwave
absorbing layers and a fixed source. All engines run in turn, three times over, and the best of each counts.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import venv

HERE = pathlib.Path(__file__).resolve().parent
ENVIRONMENT = HERE / ".venv"
PEERS = ["cpp", "numba", "devito", "deepwave"]
ROUNDS = 3


def sweep():
    """The C++ sweep, compiled, or None when that fails."""
    program = ENVIRONMENT / "plain"
    program.parent.mkdir(exist_ok=True)
    build = ["g++", "-O3", "-march=native", "-ffast-math", "-fopenmp", HERE / "plain.cpp", "-o", program]
    try:
        subprocess.run(build, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"cpp: {error}, left out", file=sys.stderr)
        return None
    return program


def interpreter(peers):
    """The virtual environment's Python, made and filled with the peers that are not there."""
    python = ENVIRONMENT / "bin" / "python"
    if not python.exists():
        venv.create(ENVIRONMENT, with_pip=True)
    wanted = (HERE / "requirements.txt").read_text()
    for requirement in (line for line in wanted.splitlines() if line.split("==")[0] in peers):
        install = [python, "-m", "pip", "install", "--quiet", requirement]
        if subprocess.run(install, check=False).returncode != 0:
            print(f"{requirement}: could not be installed, left out", file=sys.stderr)
    return python


def peer_rate(command, name, cells, steps, threads):
    """Speed of a peer in Gcell/s, or None when it fails."""
    count = str(threads)
    limits = {key: count for key in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "MKL_NUM_THREADS")}
    run = subprocess.run(
        [*command, str(cells), str(steps), count],
        env={**os.environ, **limits},
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode != 0:
        reason = run.stderr.strip().splitlines()
        print(f"{name}: {reason[-1] if reason else 'failed'}", file=sys.stderr)
        return None
    return float(run.stdout.split()[-1])


def own_rates(echolot, cells, steps, threads):
    """Speed of every engine and scheme in Gcell/s."""
    size = ["--cells", f"{cells}x{cells}", "--steps", str(steps)]
    command = [echolot, "bench", "--json", *size, "--threads", str(threads)]
    rows = json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout)
    return {(f"{row['engine']} {row['scheme']}", row["threads"]): row["gcells_per_s"] for row in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=1000, help="cells along a side")
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--threads", type=int, nargs="+", default=sorted({1, os.cpu_count() or 1}))
    parser.add_argument("--peers", nargs="+", choices=PEERS, default=PEERS)
    parser.add_argument("--echolot", default=str(HERE.parents[1] / "target" / "release" / "echolot"))
    arguments = parser.parse_args()
    if not pathlib.Path(arguments.echolot).exists():
        parser.error(f"--echolot {arguments.echolot}: is missing; run `cargo build --release` first")
    python = interpreter(arguments.peers)
    commands = {name: [python, HERE / "work.py", name] for name in arguments.peers if name != "cpp"}
    if "cpp" in arguments.peers and (program := sweep()):
        commands = {"cpp": [program], **commands}
    table = {}
    for _ in range(ROUNDS):
        for threads in arguments.threads:
            case = (arguments.cells, arguments.steps, threads)
            rates = {(name, threads): peer_rate(command, name, *case) for name, command in commands.items()}
            rates.update(own_rates(arguments.echolot, *case))
            for key, rate in rates.items():
                table[key] = max(filter(None, (table.get(key), rate)), default=None)
    names = list(dict.fromkeys(name for name, _ in table))
    load = os.getloadavg()[0]
    size = f"{arguments.cells} x {arguments.cells} cells, f32, {arguments.steps} steps"
    print(f"{size}; Gcell/s, and how many times faster `fast slf` is")
    print(f"load average at the end: {load:.1f} on {os.cpu_count()} cores")
    print("| engine |" + "".join(f" {t} thread(s) | fast slf over it |" for t in arguments.threads))
    print("|---|" + "---|---|" * len(arguments.threads))
    for name in names:
        line = f"| {name} |"
        for threads in arguments.threads:
            rate, ours = table.get((name, threads)), table.get(("fast slf", threads))
            line += f" {rate:.2f} | {ours / rate:.1f} |" if rate and ours else " - | - |"
        print(line)


if __name__ == "__main__":
    main()
