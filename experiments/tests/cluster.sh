#!/bin/sh
# Starts a cluster of two nodes on this machine in the folder $1, without systemd, cgroups or accounting, and prints the
# place of its configuration. Ends it again with `stop` as second argument. Needs root, slurmctld, slurmd and munged.
set -eu
folder=$1
if [ "${2:-start}" = stop ]; then
    for file in "$folder"/*.pid; do
        [ -f "$file" ] && kill -9 "$(cat "$file")" 2>/dev/null || true
    done
    exit 0
fi

host=$(hostname -s)
mkdir -p "$folder/munge" "$folder/state"
chmod 755 "$folder"
head -c 1024 /dev/urandom > "$folder/munge/munge.key"
chown -R munge "$folder/munge"
chmod 755 "$folder/munge"
chmod 400 "$folder/munge/munge.key"
runuser -u munge -- munged --force --key-file="$folder/munge/munge.key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/munged.pid" --log-file="$folder/munge/munged.log" --seed-file="$folder/munge/munged.seed"
cp "$folder/munge/munged.pid" "$folder/munged.pid"

# Short times everywhere: a dead node must be found, and its worker queued again, within seconds.
cat > "$folder/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket,cred_expire=2
SlurmUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool-%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd-%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdTimeout=4
KillWait=2
CompleteWait=0
ReturnToService=2
SchedulerParameters=sched_interval=2,batch_sched_delay=0
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=26821 CPUs=1
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=26822 CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF="$folder/slurm.conf"
slurmctld
for node in n1 n2; do
    slurmd -N "$node"
done
for _ in $(seq 100); do
    if sinfo --noheader --format=%T 2>/dev/null | grep -q idle; then
        echo "$SLURM_CONF"
        exit 0
    fi
    sleep 0.1
done
echo "the nodes do not come up: see $folder" >&2
exit 1
