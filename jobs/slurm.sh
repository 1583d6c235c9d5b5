#!/bin/bash
# One run on a cluster with Slurm:   sbatch jobs/slurm.sh pool --set time.end=10
# What is said after the script's name goes to `parsph run`.
#
# Set here, or on sbatch's command line: account and partition as your cluster asks for them, nodes, ranks and wall time.
#SBATCH --job-name=parsph
#SBATCH --nodes=1
#SBATCH --ntasks-per-node=16        # one rank per core: parsph does not use threads
#SBATCH --cpus-per-task=1
#SBATCH --time=02:00:00             # `parsph plan SCENE` estimates core time; leave room
#SBATCH --output=%x-%j.log          # progress comes as plain lines
##SBATCH --account=...
##SBATCH --partition=...
set -euo pipefail

# Set these two for your cluster.
# 1. The MPI that mpi4py finds must be the one that srun knows: load its module. Not needed on one node with `mpirun`.
# module load openmpi
# 2. The environment that parsph is installed in; default: .venv in the folder that sbatch was called in.
python=${PARSPH_PYTHON:-.venv/bin/python}

# The compiled code is cached here; one rank per node compiles. Must be a folder that all nodes can write to, or a local one.
# export NUMBA_CACHE_DIR=$TMPDIR
export OMP_NUM_THREADS=1

# With the cluster's MPI. If every rank says "1 rank(s)", srun and mpi4py speak different MPIs: see jobs/README.md.
srun "$python" -m parsph run "${@:-pool}"

# With the `mpich` wheel of the extra `mpi`, on the nodes of this job:
# "$(dirname "$python")/mpirun" -n "$SLURM_NTASKS" "$python" -m parsph run "${@:-pool}"
