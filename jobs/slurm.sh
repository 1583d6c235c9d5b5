#!/bin/bash
# One run on a cluster with Slurm, in as many goes as it takes:
#   sbatch jobs/slurm.sh SCENE FOLDER [options of parsph run]     as   sbatch jobs/slurm.sh pool runs/pool --set time.end=10
# A job that is preempted, or whose time is nearly over, writes a checkpoint, requeues itself and goes on from there. The same
# command again, with the same FOLDER, goes on as well. jobs/README.md tells more.
#
# Set here, or on sbatch's command line: account and partition as your cluster asks for them, nodes, ranks and wall time.
#SBATCH --job-name=parsph
#SBATCH --nodes=1
#SBATCH --ntasks-per-node=16        # one rank per core: parsph does not use threads
#SBATCH --cpus-per-task=1
#SBATCH --time=02:00:00             # of one go
#SBATCH --signal=USR1@180           # s before the end of a go, or up to a minute more: time for a checkpoint
#SBATCH --requeue
#SBATCH --open-mode=append          # all goes in one log
#SBATCH --output=%x-%j.log          # progress comes as plain lines
##SBATCH --account=...
##SBATCH --partition=...
set -euo pipefail

# Set these for your cluster.
# 1. The environment that parsph is installed in; default: .venv in the folder that sbatch was called in.
python=${PARSPH_PYTHON:-.venv/bin/python}
# 2. How ranks are started: with the `mpich` wheel of the extra `mpi`, on all nodes of the job, or with the cluster's MPI.
launch=("$(dirname "$python")/mpirun" -n "$SLURM_NTASKS")
# module load mpich
# launch=(srun --mpi=pmi2)
# 3. How often a job may be requeued.
most=100

# The compiled code is cached here; one rank per node compiles. Must be a folder that all nodes can write to, or a local one.
# export NUMBA_CACHE_DIR=$TMPDIR
export OMP_NUM_THREADS=1

if [ $# -lt 2 ]; then
    echo "usage: sbatch jobs/slurm.sh SCENE FOLDER [options of parsph run]" >&2
    exit 2
fi
scene=$1 folder=$2
if [ -e "$folder/scene.json" ]; then
    command=(resume "$folder")
else
    command=(run "$scene" --out "$folder" "${@:3}")
fi
code=0
"${launch[@]}" "$python" -m parsph "${command[@]}" || code=$?

# A job may be preempted before its ranks listen to signals; then the launcher ends with a code of its own.
preempted() { [[ $(scontrol show job "$SLURM_JOB_ID") =~ PreemptTime=[0-9] ]]; }

if [ "$code" = 85 ] || { [ "$code" -gt 2 ] && preempted; }; then
    if [ "${SLURM_RESTART_COUNT:-0}" -ge "$most" ]; then
        echo "requeued $most times and not finished: the same sbatch command goes on"
        exit "$code"
    fi
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$code"
