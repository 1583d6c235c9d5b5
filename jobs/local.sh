#!/usr/bin/env bash
# One run on the cores at hand:   jobs/local.sh pool --set time.end=10
#
# RANKS           number of ranks; default: the cores that this process may use
# PARSPH_PYTHON   Python of the environment that parsph is installed in, with the extra `mpi`; default .venv/bin/python
set -euo pipefail

python=${PARSPH_PYTHON:-.venv/bin/python}
ranks=${RANKS:-$(nproc)}
export OMP_NUM_THREADS=1
exec "$(dirname "$python")/mpirun" -n "$ranks" "$python" -m parsph run "${@:-pool}"
