#!/usr/bin/python3
"""Interrupts a program (SIGINT) once it has used so much processor time, and says when it uses more than LIMIT from there to
its end. Its exit status is passed on. Seconds of the processor are the same on a busy machine.

interrupt.py AFTER_S LIMIT_S LOG COMMAND...
"""

import os
import resource
import signal
import subprocess
import sys
import time


def used(pid):
    """Processor time of a process that runs, s."""
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    after, limit = float(sys.argv[1]), float(sys.argv[2])
    with open(sys.argv[3], "w", encoding="utf-8") as log:
        process = subprocess.Popen(sys.argv[4:], stdout=log, stderr=log)
    while used(process.pid) < after:
        if process.poll() is not None:
            print(f"FAILED: it ended by itself before it had used {after} s")
            return 99
        time.sleep(0.005)
    before = used(process.pid)
    process.send_signal(signal.SIGINT)
    status = process.wait()
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    rest = usage.ru_utime + usage.ru_stime - before
    if rest > limit:
        print(f"FAILED: interrupted after {after} s: used {rest:.2f} s more before it ended")
        return 98
    return status


if __name__ == "__main__":
    sys.exit(main())
