#!/usr/bin/env bash
# A Slurm cluster of this machine alone, in a folder, on ports and sockets of its own:
#   slurm_cluster.sh up DIR     starts munged, slurmctld and slurmd, and waits until the node takes jobs; SLURM_CONF=DIR/slurm.conf is it
#   slurm_cluster.sh down DIR   ends them
# The node says that it has 4 cores, however many there are: what tests submit must not wait for more.
set -euo pipefail
verb=$1 dir=$2

end_daemons() {
  local name
  for name in slurmd slurmctld munged; do
    [ ! -f "$dir/$name.pid" ] || kill "$(cat "$dir/$name.pid")" 2>/dev/null || true
  done
}

if [ "$verb" = down ]; then
  end_daemons
  exit 0
fi
mkdir -p "$dir/spool" "$dir/state"
chmod 755 "$dir" # munged refuses a folder that others may write to
head -c 1024 /dev/urandom >"$dir/munge.key"
chmod 400 "$dir/munge.key"
read -r controller_port node_port < <(python3 -c '
import socket
sockets = [socket.socket() for _ in range(2)]
for s in sockets:
    s.bind(("127.0.0.1", 0))
print(*[s.getsockname()[1] for s in sockets])')
cat >"$dir/slurm.conf" <<EOC
ClusterName=test
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket=$dir/munge.socket
SlurmctldPort=$controller_port
SlurmdPort=$node_port
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmdParameters=config_overrides
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=test Nodes=ALL Default=YES MaxTime=INFINITE State=UP
EOC
export SLURM_CONF=$dir/slurm.conf
munged --force --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munged.pid" --log-file="$dir/munged.log" \
  --seed-file="$dir/munge.seed"
slurmctld -f "$SLURM_CONF"
slurmd -f "$SLURM_CONF"
for _ in $(seq 6000); do # ten minutes, on a busy machine
  if sinfo --noheader --format=%t 2>/dev/null | grep -qE '^(idle|mix|alloc)$'; then exit 0; fi
  sleep 0.1
done
echo "the node did not come up within ten minutes:" >&2
cat "$dir"/*.log >&2
end_daemons
exit 1
