#!/usr/bin/python3
"""A ring controller behind pymodbus, written from the register map in daemon/wire/MODBUS.md; nothing of Tiltfeed is in it.

ring_peer.py --tcp PORT | --rtu PATH [--baud N] --trace FILE [--mute N] [--no-fc23] [--slots N] [--block-ms MS]

Prints "ready" and serves until SIGTERM; exit status 0 where a session was closed with everything executed. FILE gets one line a block, as the machine
executes it: seq op flags line X Y Z tilt rotary F, whole numbers. --mute N: each Nth request is done but not answered.
"""

import argparse
import os
import signal
import sys
import time
import zlib

from pymodbus.datastore import ModbusServerContext, ModbusSlaveContext
from pymodbus.datastore.store import BaseModbusDataBlock
from pymodbus.framer.rtu_framer import ModbusRtuFramer
from pymodbus.pdu import ExceptionResponse
from pymodbus.server import StartSerialServer, StartTcpServer

IDENTITY, WINDOW, MAILBOX, STATUS, POSITIONS, HEARTBEAT = 0x0000, 0x0100, 0x0180, 0x0200, 0x0220, 0x0240
OPEN, HOLD, RESUME, STOP, RESET, OVERRIDE, CLEAR, CLOSE = range(1, 9)
IDLE, RUNNING, HELD, DONE, ALARM, NO_SESSION = range(6)
BOOT, WATCHDOG_S = 4711, 1.0


def crc_of(words, hole):
    kept = words[:hole] + words[hole + 2 :]
    return zlib.crc32(b"".join(word.to_bytes(2, "big") for word in kept))


def long(words, at):
    return words[at] << 16 | words[at + 1]


def signed(value, bits):
    return value - (1 << bits) if value >> (bits - 1) else value


class Ring:
    def __init__(self, options, trace):
        self.slots, self.block_s, self.fc23 = options.slots, options.block_ms / 1000, not options.no_fc23
        self.trace = trace
        self.session = self.accepted = self.started = self.completed = 0
        self.nack = self.nack_seq = self.ack = self.result = self.heartbeat = self.status_seq = 0
        self.state, self.queue, self.free_at, self.beat_at = NO_SESSION, [], 0.0, 0.0
        self.override, self.ended, self.closed, self.holds, self.refused = 100, False, False, 0, 0

    def advance(self):
        """What the machine has done since the last request."""
        now = time.monotonic()
        if self.state == RUNNING and self.queue and now - self.beat_at > WATCHDOG_S:
            self.state, self.holds = HELD, self.holds + 1
        while self.state == RUNNING and self.queue and self.free_at <= now:
            block = self.queue.pop(0)
            self.started = self.completed = block[0]
            self.trace.write(" ".join(str(figure) for figure in block) + "\n")
            self.free_at = max(self.free_at, now - 0.05) + self.block_s
        if self.state == RUNNING and not self.queue:
            self.state = DONE if self.ended else IDLE

    def write_window(self, words):
        session, first, count, flags = words[0], words[1], words[2], words[3]
        if crc_of(words, 4) != long(words, 4) or not 1 <= count <= 7:
            self.nack, self.nack_seq, self.refused = 2, first, self.refused + 1
            return
        if session != self.session or self.state == NO_SESSION:
            self.nack, self.nack_seq = 3, first
            return
        for index in range(count):
            block = words[6 + 16 * index : 22 + 16 * index]
            step = signed((block[0] - self.accepted) & 0xFFFF, 16)
            if step <= 0:
                continue  # it is here already
            if step > 1:
                self.nack, self.nack_seq = 1, block[0]
                return
            if len(self.queue) >= self.slots:
                return
            if not 1 <= block[1] & 0xFF <= 4:
                self.nack, self.nack_seq = 4, block[0]
                return
            places = [signed(long(block, 4 + 2 * axis), 32) for axis in range(5)]
            self.queue.append([block[0], block[1] & 0xFF, block[1] >> 8, long(block, 2), *places, long(block, 14)])
            self.accepted, self.nack = block[0], 0
            if self.state in (IDLE, DONE):
                self.state, self.free_at = RUNNING, time.monotonic()
        self.ended = bool(flags & 1)

    def write_mailbox(self, words):
        session, seq, code = words[0], words[1], words[2]
        if crc_of(words, 5) != long(words, 5) or seq == self.ack:
            return
        self.ack, self.result = seq, 0
        if code == OPEN and self.state in (IDLE, DONE, NO_SESSION):
            self.session, self.state = session, IDLE
            self.accepted = self.started = self.completed = 0
            self.queue, self.ended, self.closed = [], False, False
        elif session != self.session:
            self.result = 1
        elif code == HOLD:
            self.state, self.holds = HELD, self.holds + 1
        elif code == RESUME and self.state == HELD:
            self.state = RUNNING
        elif code == OVERRIDE:
            self.override = words[4]
        elif code == STOP:
            self.queue, self.state = [], IDLE
        elif code == CLOSE:
            self.closed, self.state = True, NO_SESSION
        else:
            self.result = 1

    def write(self, address, words):
        self.advance()
        if address == WINDOW and len(words) == 118:
            self.write_window(words)
        elif address == MAILBOX and len(words) == 7:
            self.write_mailbox(words)
        elif address == HEARTBEAT and len(words) == 1:
            if words[0] != self.heartbeat:
                self.beat_at = time.monotonic()
            self.heartbeat = words[0]

    def read(self, address, count):
        self.advance()
        if address == IDENTITY:
            words = [0x5446, 1, 2 + self.fc23, self.slots, 16, 7, 0x1F, 4, 4, BOOT] + [0] * 6
        elif address == STATUS:
            self.status_seq = (self.status_seq + 1) & 0xFFFF
            line = self.queue[0][3] if self.queue else 0
            words = [self.status_seq, BOOT, self.session, self.accepted, self.started, self.completed]
            words += [self.slots - len(self.queue), self.state, 0, self.nack, self.nack_seq, self.ack, self.result]
            words += [self.override, self.heartbeat, line >> 16, line & 0xFFFF] + [0] * 6 + [self.status_seq]
        else:
            words = [0] * 125
        return words[:count]


class Registers(BaseModbusDataBlock):
    AREAS = {IDENTITY: 16, WINDOW: 118, MAILBOX: 7, STATUS: 24, POSITIONS: 10, HEARTBEAT: 1}

    def __init__(self, ring):
        self.ring, self.address, self.values, self.default_value = ring, 0, [0], 0

    def validate(self, address, count=1):
        return any(start <= address and address + count <= start + size for start, size in self.AREAS.items())

    def getValues(self, address, count=1):
        return self.ring.read(address, count)

    def setValues(self, address, values):
        self.ring.write(address, list(values))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tcp", type=int)
    parser.add_argument("--rtu")
    parser.add_argument("--baud", type=int, default=115200)
    parser.add_argument("--trace", required=True)
    parser.add_argument("--mute", type=int, default=0)
    parser.add_argument("--no-fc23", action="store_true")
    parser.add_argument("--slots", type=int, default=32)
    parser.add_argument("--block-ms", type=float, default=1.0)
    options = parser.parse_args()
    trace = open(options.trace, "w", encoding="ascii")
    ring = Ring(options, trace)
    context = ModbusServerContext(slaves=ModbusSlaveContext(hr=Registers(ring), zero_mode=True), single=True)
    requests = [0]

    def answer(response):
        requests[0] += 1
        if options.no_fc23 and response.function_code == 23:
            response = ExceptionResponse(23, 1)
        if options.mute and requests[0] % options.mute == 0:
            response.should_respond = False
        return response, False

    def leave(*_):
        """Whoever watched the host end says so: then the last reply is out, too."""
        trace.close()
        print(f"closed after {requests[0]} requests, {ring.holds} holds, {ring.refused} damaged windows", flush=True)
        os._exit(0 if ring.closed else 1)

    signal.signal(signal.SIGTERM, leave)
    print("ready", flush=True)
    if options.tcp:
        StartTcpServer(context=context, address=("127.0.0.1", options.tcp), response_manipulator=answer)
    else:
        StartSerialServer(
            context=context, framer=ModbusRtuFramer, port=options.rtu, baudrate=options.baud, parity="N",  # a pseudo-terminal has none
            response_manipulator=answer,
        )


if __name__ == "__main__":
    sys.exit(main())
