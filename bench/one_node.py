"""Slurm of one node in a folder of its own: munged, slurmctld and slurmd of the packages slurm-wlm and munge, as root."""
import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

CONFIGURATION = """
ClusterName=one
SlurmctldHost={host}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=1
JobAcctGatherParams=OverMemoryKill
MpiDefault=none
ReturnToService=2
MinJobAge=300
SchedulerParameters=batch_sched_delay=0,sched_interval=1
NodeName={host} CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def available():
    programs = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol")
    return os.geteuid() == 0 and all(shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin") for name in programs)


class OneNode:
    """Runs while the `with` block does. `environment` is that of its clients."""

    def __init__(self, folder, cpus=4, memory=8000):
        self.folder = Path(folder).resolve()
        self.cpus, self.memory = cpus, memory
        self.environment = {"SLURM_CONF": str(self.folder / "slurm.conf")}
        self.daemons = []

    def start(self, *command):
        log = open(self.folder / f"{command[0]}.out", "w")
        path = os.environ["PATH"] + ":/usr/sbin"
        program = shutil.which(command[0], path=path)
        self.daemons.append(subprocess.Popen([program, *command[1:]], stdout=log, stderr=log,
                                             env=dict(os.environ, PATH=path, **self.environment)))

    def __enter__(self):
        for name in ("state", "spool", "munge"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        munge = self.folder / "munge"
        munge.chmod(0o700)
        (munge / "key").write_bytes(os.urandom(1024))
        (munge / "key").chmod(0o400)
        host = socket.gethostname().split(".")[0]
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(host=host, folder=self.folder, cpus=self.cpus, memory=self.memory))
        self.start("munged", "--foreground", "--force", f"--key-file={munge}/key", f"--socket={munge}/socket", f"--pid-file={munge}/pid",
                   f"--log-file={munge}/log", f"--seed-file={munge}/seed")
        time.sleep(1)
        self.start("slurmctld", "-D", "-c", "-f", self.environment["SLURM_CONF"])
        self.start("slurmd", "-D", "-f", self.environment["SLURM_CONF"])
        for _ in range(60):
            if "idle" in self.client("sinfo", "--noheader", "--format=%t"):
                return self
            time.sleep(0.5)
        self.__exit__()
        raise RuntimeError(f"Slurm does not start: see {self.folder}/slurmctld.log and slurmd.log")

    def client(self, *command):
        return subprocess.run(command, env=dict(os.environ, **self.environment), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True).stdout

    def __exit__(self, *_):
        self.client("scancel", "--user=root")
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
