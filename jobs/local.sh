#!/usr/bin/env bash
# One run on the cores at hand, in as many goes as it takes:
#   jobs/local.sh SCENE FOLDER [options of parsph run]     as   jobs/local.sh pool runs/pool --set time.end=10
# SIGTERM, a hang-up or Ctrl-C stops it after a checkpoint, with exit code 85; the same command again goes on from there. So it
# may run under `timeout 8h`, `nohup`, `at` or as a unit of systemd. jobs/README.md tells more.
#
# RANKS           number of ranks; default: the cores that this process may use
# PARSPH_PYTHON   Python of the environment that parsph is installed in, with the extra `mpi`; default .venv/bin/python
set -euo pipefail

python=${PARSPH_PYTHON:-.venv/bin/python}
launch=("$(dirname "$python")/mpirun" -n "${RANKS:-$(nproc)}")
most=100 # goes in one call
export OMP_NUM_THREADS=1

if [ $# -lt 2 ]; then
    echo "usage: jobs/local.sh SCENE FOLDER [options of parsph run]" >&2
    exit 2
fi
scene=$1 folder=$2

stopped=0 child=
trap 'stopped=1; kill -TERM "$child" 2>/dev/null || true' TERM INT HUP
for ((go = 0; go < most && !stopped; go++)); do
    if [ -e "$folder/scene.json" ]; then
        command=(resume "$folder")
    else
        command=(run "$scene" --out "$folder" "${@:3}")
    fi
    # In a process group of its own: Ctrl-C would make mpirun kill its ranks, SIGTERM it passes on.
    set -m
    "${launch[@]}" "$python" -m parsph "${command[@]}" </dev/null &
    child=$!
    set +m
    while kill -0 "$child" 2>/dev/null; do wait "$child" || true; done # a signal cuts a wait short
    code=0
    wait "$child" || code=$?
    [ "$code" = 85 ] || exit "$code"
done
echo "not finished yet: the same command goes on"
exit 85
