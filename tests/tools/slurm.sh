# A Slurm of two nodes on this machine, for tests: `. slurm.sh; start_slurm DIR` starts munged,
# slurmctld and two slurmd with their own configuration and ports, and stops them on exit. Prints
# "SKIPPED: why" and ends with 0 where that cannot be.
slurm_daemons=()
stop_slurm() {
  for ((i = ${#slurm_daemons[@]} - 1; i >= 0; --i)); do kill "${slurm_daemons[i]}" 2>/dev/null || true; done
  wait "${slurm_daemons[@]}" 2>/dev/null || true
}
skip() { echo "SKIPPED: $*"; exit 0; }

start_slurm() {
  local folder=$1 host port tool
  for tool in munged slurmctld slurmd sbatch; do
    command -v $tool >/dev/null || PATH=$PATH:/usr/sbin command -v $tool >/dev/null ||
      skip "no $tool; install slurm-wlm and munge (apt-get install slurm-wlm munge)"
  done
  [ "$(id -u)" -eq 0 ] || skip "Slurm's daemons start as root only"
  PATH=$PATH:/usr/sbin
  host=$(hostname -s)
  port=$((20000 + $$ % 20000))
  mkdir -p "$folder"/{munge,state,spool}
  head -c 1024 /dev/urandom > "$folder/munge/key"
  chmod 400 "$folder/munge/key"
  chmod 755 "$folder" "$folder/munge"
  cat > "$folder/slurm.conf" <<CONF
ClusterName=palpate
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
MaxArraySize=20001
MaxJobCount=40000
KillWait=2
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1 RealMemory=4000
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1 RealMemory=4000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$folder/slurm.conf
  trap stop_slurm EXIT
  munged --foreground --force --socket="$folder/munge/socket" --key-file="$folder/munge/key" \
    --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" \
    --seed-file="$folder/munge/seed" > "$folder/munge/out" 2>&1 &
  slurm_daemons+=($!)
  sleep 1
  slurmctld -D -f "$SLURM_CONF" > "$folder/slurmctld.out" 2>&1 &
  slurm_daemons+=($!)
  sleep 1
  for node in n1 n2; do
    slurmd -D -N $node -f "$SLURM_CONF" > "$folder/$node.out" 2>&1 &
    slurm_daemons+=($!)
  done
  for ((i = 0; i < 30; ++i)); do
    [ "$(sinfo --noheader --format=%D --states=idle 2>/dev/null)" = 2 ] && return
    sleep 1
  done
  tail -n 5 "$folder"/*.out "$folder"/*.log >&2
  skip "Slurm's daemons do not come up here"
}

# Waits until the queue is empty, SECONDS at most.
wait_for_slurm() {
  local until=$((SECONDS + $1))
  while [ -n "$(squeue --noheader)" ]; do
    [ $SECONDS -lt $until ] || { squeue; echo "FAILED: jobs do not end"; exit 1; }
    sleep 1
  done
}
