#!/bin/bash
# A cluster for the time of a Slurm job: a coordinator on the first host, a node on every host. --no-kill: the loss of a host
# ends neither the job nor the others. Each process begins again when it dies, but not when it is drained or told to end: a node
# then hands over its tiles, for at most 20 s (drain-timeout; of Slurm's KillWait it takes less). --mem=0: all the memory of
# each host, which where memory is handed out would else be a share of it.
#
#   sbatch --nodes 4 deploy/slurm-cluster.sh SHARED_FOLDER INPUTS CERTS       CERTS: a certificate for each host (tessera certs)
#SBATCH --ntasks-per-node=1 --exclusive --mem=0 --no-kill --job-name=tessera
set -euo pipefail
[[ $# -eq 3 ]] || { echo "usage: sbatch --nodes N slurm-cluster.sh SHARED_FOLDER INPUTS CERTS" >&2; exit 2; }
shared=$(realpath "$1") inputs=$(realpath "$2") certs=$(realpath "$3")
hosts=$(scontrol show hostnames "$SLURM_JOB_NODELIST") first=${hosts%%$'\n'*}
export TESSERAD_DATA=$shared TESSERAD_CERTS=$certs
coordinator=(tesserad --cluster "$first:7072" --roles coordinator --node-name "$first" --inputs "$inputs" --metrics none)
node=(tesserad --join "$first:7072")
# shellcheck disable=SC2016  # for the shell of each task
# Until it ends by itself, or cannot begin (status 2: a wrong option or configuration).
again='until "$@"; do status=$?; [ $status != 2 ] || exit 2; sleep 2; done'
srun --mem=0 --no-kill --overlap --nodes 1 --ntasks 1 --nodelist "$first" bash -c "$again" coordinator "${coordinator[@]}" &
steps=($!)
# A new folder of its own on each host: in /tmp others could be there first.
# shellcheck disable=SC2016  # the host's name is that of each task
srun --mem=0 --no-kill --overlap --kill-on-bad-exit=0 bash -c \
  'scratch=$(mktemp -d "${TMPDIR:-/tmp}/tesserad-XXXXXX") || exit; trap '\''rm -rf "$scratch"'\'' EXIT
   host=$(hostname -s); set -- "$@" --cluster "$host:7073" --node-name "$host" --scratch "$scratch"; '"$again" \
  node "${node[@]}" &
steps+=($!)
# Without either there is no cluster: the first that cannot begin ends the job, and tells its status.
status=0
wait -n || status=$?
if [ $status = 0 ]; then wait -n || status=$?; fi
if [ $status != 0 ]; then kill "${steps[@]}" 2>/dev/null || true; fi
wait
exit $status
