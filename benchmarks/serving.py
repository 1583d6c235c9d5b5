"""One code in a process of its own, which goes on when it is told: two codes can be timed in turns on a busy machine.

Imports nothing but numpy, so that it runs in the environment of either code.
"""

import json
import math
import re
import sys
import time
from pathlib import Path

import numpy as np


def peak_memory():
    """Return the most bytes of memory that this process has had; nan: unknown.

    Not by `getrusage`, which counts what the process had that started this one.
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="utf-8")
    except OSError:
        return math.nan
    return 1024 * int(re.search(r"VmHWM:\s+(\d+) kB", status)[1])


def serve(make):
    """Make a flow, then answer each time on stdin [s], a line each, by what it took to get there.

    Parameters
    ----------
    make : callable
        Called with the settings of the first argument of the command line, an object in JSON: "case", and "dx" [m] of the dam
        break or "per radius", particles, and "method" of the drop. Returns the flow, with

        - `advance(time)`, which goes on to `time` [s];
        - `evaluations`, how often all rates have been worked out;
        - `particles` and `fluid`, the number of particles that an evaluation visits, and of those the fluid's;
        - `positions()`, of the fluid [m], shape (n, 2).
    """
    answers, sys.stdout = sys.stdout, sys.stderr  # what a code prints is no answer
    flow = make(json.loads(sys.argv[1]))
    for line in sys.stdin:
        before, begin, clock = flow.evaluations, time.process_time(), time.perf_counter()
        flow.advance(float(line))
        position = flow.positions()
        answer = {
            "CPU [s]": time.process_time() - begin,
            "wall [s]": time.perf_counter() - clock,
            "evaluations": flow.evaluations - before,
            "particles": flow.particles,
            "fluid": flow.fluid,
            "front [m]": float(position[:, 0].max()),
            "half axes [m]": (2 * position.std(axis=0)).tolist(),
            "peak memory [bytes]": peak_memory(),
        }
        if not np.isfinite(position).all():
            raise SystemExit(f"positions are not finite at t = {line.strip()} s")
        print(json.dumps(answer), file=answers, flush=True)
