#!/usr/bin/env python3
"""Our minimisers of the energy of a sheet against others, in one run, on the same energy, from the same start, to the same norm.

    cargo build --release --benches
    python3 benches/peers/cloth_compare.py [--json FILE] [--venv FOLDER] [--only NUMBER,NUMBER...]

Ours, projected Newton steps, the crate liblbfgs and dynamic relaxation run inside our benchmark program (`cloth peers`). L-BFGS-B of scipy
(installed, pinned, in a virtual environment) gets energy and gradient from the same program over a pipe (`cloth serve`); its seconds
contain the pipe, beside them stand those spent in answering. The energy norm is looked at every 2 % of the evaluations, outside all
seconds. Every method ends at a relative norm of 1e-4, after 20 000 evaluations or 60 s.
"""

import argparse
import datetime
import json
import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import time
import venv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# Threads for dot products of this size only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
PINNED = ["scipy==1.17.1", "numpy==2.4.6"]
TOLERANCE, EVALUATION_LIMIT, SECONDS_LIMIT = 1e-4, 20_000, 60.0


def bench_program():
    built = [p for p in (ROOT / "target/release/deps").glob("cloth-*") if p.suffix == "" and os.access(p, os.X_OK)]
    if not built:
        sys.exit("no benchmark program: run `cargo build --release --benches` first")
    return max(built, key=lambda p: p.stat().st_mtime)


def environment(folder):
    python = folder / "bin" / "python"
    if not python.exists():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PINNED], check=True)
    return python


class Reached(Exception):
    pass


class Server:
    """Energy and gradient of one problem."""

    def __init__(self, program, number):
        import numpy

        self.numpy = numpy
        self.process = subprocess.Popen([program, "serve", str(number)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.count = int(self.numbers(1)[0])
        self.start = self.numbers(self.count)
        self.evaluations, self.next, self.norm = 0, 0, float("nan")
        self.answering = self.outside = 0.0
        self.began = time.perf_counter()

    def numbers(self, count):
        data = self.process.stdout.read(8 * count)
        if len(data) != 8 * count:
            sys.exit("the server stopped")
        return self.numpy.frombuffer(data).copy()

    def ask(self, kind, x):
        self.process.stdin.write(kind + self.numpy.ascontiguousarray(x, dtype=float).tobytes())
        self.process.stdin.flush()
        return self.numbers(1 + (self.count if kind == b"e" else 0))

    def evaluate(self, x):
        began = time.perf_counter()
        answer = self.ask(b"e", x)
        self.answering += time.perf_counter() - began
        self.evaluations += 1
        return answer[0], answer[1:]

    def seconds(self):
        return time.perf_counter() - self.began - self.outside

    def after_iteration(self, x):
        if self.evaluations >= self.next:
            began = time.perf_counter()
            self.norm = self.ask(b"n", x)[0]
            self.outside += time.perf_counter() - began
            self.next = self.evaluations + 1 + self.evaluations // 50
        if self.norm <= TOLERANCE:
            raise Reached("reached")
        if self.evaluations >= EVALUATION_LIMIT or self.seconds() > SECONDS_LIMIT:
            raise Reached("limit")


def scipy_minimise(program, number, problem):
    from scipy.optimize import minimize

    server = Server(program, number)
    try:
        options = {"maxcor": 10, "ftol": 0.0, "gtol": 0.0, "maxfun": 10 * EVALUATION_LIMIT, "maxiter": 10 * EVALUATION_LIMIT}
        result = minimize(
            server.evaluate, server.start, jac=True, method="L-BFGS-B", callback=server.after_iteration, options=options)
        stop = str(result.message)
    except Reached as reached:
        stop = str(reached)
    seconds = server.seconds()
    server.process.stdin.close()
    server.process.wait()
    return {
        "problem": problem, "method": "scipy L-BFGS-B", "stop": stop, "evaluations": server.evaluations, "cycles": None,
        "seconds": seconds, "seconds_answering": server.answering, "relative_energy_norm": server.norm,
    }


def worker(options):
    problem = json.loads(subprocess.run([options.program, "problems"], capture_output=True, check=True).stdout)[options.worker]
    print(json.dumps(scipy_minimise(options.program, options.worker, problem)))


def show(row):
    print(
        f"{'':>33} {row['method']:>28} {row['stop'][:12]:>12} {row['evaluations']:>7} {'-':>6} {row['seconds']:>9.3f}"
        f" {row['relative_energy_norm']:>9.1e}  ({row['seconds_answering']:.3f} s answering)", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--venv", type=pathlib.Path, default=ROOT / "target/peers-cloth-venv")
    parser.add_argument("--program", type=pathlib.Path, default=None)
    parser.add_argument("--only", default="", help="numbers of problems, e.g. 0,3")
    parser.add_argument("--worker", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.program = options.program or bench_program()
    if options.worker is not None:
        worker(options)
        return
    python = environment(options.venv)
    problems = json.loads(subprocess.run([options.program, "problems"], capture_output=True, check=True).stdout)
    numbers = [int(n) for n in options.only.split(",")] if options.only else range(len(problems))
    rows = []
    for number in numbers:
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "rows.json"
            subprocess.run([options.program, "peers", str(number), file], check=True)
            rows += json.loads(file.read_text())["peers"]["rows"]
        command = [python, __file__, "--program", options.program, "--worker", str(number)]
        row = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
        show(row)
        rows.append(row)
        if options.json:
            write(options.json, rows)


def write(file, rows):
    """Takes the place of rows of the same problems."""
    report = json.loads(file.read_text()) if file.exists() else {}
    new = [row["problem"] for row in rows]
    kept = [row for row in report.get("peers", {}).get("rows", []) if row["problem"] not in new]
    report["peers"] = {
        "machine": os.environ.get("RIPSTOP_MACHINE", platform.processor() or platform.machine()),
        "commit": os.environ.get("RIPSTOP_COMMIT") or subprocess.run(
            ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip(),
        "date": os.environ.get("RIPSTOP_DATE", datetime.date.today().isoformat()),
        "scipy": PINNED[0], "tolerance": TOLERANCE, "rows": kept + rows,
    }
    file.write_text(json.dumps(report, indent=1) + "\n")


if __name__ == "__main__":
    main()
