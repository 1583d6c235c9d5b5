#!/usr/bin/env bash
# The job scripts under a real Slurm: two nodes of one core each, both on this machine, with daemons and folders of their own.
# A run on two ranks has a limit of one minute, which is too short for it. It is warned, then preempted, then cancelled and
# submitted again with one rank, and must leave what an uninterrupted run leaves, to the bit. A study runs as an array, one of
# its rows in two goes.
#
#   tests/slurm.sh [PYTHON]     PYTHON of the environment with parsph and MPI; default .venv/bin/python
#
# Exit codes: 0 passed, 1 different or failed, 77 could not be set up here (the last line says why).
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
python=$(realpath --no-symlinks "${1:-$root/.venv/bin/python}")
work=$(mktemp -d)
daemons=()
cd "$root"

clean_up() {
    if [ -e "$work/ready" ]; then
        timeout 10 scancel --user="$(id -un)" || true
        for ((i = 0; i < 50; i++)); do [ -z "$(timeout 10 squeue --noheader)" ] && break || sleep 0.2; done
    fi
    for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do kill "${daemons[i]}" 2>/dev/null || true; done
    wait
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 143' TERM INT

skip() {
    tail -n 15 "$work"/*log >&2 || true
    echo "not set up: $1"
    exit 77
}

fail() {
    tail -n 25 "$work"/*.log "$work/log" >&2 || true
    echo "failed: $1"
    exit 1
}

# Prints a line with the minutes since the start.
report() { printf '%s (%d:%02d)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)); }

# Waits until a command succeeds, SECONDS at most.
within() {
    local seconds=$1 begin=$SECONDS
    shift
    until "$@"; do
        [ $((SECONDS - begin)) -lt "$seconds" ] || fail "after $seconds s still not: $*"
        sleep 0.2
    done
}

# --- Slurm -----------------------------------------------------------------------------------------------------------

# shellcheck source=tests/packages.sh
. tests/packages.sh
need slurm-wlm munge
[ "$(id -u)" = 0 ] || skip "only root can start Slurm's daemons"

unset "${!SLURM_@}" "${!SBATCH_@}"
export SLURM_CONF=$work/slurm.conf
chmod 755 "$work" # munged is not root
mkdir -p "$work"/{munge,state,spool/tank1,spool/tank2}
head -c 1024 /dev/urandom >"$work/munge/key"
chmod 400 "$work/munge/key"
chown -R munge: "$work/munge"
read -r -a ports < <("$python" -c '
import socket
sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(3)]
print(*(each.getsockname()[1] for each in sockets))')

# GraceTime: what is preempted may write a checkpoint. cred_expire: Slurm lets requeued jobs wait as long, 120 s unless told.
cat >"$SLURM_CONF" <<CONF
ClusterName=test
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket,cred_expire=5
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
StateSaveLocation=$work/state
SlurmctldPidFile=$work/slurmctld.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdSpoolDir=$work/spool/%n
SlurmdPidFile=$work/slurmd-%n.pid
SlurmdLogFile=$work/slurmd-%n.log
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
JobRequeue=1
KillWait=5
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
NodeName=tank1 NodeHostname=$(hostname) NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=1
NodeName=tank2 NodeHostname=$(hostname) NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=1
PartitionName=low Nodes=tank[1-2] PriorityTier=1 GraceTime=30 Default=YES
PartitionName=high Nodes=tank[1-2] PriorityTier=2 PreemptMode=OFF
CONF

daemon() {
    setsid "$@" >>"$work/log" 2>&1 &
    daemons+=($!)
}
daemon setpriv --reuid=munge --regid=munge --clear-groups munged --foreground --key-file="$work/munge/key" \
    --socket="$work/munge/socket" --pid-file="$work/munge/pid" --seed-file="$work/munge/seed"
for ((i = 0; i < 50; i++)); do [ -S "$work/munge/socket" ] || sleep 0.1; done
daemon slurmctld -D -c
daemon slurmd -D -N tank1
daemon slurmd -D -N tank2
for ((i = 0; i < 100; i++)); do
    [ "$(sinfo --noheader --partition=low --format='%D %T' 2>&1)" = "2 idle" ] || sleep 0.2
done
timeout 20 srun --nodes=2 true >>"$work/log" 2>&1 || skip "Slurm's two nodes do not run a step"
touch "$work/ready"
report "$(slurmctld -V) runs jobs on two nodes"

# --- the uninterrupted run, which also compiles: no job may spend its minute so ----------------------------------------

export PARSPH_PYTHON=$python OMP_NUM_THREADS=1 COLUMNS=160
export HYDRA_IFACE=lo # the name of this machine may not resolve
settings=(--set numerics.dx=0.1 --set time.end=4.0)
timeout 300 "$python" -m parsph run pool "${settings[@]}" --out "$work/whole" >"$work/log" 2>&1 || fail "the uninterrupted run"
report "uninterrupted run"

# --- a run in four goes --------------------------------------------------------------------------------------------------

submit() {
    sbatch --parsable --ntasks-per-node=1 --signal=USR1@15 --output="$work/job.log" "$@" \
        jobs/slurm.sh pool "$work/run" "${settings[@]}"
}
shows() { [[ $(scontrol --oneliner show job "$1") =~ $2 ]]; }
told() { [ "$(grep -c "$2" "$work/job.log")" = "$1" ]; }
rows() { if [ -e "$work/run/gauges/level-00.csv" ]; then wc -l <"$work/run/gauges/level-00.csv"; else echo 0; fi; }
has_more_rows_than() { [ "$(rows)" -gt $(($1 + 2)) ]; }
work_a_little() {
    local before
    before=$(rows)
    within 60 has_more_rows_than "$before"
}
# Puts the job to sleep: a run that takes long must not take long to compute. Slurm wakes what it warns or preempts.
sleep_well() { scancel --signal=STOP "$job"; }

job=$(submit --nodes=2 --time=1)
work_a_little
sleep_well
within 100 shows "$job" "Restarts=1"
told 1 "stopped at t = .* with a checkpoint" || fail "no checkpoint when the time was nearly over"
report "warned of its time limit: checkpoint, requeued"

work_a_little
sleep_well
urgent=$(sbatch --parsable --partition=high --nodes=2 --time=1 --output=/dev/null --wrap "sleep 3")
within 60 shows "$job" "Restarts=2"
within 20 shows "$urgent" "JobState=(RUNNING|COMPLETED)"
told 2 "stopped at t = .* with a checkpoint" || fail "no checkpoint when it was preempted"
report "preempted: checkpoint, requeued"

work_a_little
scancel "$job"
within 20 shows "$job" "JobState=CANCELLED"
within 20 told 3 "stopped at t = .* with a checkpoint"
sleep 7 # longer than a requeued job waits
shows "$job" "JobState=CANCELLED" || fail "a cancelled job was requeued"
report "cancelled: checkpoint, not requeued"

job=$(submit --nodes=1 --time=10) # and one rank
within 200 shows "$job" "JobState=(COMPLETED|FAILED|TIMEOUT|CANCELLED)"
shows "$job" "JobState=COMPLETED" || fail "the last go"
[ -e "$work/run/summary.json" ] || fail "no summary"
timeout 60 "$python" tests/compare_snapshots.py "$work/whole" "$work/run" || fail "the runs differ"

# --- a study as an array, with the other launcher ----------------------------------------------------------------------

cat >"$work/two.toml" <<'TOML'
title = "the pool at two viscosities"
base = "pool"
metrics = ["residual-energy"]

[settings]
"numerics.dx" = 0.1
"time.end" = 4.0

[[groups]]
name = "pool"
axes.alpha.low = { "numerics.alpha" = 0.01 }
axes.alpha.high = { "numerics.alpha" = 0.02 }
TOML
sed 's/^launch=.*/launch=(srun --mpi=pmi2)/' jobs/slurm-study.sh >"$work/slurm-study.sh"
array=$(sbatch --parsable --array=0-1 --time=5 --output="$work/task-%a.log" "$work/slurm-study.sh" \
    "$work/two.toml" --out "$work/study")
first=$work/study/rows/pool_low
within 60 test -s "$first/gauges/level-00.csv"
scancel --signal=USR1 "${array}_0"
within 20 shows "${array}_0" "Restarts=1"
for task in 0 1; do
    within 200 shows "${array}_$task" "JobState=(COMPLETED|FAILED|TIMEOUT|CANCELLED)"
    shows "${array}_$task" "JobState=COMPLETED" || fail "task $task of the array"
done
grep -q "goes on at" "$work/task-0.log" || fail "the first row began anew"
timeout 60 "$python" tests/compare_snapshots.py "$work/whole" "$first" || fail "the row and the run differ"
[ -e "$work/study/rows/pool_high/summary.json" ] || fail "the second row has no summary"

report "Slurm: runs that are warned, preempted or cancelled go on to the same bits; a study runs as an array"
