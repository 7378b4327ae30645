#!/usr/bin/python3
"""A serial controller with pyserial, written from what Grbl 1.1 and Marlin document; nothing of Tiltfeed is in it.

line_peer.py grbl|marlin PATH --trace FILE [--restart-after N] [--spoil N]

FILE gets each line as it is executed. Grbl: a receive buffer of 128 bytes, whose overrun is an error, a planner of 15.
Marlin: numbers and checksums; each Nth line is taken for damaged (--spoil). --restart-after N: the controller starts
anew after N lines and says so. Ends when the port is quiet for two seconds after work was done. Exit status 1: the host
broke a rule.
"""

import argparse
import collections
import re
import sys
import time

import serial

RX, PLANNER, LINE_S = 128, 15, 0.001


class Peer:
    def __init__(self, options):
        self.port = serial.Serial(options.path, 115200, timeout=0.001)
        self.trace = open(options.trace, "w", encoding="ascii")
        self.options, self.done, self.heard_at, self.wrong = options, 0, time.monotonic(), None

    def say(self, text):
        self.port.write(text.encode())

    def execute(self, line):
        self.trace.write(line + "\n")
        self.trace.flush()
        self.done += 1

    def run(self):
        while self.wrong is None and (self.done == 0 or time.monotonic() - self.heard_at < 2.0):
            if time.monotonic() - self.heard_at > 30.0:
                self.wrong = "nothing was heard for 30 s"
            data = self.port.read(256)
            if data:
                self.heard_at = time.monotonic()
            self.take(data)
            self.work()
        print(f"{self.done} lines executed" + (f"; {self.wrong}" if self.wrong else ""), flush=True)
        return 1 if self.wrong else 0


class Grbl(Peer):
    def __init__(self, options):
        super().__init__(options)
        self.rx, self.planner, self.state, self.next_at, self.most = bytearray(), collections.deque(), "Idle", 0.0, 0

    def take(self, data):
        for byte in data:
            if byte == ord("?"):
                free = f"{PLANNER - len(self.planner)},{RX - len(self.rx)}"
                self.say(f"<{self.state}|MPos:0.000,0.000,{self.done}.000|Bf:{free}|FS:0,0>\r\n")
            elif byte == ord("!"):
                self.state = "Hold:0"
            elif byte == ord("~"):
                self.state = "Idle"
            elif byte == 0x18:
                self.restart()
            elif byte >= 0x80:
                continue
            else:
                self.rx.append(byte)
                self.most = max(self.most, len(self.rx))
                if len(self.rx) > RX - 1:
                    self.wrong = f"receive buffer overrun: {len(self.rx)} bytes"

    def restart(self):
        self.rx.clear()
        self.planner.clear()
        self.state = "Idle"
        self.say("\r\nGrbl 1.1h ['$' for help]\r\n")

    def work(self):
        now = time.monotonic()
        if self.state != "Hold:0" and self.planner and now >= self.next_at:
            self.execute(self.planner.popleft())
            self.next_at = now + LINE_S
            if self.options.restart_after and self.done == self.options.restart_after:
                self.restart()
                self.trace.write("RESTART\n")
        self.state = "Hold:0" if self.state == "Hold:0" else "Run" if self.planner else "Idle"
        while b"\n" in self.rx and len(self.planner) < PLANNER:
            end = self.rx.index(b"\n")
            line = self.rx[:end].decode("ascii")
            if len(line) > 79:
                self.wrong = f"line of {len(line)} bytes"
            if line == "G4P0" and self.planner:  # waits until everything before has run
                return
            del self.rx[: end + 1]
            if line == "$I":
                self.say(f"[VER:1.1h.20190825:]\r\n[OPT:V,{PLANNER},{RX}]\r\nok\r\n")
            elif line == "G4P0":
                self.say("ok\r\n")
            else:
                self.planner.append(line)
                self.say("ok\r\n")


class Marlin(Peer):
    def __init__(self, options):
        super().__init__(options)
        self.rx, self.number, self.seen = bytearray(), 0, 0
        self.place = dict.fromkeys("XYZAC", 0.0)

    def resend(self, why):
        self.say(f"Error:{why}, Last Line: {self.number}\nResend: {self.number + 1}\nok\n")

    def take(self, data):
        self.rx += data

    def work(self):
        while b"\n" in self.rx:
            end = self.rx.index(b"\n")
            line = self.rx[:end].decode("ascii", "replace").strip()
            del self.rx[: end + 1]
            if line:
                self.obey(line)

    def obey(self, line):
        self.seen += 1
        body, star, check = line.rpartition("*")
        sum_ = 0
        for char in body:
            sum_ ^= ord(char)
        if self.options.spoil and self.seen % self.options.spoil == 0:
            return self.resend("checksum mismatch")
        if not star or not body.startswith("N"):
            self.wrong = f"unnumbered line '{line}'"
            return None
        if int(check) != sum_:
            return self.resend("checksum mismatch")
        digits = len(body[1:]) - len(body[1:].lstrip("0123456789"))
        number, command = int(body[1 : 1 + digits]), body[1 + digits :]
        if command.startswith("M110"):
            self.number = int(command[5:])
            return self.say("ok\n")
        if number != self.number + 1:
            return self.resend("Line Number is not Last Line Number+1")
        self.number = number
        if command == "M115":
            return self.say("FIRMWARE_NAME:Marlin 2.1.2 SOURCE_CODE_URL:none\nCap:EMERGENCY_PARSER:0\nok\n")
        if command == "M114":
            place = " ".join(f"{axis}:{value:.2f}" for axis, value in self.place.items())
            return self.say(f"{place} E:0.00 Count X:0 Y:0 Z:0\nok\n")
        if command != "M400":
            self.execute(command)
            for axis, value in re.findall(r"([XYZAC])(-?[0-9.]+)", command if command[0] == "G" else ""):
                self.place[axis] = float(value)
        if self.options.restart_after and self.done == self.options.restart_after:
            self.trace.write("RESTART\n")
            self.number = 0
            return self.say("start\n")
        return self.say(f"ok N{number} P15 B3\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kind", choices=["grbl", "marlin"])
    parser.add_argument("path")
    parser.add_argument("--trace", required=True)
    parser.add_argument("--restart-after", type=int, default=0)
    parser.add_argument("--spoil", type=int, default=0)
    options = parser.parse_args()
    return (Grbl if options.kind == "grbl" else Marlin)(options).run()


if __name__ == "__main__":
    sys.exit(main())
