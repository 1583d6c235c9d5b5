#!/bin/bash
# A study as a job array on a cluster with Slurm, a row a task:
#   sbatch --array=0-53 jobs/slurm-study.sh absorbing-2d --out studies/absorbing-2d
# What is said after the script's name goes to `parsph study`; --out must be there, the same folder for all tasks.
# `parsph study absorbing-2d --list` numbers the rows; jobs/README.md says how table and report follow.
# A task that is preempted, or whose time is nearly over, writes a checkpoint, requeues itself and goes on from there.
#
# Set here, or on sbatch's command line: account and partition as your cluster asks for them, ranks and wall time of a row.
#SBATCH --job-name=parsph-study
#SBATCH --nodes=1
#SBATCH --ntasks=1                  # ranks of a row: one core each, and a few thousand particles at least
#SBATCH --cpus-per-task=1
#SBATCH --time=02:00:00             # of one go at a row: `parsph study NAME --list` estimates core time
#SBATCH --signal=USR1@180           # s before the end of a go, or up to a minute more: time for a checkpoint
#SBATCH --requeue
#SBATCH --open-mode=append          # all goes in one log
#SBATCH --output=%x-%A_%a.log       # progress comes as plain lines
##SBATCH --account=...
##SBATCH --partition=...
set -euo pipefail

# Set these for your cluster, as in jobs/slurm.sh.
python=${PARSPH_PYTHON:-.venv/bin/python}
launch=("$(dirname "$python")/mpirun" -n "$SLURM_NTASKS")
# module load mpich
# launch=(srun --mpi=pmi2)
most=100

# The compiled code is cached here; the first tasks compile. Must be a folder that all nodes can write to, or a local one.
# export NUMBA_CACHE_DIR=$TMPDIR
export OMP_NUM_THREADS=1

row=${SLURM_ARRAY_TASK_ID:?is not set: submit with sbatch --array=0-LAST}
task=${SLURM_ARRAY_JOB_ID}_$row # the job's own number stands for the whole array in one of the tasks
code=0
"${launch[@]}" "$python" -m parsph study "$@" --row "$row" || code=$?

# A task may be preempted before its ranks listen to signals; then the launcher ends with a code of its own.
preempted() { [[ $(scontrol show job "$task") =~ PreemptTime=[0-9] ]]; }

if [ "$code" = 85 ] || { [ "$code" -gt 2 ] && preempted; }; then
    if [ "${SLURM_RESTART_COUNT:-0}" -ge "$most" ]; then
        echo "requeued $most times and not finished: sbatch --array=$row ... goes on"
        exit "$code"
    fi
    scontrol requeue "$task"
fi
exit "$code"
