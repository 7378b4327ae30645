#!/usr/bin/python3
"""The service where a computer is set up badly: files may not grow, whoever starts it lets everybody write, it hangs. And a job
that needs more files than go to it.

hard_places_test.py BIN_FOLDER WORK_FOLDER
"""

import errno
import json
import os
import resource
import shutil
import signal
import socket
import stat
import subprocess
import sys

from service_run import ROOT, Run


def serve(run, before):
    command = [f"{run.bin}/tiltfeed", "serve", "--config", f"{run.work}/service.yaml"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=before)
    run.processes.append(process)
    return process


def limit(size):
    """No file grows beyond so many bytes."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def files_that_may_not_grow(run):
    process = serve(run, limit(0))
    said = process.communicate()[1]
    run.want(process.returncode == 1 and said, f"ended with {process.returncode}: {said}")
    run.service = serve(run, limit(400 << 10))
    run.until("the service does not answer", lambda: run.tiltfeed("list")[0] == 0)
    large = f"{run.work}/large.nc"
    with open(large, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\n" + "G0 X0 Y0 Z50 A0 C0\n" * 50000)
    status, said = run.tiltfeed("submit", large)
    run.want(status == 1 and os.strerror(errno.EFBIG) in said, f"the file that is too large: {status} {said}")
    run.want(run.tiltfeed("list")[0] == 0, "the service has gone")
    run.kill(signal.SIGTERM)


def everybody_may_write(run):
    shutil.rmtree(f"{run.work}/spool")
    run.service = serve(run, lambda: os.umask(0))
    run.until("the service does not answer", lambda: run.tiltfeed("list")[0] == 0)
    for folder, _, files in os.walk(f"{run.work}/spool"):
        for name in [folder, *(f"{folder}/{one}" for one in files)]:
            mode = stat.S_IMODE(os.stat(name).st_mode)
            run.want(mode & (stat.S_IWGRP | stat.S_IRWXO) == 0, f"{name} is open to others: {mode:o}")


def a_fixture_that_stays_behind(run):
    with open(f"{ROOT}/config/jobs/sphere.yaml", encoding="utf-8") as file:
        text = file.read().replace("../machines/", f"{ROOT}/config/machines/")
    with open(f"{run.work}/job.yaml", "w", encoding="utf-8") as out:
        out.write(text + "fixtures:\n  - {name: vice, shape: stl, stl: job.yaml}\n")
    status, said = run.tiltfeed("submit", f"{run.work}/job.yaml")
    run.want(status == 1 and "fixture 'vice' does not go to the service" in said, f"its file: {status} {said}")
    run.want(run.tiltfeed("list")[1].count("\n") == 1, "it was taken all the same")
    # Another program than `submit` hands it over, and in the spool its file would be the part.
    with open(f"{run.work}/job.yaml", "w", encoding="utf-8") as out:
        out.write(text + "fixtures:\n  - {name: vice, shape: stl, stl: part.stl}\n")
    subprocess.run([f"{run.bin}/tiltfeed-sim", "part", "sphere", "--out", f"{run.work}/part.stl"], check=True)
    with socket.socket(socket.AF_UNIX) as service, open(f"{run.work}/job.yaml", "rb") as job, open(f"{run.work}/part.stl", "rb") as part:
        service.connect(f"{run.work}/api.sock")
        socket.send_fds(service, [b'{"v":1,"op":"submit","name":"vice"}\n'], [job.fileno(), part.fileno()])
        number = json.loads(service.recv(65536))["job"]
    run.until("it is planned for ever", lambda: run.show(number, "state") not in ("received", "planning", "arriving"))
    run.want(run.show(number, "state") == "failed" and "fixtures[1].stl: the file 'part.stl' did not come" in run.show(number, "note"),
             f"planned without its file: {run.show(number, 'note')}")


def it_hangs(run):
    run.service.send_signal(signal.SIGSTOP)
    status, said = run.tiltfeed("metrics", "--config", f"{run.work}/service.yaml")
    run.want(status == 0 and "\ntiltfeed_up 0.0\n" in said, f"a service that hangs is up: {status} {said}")
    said = run.tiltfeed("doctor", "--config", f"{run.work}/service.yaml")[1]
    run.want("though it is there: restart it" in said, f"not said: {said}")
    run.service.send_signal(signal.SIGCONT)
    run.until("it does not go on", lambda: run.tiltfeed("list")[0] == 0)
    run.kill(signal.SIGTERM)


def main():
    run = Run(sys.argv[1], sys.argv[2])
    try:
        run.configure("grbl-tcp:" + run.simulate("--grbl-tcp", "127.0.0.1:0"))
        files_that_may_not_grow(run)
        everybody_may_write(run)
        a_fixture_that_stays_behind(run)
        it_hangs(run)
    finally:
        run.end()
    print("hard places: all as expected")


if __name__ == "__main__":
    main()
