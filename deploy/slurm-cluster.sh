#!/bin/bash
# A cluster for the time of a Slurm job: a coordinator on the first host, a node on every host. --no-kill: the loss of a host
# ends neither the job nor the others. Each process begins again when it dies, but not when it is drained or told to end: a node
# then hands over its tiles, for at most 20 s (drain-timeout; of Slurm's KillWait it takes less).
#
#   sbatch --nodes 4 deploy/slurm-cluster.sh SHARED_FOLDER INPUTS CERTS       CERTS: a certificate for each host (tessera certs)
#SBATCH --ntasks-per-node=1 --exclusive --no-kill --job-name=tessera
set -euo pipefail
shared=$(realpath "$1") inputs=$(realpath "$2") certs=$(realpath "$3")
first=$(scontrol show hostnames "$SLURM_JOB_NODELIST" | head -n 1)
export TESSERAD_DATA=$shared TESSERAD_CERTS=$certs
coordinator=(tesserad --cluster "$first:7072" --roles coordinator --node-name "$first" --inputs "$inputs" --metrics none)
node=(tesserad --join "$first:7072")
# Until it ends by itself, or cannot begin (status 2).
again='until "$@" || [ $? = 2 ]; do sleep 2; done'
srun --no-kill --overlap --nodes 1 --ntasks 1 --nodelist "$first" bash -c "$again" coordinator "${coordinator[@]}" &
# shellcheck disable=SC2016  # the host's name is that of each task
srun --no-kill --overlap --kill-on-bad-exit=0 bash -c \
  'host=$(hostname -s); set -- "$@" --cluster "$host:7073" --node-name "$host" --scratch "${TMPDIR:-/tmp}/tesserad"; '"$again" \
  node "${node[@]}" &
wait
