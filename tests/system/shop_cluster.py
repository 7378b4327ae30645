"""A PostgreSQL cluster of a test's own: made, started, killed, copied and put back, with a standby; and a proxy that
partitions."""

import glob
import os
import pwd
import select
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

BINS = sorted(glob.glob("/usr/lib/postgresql/*/bin"))
SKIPPED = 77  # exit status: PostgreSQL is not here
HANG = 300.0  # s: only a hang reaches it


def is_here():
    """initdb refuses root, so that root needs another user for it."""
    return bool(BINS) and (os.geteuid() != 0 or shutil.which("runuser") is not None)


class Cluster:
    """Its socket is in a short folder of its own, it listens nowhere else."""

    def __init__(self, durable=True, primary=None, connections=200):
        self.folder = tempfile.mkdtemp(prefix="tfpg", dir="/tmp")
        self.data, self.log, self.starts = f"{self.folder}/data", f"{self.folder}/log", 0
        self.user, self.connections = None, connections
        if os.geteuid() == 0:
            self.user = next(name for name in ("postgres", "nobody") if any(name == one.pw_name for one in pwd.getpwall()))
            shutil.chown(self.folder, self.user)
        self.durable, self.postmaster = durable, None
        if primary:
            self.call("pg_basebackup", "-h", primary.folder, "-U", "shop", "-D", self.data, "-R", "-X", "stream", "-c", "fast")
            return
        self.call("initdb", "-D", self.data, "-U", "shop", "-A", "trust", "--no-locale", "-E", "UTF8",
                  *([] if durable else ["-N"]))

    def call(self, program, *words):
        done = subprocess.run([*self.as_user(), f"{BINS[-1]}/{program}", *words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, (program, words, done.stdout, done.stderr)
        return done.stdout

    def as_user(self):
        return ["runuser", "-u", self.user, "--"] if self.user else []

    def start(self):
        """Also over what a killed one left: it starts when the children of that are gone."""
        end = time.monotonic() + HANG
        while True:
            with open(self.log, "a", encoding="utf-8") as out:
                starting = subprocess.Popen(
                    [*self.as_user(), f"{BINS[-1]}/postgres", "-D", self.data, "-k", self.folder, "-c", "listen_addresses=",
                     "-c", f"fsync={'on' if self.durable else 'off'}", "-c", f"max_connections={self.connections}"],
                    stdout=out, stderr=out, start_new_session=True)
            while starting.poll() is None:
                if self.ready():
                    self.postmaster, self.starts = starting, self.starts + 1
                    return
                assert time.monotonic() < end, self.tail()
                time.sleep(0.05)
            assert time.monotonic() < end, self.tail()
            time.sleep(0.1)

    def ready(self):
        return subprocess.run([f"{BINS[-1]}/pg_isready", "-q", "-h", self.folder], check=False).returncode == 0

    def tail(self):
        with open(self.log, encoding="utf-8", errors="replace") as file:
            return file.read()[-3000:]

    def pid(self):
        with open(f"{self.data}/postmaster.pid", encoding="ascii") as file:
            return int(file.readline())

    def kill(self):
        """SIGKILL to the server's first process, as a crash: nothing is written any more."""
        os.kill(self.pid(), signal.SIGKILL)
        self.postmaster.wait()
        self.postmaster = None

    def stop(self):
        if self.postmaster:
            os.kill(self.pid(), signal.SIGINT)
            self.postmaster.wait()
            self.postmaster = None

    def end(self):
        if self.postmaster:
            os.kill(self.pid(), signal.SIGQUIT)
            self.postmaster.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def promote(self):
        self.call("pg_ctl", "promote", "-w", "-D", self.data)

    def save(self, name):
        """A copy of the whole cluster, which must be stopped."""
        subprocess.run(["cp", "-a", self.data, f"{self.folder}/{name}"], check=True)

    def put_back(self, name):
        shutil.rmtree(self.data)
        subprocess.run(["cp", "-a", f"{self.folder}/{name}", self.data], check=True)

    def sql(self, text):
        """Rows of columns."""
        out = subprocess.run([f"{BINS[-1]}/psql", "-h", self.folder, "-U", "shop", "-d", "postgres", "-XAtq", "-F", "\t",
                              "-v", "ON_ERROR_STOP=1", "-c", text], capture_output=True, text=True, check=False)
        assert out.returncode == 0, out.stderr
        return [line.split("\t") for line in out.stdout.splitlines()]

    def run_file(self, path):
        done = subprocess.run([f"{BINS[-1]}/psql", "-h", self.folder, "-U", "shop", "-d", "postgres", "-XAtq", "-v", "ON_ERROR_STOP=1",
                               "-f", path], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr

    def url(self, folder=None):
        return f"postgresql://shop@/postgres?host={folder or self.folder}"


class Proxy:
    """Between services and a cluster's socket. While `cut`, bytes are kept back and nobody is told; `drop` ends what is
    connected."""

    def __init__(self, cluster, name):
        self.folder = f"{cluster.folder}/{name}"
        os.makedirs(self.folder)
        self.target = f"{cluster.folder}/.s.PGSQL.5432"
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(f"{self.folder}/.s.PGSQL.5432")
        os.chmod(self.folder, 0o755)
        os.chmod(f"{self.folder}/.s.PGSQL.5432", 0o777)
        self.listener.listen(64)
        self.cut, self.pairs, self.over = False, {}, False
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def close(self, one):
        other = self.pairs.pop(one, None)
        self.pairs.pop(other, None)
        for end in (one, other):
            if end:
                end.close()

    def take(self):
        client, _ = self.listener.accept()
        server = socket.socket(socket.AF_UNIX)
        try:
            server.connect(self.target)
        except OSError:
            client.close()
            server.close()
            return
        self.pairs[client], self.pairs[server] = server, client

    def run(self):
        while not self.over:
            if self.cut:
                time.sleep(0.02)
                continue
            ready, _, _ = select.select([self.listener, *self.pairs], [], [], 0.02)
            for one in ready:
                if one is self.listener:
                    self.take()
                    continue
                if one not in self.pairs:
                    continue
                try:
                    data = one.recv(1 << 16)
                    if data:
                        self.pairs[one].sendall(data)
                    else:
                        self.close(one)
                except OSError:
                    self.close(one)

    def drop(self):
        """After this no byte of what was connected goes either way."""
        for one in list(self.pairs):
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
