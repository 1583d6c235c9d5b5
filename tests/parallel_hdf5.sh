#!/usr/bin/env bash
# The parallel HDF5 writer against a real parallel h5py: h5py is built with Debian's Open MPI in an environment of its own,
# scenes run there on 1, 2 and 3 ranks, and their snapshots must equal those of the ordinary environment to the bit; so must
# those of runs that begin there, are stopped with a checkpoint, and go on in the ordinary environment.
#
#   tests/parallel_hdf5.sh [PYTHON]     PYTHON of the ordinary environment; default .venv/bin/python
#
# PARSPH_CI_CACHE keeps the built wheel between runs; default ${XDG_CACHE_HOME:-~/.cache}/parsph-ci.
# Exit codes: 0 equal, 1 different or failed, 77 could not be set up here (the last line says why).
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
ordinary=${1:-$root/.venv/bin/python}
cache=${PARSPH_CI_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/parsph-ci}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 143' TERM INT
cd "$root"

skip() {
    if [ -s "$work/log" ]; then tail -n 15 "$work/log" >&2; fi
    echo "not set up: $1"
    exit 77
}

# --- libraries -------------------------------------------------------------------------------------------------------

. tests/packages.sh
need gcc libc6-dev libhdf5-openmpi-dev openmpi-bin
launcher=$(command -v mpirun.openmpi) || skip "mpirun.openmpi is not on the path"

# --- an environment with a parallel h5py -----------------------------------------------------------------------------

# The same versions of everything else as in the ordinary environment: equal bits are asked for.
"$ordinary" -m pip freeze | grep -E '^[A-Za-z0-9._-]+==' | grep -vi '^h5py==' >"$work/versions"
wheels=$cache/$("$ordinary" -c 'import platform, sys; print(f"cp{sys.version_info[0]}{sys.version_info[1]}-{platform.machine()}")')
wheels=$wheels-hdf5-$(dpkg-query -W -f '${Version}' libhdf5-openmpi-dev | tr -c 'A-Za-z0-9.\n' -)
mkdir -p "$wheels"

"$ordinary" -m venv "$work/venv" || skip "no virtual environment can be made"
python=$work/venv/bin/python
install() { "$python" -m pip install --quiet --constraint "$work/versions" "$@" >"$work/log" 2>&1; }
install numpy mpi4py || skip "pip could not install numpy and mpi4py"
if ! ls "$wheels"/h5py-*.whl >/dev/null 2>&1; then
    echo "building h5py with MPI (minutes; the wheel is kept in $wheels)"
    install -U setuptools wheel cython pkgconfig || skip "pip could not install what the build of h5py needs"
    CC=mpicc.openmpi HDF5_MPI=ON timeout 540 "$python" -m pip wheel --no-build-isolation --no-binary=h5py --no-deps \
        --wheel-dir "$work/built" h5py >"$work/log" 2>&1 || skip "h5py could not be built with MPI"
    mv "$work"/built/h5py-*.whl "$wheels"
fi
install "$wheels"/h5py-*.whl || skip "the built h5py could not be installed"
"$python" -c 'import h5py; assert h5py.get_config().mpi' || skip "the built h5py has no MPI"
install . || { cat "$work/log"; exit 1; }

# --- runs ------------------------------------------------------------------------------------------------------------

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none # containers forbid the kernel's copy between processes
export OMP_NUM_THREADS=1 COLUMNS=160

# Water at one end of a long dry channel: all in the columns of the first rank, and on its way to the second.
cat >"$work/dry.toml" <<'TOML'
title = "a little water at one end of a long dry channel"

[domain]
size = [4.0, 0.3]

[fluid]
blocks = [{ low = [0.0, 0.0], high = [0.16, 0.2] }]

[walls]
left = {}
right = {}
bottom = {}

[numerics]
dx = 0.02
diffusion = "fourtakas"
viscosity = "monaghan"
alpha = 0.1

[time]
end = 0.06

[output.snapshots]
every = 0.03
TOML

compare=(timeout 60 "$ordinary" tests/compare_snapshots.py)
options=(--set time.end=0.05 --set output.snapshots.every=0.025)
for case in pool "$work/dry.toml"; do
    name=$(basename "$case" .toml)
    [ "$name" = pool ] && set -- "${options[@]}" || set --
    timeout 180 "$ordinary" -m parsph run "$case" "$@" --out "$work/$name-serial" >"$work/log" 2>&1 \
        || { cat "$work/log"; exit 1; }
    for ranks in 1 2 3; do
        timeout 180 "$launcher" -n "$ranks" "$python" -m parsph run "$case" "$@" --ranks-info \
            --out "$work/$name-$ranks" >"$work/log" 2>&1 || { cat "$work/log"; echo "$name failed on $ranks ranks"; exit 1; }
        grep -q "$ranks rank(s)" "$work/log" || { cat "$work/log"; echo "not a job of $ranks ranks"; exit 1; }
        if [ "$name" = dry ] && [ "$ranks" -gt 1 ]; then
            grep -q ' 0 particles' "$work/log" || { cat "$work/log"; echo "no rank was without particles"; exit 1; }
        fi
        "${compare[@]}" "$work/$name-serial" "$work/$name-$ranks"
    done
done

# Checkpoints, written collectively - of `dry` by ranks without particles too -, that the serial h5py reads on 1 and 2 ranks.
cat >"$work/stopped.py" <<'PY'
import os, signal, sys
from parsph.io import checkpoints
from parsph.parallel import end_job_on_error
from parsph.verify.injection import after_step

checkpoints.LOOK = 0.0  # after every step
after_step(lambda simulation: os.kill(os.getpid(), signal.SIGTERM), step=20)
from parsph.cli import main

main()
PY
for name in pool dry; do
    [ "$name" = pool ] && set -- pool "${options[@]}" || set -- "$work/dry.toml"
    for ranks in 2 3; do
        run=$work/$name-stopped-$ranks
        code=0
        timeout 180 "$launcher" -n "$ranks" "$python" "$work/stopped.py" run "$@" --ranks-info --out "$run" >"$work/log" 2>&1 \
            || code=$?
        if [ "$code" != 85 ] || ! ls "$run"/checkpoints/*.vtkhdf >/dev/null 2>&1; then
            cat "$work/log"
            echo "$name on $ranks ranks ended with $code in place of 85 and a checkpoint"
            exit 1
        fi
        "$ordinary" -c 'import h5py, sys; sizes = h5py.File(sys.argv[1])["VTKHDF/NumberOfPoints"][:]
sys.exit(len(sizes) != int(sys.argv[2]) or (sys.argv[3] == "dry" and all(sizes)))' \
            "$(ls "$run"/checkpoints/*.vtkhdf | tail -n 1)" "$ranks" "$name" || { echo "not the parts of $ranks ranks"; exit 1; }
        for later in 1 2; do
            cp -r "$run" "$run-$later"
            timeout 180 "$("$ordinary" -c 'from pathlib import Path; import sys; print(Path(sys.executable).parent / "mpirun")')" \
                -n "$later" "$ordinary" -m parsph resume "$run-$later" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
            "${compare[@]}" "$work/$name-serial" "$run-$later"
        done
    done
done

timeout 180 "$launcher" -n 2 "$python" -m parsph bench --output --particles 200000 --repeats 3 --out "$work"
echo "parallel HDF5: snapshots and checkpoints equal to the bit on 1, 2 and 3 ranks, with a rank without particles too"
