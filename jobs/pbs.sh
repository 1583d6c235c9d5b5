#!/bin/bash
# One run on a cluster with PBS Pro, OpenPBS or Torque, in as many jobs as it takes:
#   qsub -v SCENE=pool,OUT=runs/pool jobs/pbs.sh
# A job whose wall time is nearly over writes a checkpoint and submits the next one, which goes on from there. The same
# command again goes on as well. jobs/README.md tells more.
#
# Set here, or on qsub's command line: project and queue as your cluster asks for them, nodes, ranks and wall time.
#PBS -N parsph
#PBS -l select=1:ncpus=16:mpiprocs=16
##PBS -l nodes=1:ppn=16
#PBS -l walltime=02:00:00
#PBS -r y
#PBS -j oe
##PBS -A ...
##PBS -q ...
# `select` is of PBS Pro and OpenPBS, `nodes` of Torque: one rank per core. `-r y`: a job that is preempted, or loses its node,
# begins again, and goes on from the last checkpoint.
set -euo pipefail
cd "$PBS_O_WORKDIR"

# Set these for your cluster; what is exported goes on to the next job.
# 1. This file, as seen from the folder that qsub was called in.
script=jobs/pbs.sh
# 2. The environment that parsph is installed in.
export PARSPH_PYTHON=${PARSPH_PYTHON:-.venv/bin/python}
# 3. How ranks are started: with the `mpich` wheel of the extra `mpi`, on all nodes of the job, or with the cluster's MPI.
launch=("$(dirname "$PARSPH_PYTHON")/mpirun" -n "$(wc -l <"$PBS_NODEFILE")")
# 4. What runs, where, and options of `parsph run`.
export SCENE=${SCENE:-pool} OUT=${OUT:-runs/pool}
options=()
# 5. How many jobs the run may take.
most=100
export JOB=${JOB:-1}

# The compiled code is cached here; one rank per node compiles. Must be a folder that all nodes can write to, or a local one.
# export NUMBA_CACHE_DIR=$TMPDIR
export OMP_NUM_THREADS=1

walltime=$(qstat -f "$PBS_JOBID" | awk '$1 == "Resource_List.walltime" { print $3 }')
if [ -e "$OUT/scene.json" ]; then
    command=(resume "$OUT")
else
    command=(run "$SCENE" --out "$OUT" "${options[@]}")
fi
code=0
"${launch[@]}" "$PARSPH_PYTHON" -m parsph "${command[@]}" --walltime "$walltime" || code=$?

if [ "$code" = 85 ]; then
    if [ "$JOB" -ge "$most" ]; then
        echo "not finished after $most jobs: the same qsub command goes on"
        exit "$code"
    fi
    JOB=$((JOB + 1))
    qsub -v SCENE,OUT,JOB,PARSPH_PYTHON "$script" # not qrerun, which is for operators alone
    exit 0
fi
exit "$code"
