#!/bin/bash
# A study as a job array on a cluster with Slurm, a row a task:
#   sbatch --array=0-53 jobs/slurm-study.sh absorbing-2d --out studies/absorbing-2d
# What is said after the script's name goes to `parsph study`; --out must be there, the same folder for all tasks.
# `parsph study absorbing-2d --list` numbers the rows; jobs/README.md says how table and report follow.
#
# Set here, or on sbatch's command line: account and partition as your cluster asks for them, ranks and wall time of a row.
#SBATCH --job-name=parsph-study
#SBATCH --nodes=1
#SBATCH --ntasks=1                  # ranks of a row: one core each, and a few thousand particles at least
#SBATCH --cpus-per-task=1
#SBATCH --time=02:00:00             # of the longest row: `parsph study NAME --list` estimates core time; leave room
#SBATCH --output=%x-%A_%a.log       # progress comes as plain lines
##SBATCH --account=...
##SBATCH --partition=...
set -euo pipefail

# Set these two for your cluster, as in jobs/slurm.sh.
# module load openmpi
python=${PARSPH_PYTHON:-.venv/bin/python}

# The compiled code is cached here; the first tasks compile. Must be a folder that all nodes can write to, or a local one.
# export NUMBA_CACHE_DIR=$TMPDIR
export OMP_NUM_THREADS=1

row=${SLURM_ARRAY_TASK_ID:?is not set: submit with sbatch --array=0-LAST}

# With the cluster's MPI.
srun "$python" -m parsph study "$@" --row "$row"

# With the `mpich` wheel of the extra `mpi`, on the nodes of this task:
# "$(dirname "$python")/mpirun" -n "$SLURM_NTASKS" "$python" -m parsph study "$@" --row "$row"
