#!/usr/bin/env python3
"""Our air on the CPU against lbmpy's generated kernels, in alternation, on the same machine and in the same run.

    cargo build --release --benches
    python3 benches/peers/lbmpy_compare.py [--json FILE] [--rounds 7] [--seconds 0.4] [--venv FOLDER] [--only trt,f32,128]

Makes a virtual environment, installs lbmpy (pinned), and for every set-up, size and number of threads alternates rounds of our benchmark
program (`fluid serve`), of lbmpy's AA and eso-twist kernels, and of a plain pass over memory in place. A ratio is taken within each round, since
memory bandwidth of shared machines changes within seconds; the table shows medians. Needs a C++ compiler with OpenMP.
Ours includes what enters through periodic faces; lbmpy's is the kernel alone. Beside the speeds stands the relative error of the decay
rate of a shear wave, for both.
"""

import argparse
import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import venv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PINNED = ["lbmpy==1.3.7", "pystencils==1.3.7", "numpy<3"]
PATTERNS = ["aa", "esotwist"]


class Worker:
    """A program that answers every line with a line of JSON."""

    def __init__(self, command, threads):
        # Threads must sleep while the other side is timed.
        environment = os.environ | {
            "OMP_NUM_THREADS": str(threads), "RAYON_NUM_THREADS": str(threads), "OMP_WAIT_POLICY": "passive"}
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)

    def ask(self, *words):
        self.process.stdin.write(" ".join(map(str, words)) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"the worker {self.process.args} stopped")
        answer = json.loads(line)
        if "error" in answer:
            print("   ", words, answer["error"], file=sys.stderr)
        return answer

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def bench_program():
    built = [p for p in (ROOT / "target/release/deps").glob("fluid-*") if p.suffix == "" and os.access(p, os.X_OK)]
    if not built:
        sys.exit("no benchmark program: run `cargo build --release --benches` first")
    return max(built, key=lambda p: p.stat().st_mtime)


def environment(folder):
    python = folder / "bin" / "python"
    if not python.exists():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PINNED], check=True)
    return python


def one_round(ours, peers, case, seconds):
    speed = "million_lattice_updates_per_s"
    row = {"in_place": ours.ask("memory", "-", 0, seconds).get("gigabytes_per_s_in_place"), "ours": ours.ask(*case, seconds).get(speed)}
    for pattern, worker in peers.items():
        row[pattern] = worker.ask(pattern, *case, seconds).get(speed)
    return row


def alternate(ours, peers, case, options):
    return [one_round(ours, peers, case, options.seconds) for _ in range(options.rounds)]


def compare(setup, precision, side, threads, options, python):
    bytes_per_cell = 38 * (4 if precision == "f32" else 8)
    ours = Worker([options.program, "serve"], threads)
    peers = {p: Worker([python, HERE / "lbmpy_worker.py"], threads) for p in PATTERNS}
    case = (setup, precision, side)
    one_round(ours, peers, case, 0.01)  # builds the kernels and warms up
    rows = alternate(ours, peers, case, options)
    for worker in (ours, *peers.values()):
        worker.close()
    median = lambda values: statistics.median(list(values))
    result = {
        "setup": setup, "precision": precision, "side": side, "threads": threads,
        "gigabytes_per_s_in_place": median(r["in_place"] for r in rows),
        "ours_million_lattice_updates_per_s": median(r["ours"] for r in rows),
        "share_of_bandwidth_in_place": median(r["ours"] * bytes_per_cell / 1e3 / r["in_place"] for r in rows),
        "rounds": rows,
    }
    for pattern in PATTERNS:
        valid = [r for r in rows if r[pattern]]
        if valid:
            result[f"lbmpy_{pattern}_million_lattice_updates_per_s"] = median(r[pattern] for r in valid)
            result[f"ratio_to_{pattern}"] = median(r["ours"] / r[pattern] for r in valid)
    best = [max(r[p] for p in PATTERNS if r[p]) for r in rows if any(r[p] for p in PATTERNS)]
    if best:
        result["ratio_to_the_better"] = median(r["ours"] / b for r, b in zip(rows, best))
    print(
        f"{setup:>8} {precision} {side:>4}^3 {threads} threads: ours {result['ours_million_lattice_updates_per_s']:6.0f}"
        + "".join(f", {p} {result.get(f'lbmpy_{p}_million_lattice_updates_per_s', float('nan')):6.0f}" for p in PATTERNS)
        + f" MLUPS; ratio to the better {result.get('ratio_to_the_better', float('nan')):.2f};"
        + f" {100 * result['share_of_bandwidth_in_place']:.0f} % of {result['gigabytes_per_s_in_place']:.0f} GB/s in place", flush=True)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=0.4)
    parser.add_argument("--venv", type=pathlib.Path, default=ROOT / "target/peers-venv")
    parser.add_argument("--only", default="", help="words that a comparison must all have, e.g. trt,f32,128,2")
    options = parser.parse_args()
    options.program = bench_program()
    python = environment(options.venv)
    wanted = set(filter(None, options.only.split(",")))
    cases = [
        case
        for case in [
            *(("trt", p, side, threads) for p in ("f32", "f64") for side in (128, 192) for threads in (1, 2)),
            *(("canopy", "f32", side, threads) for side in (128, 192) for threads in (1, 2)),
        ]
        if wanted <= set(map(str, case))
    ]
    report = {
        "benchmark": "cpu-fluid",
        "machine": os.environ.get("RIPSTOP_MACHINE", platform.processor() or platform.machine()),
        "commit": os.environ.get("RIPSTOP_COMMIT") or subprocess.run(
            ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip(),
        "date": os.environ.get("RIPSTOP_DATE", datetime.date.today().isoformat()),
        "peer": PINNED[0], "rounds": options.rounds, "seconds_per_round": options.seconds,
        "physics": [], "comparisons": [],
    }
    for precision in ("f32", "f64"):
        ours, peer = Worker([options.program, "serve"], 1), Worker([python, HERE / "lbmpy_worker.py"], 1)
        row = {"precision": precision, "what": "relative error of the decay rate of a shear wave, 64^3, 400 steps",
               "ours": ours.ask("decay", precision, 64, 400).get("decay_rate_error")}
        for pattern in PATTERNS:
            row[pattern] = peer.ask(pattern, "decay", precision, 64, 400).get("decay_rate_error")
        print("decay rate error", row, flush=True)
        report["physics"].append(row)
        ours.close()
        peer.close()
    for case in cases:
        report["comparisons"].append(compare(*case, options, python))
    if options.json:
        options.json.write_text(json.dumps(report, indent=2) + "\n")
        print(f"written to {options.json}")


if __name__ == "__main__":
    main()
