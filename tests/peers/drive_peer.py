#!/usr/bin/python3
"""A plain drive behind pymodbus, written from the section wire.drive of config/machines/generic-ac.yaml; nothing of Tiltfeed
is in it. Each write that ends with the trigger is a move, whatever came before.

drive_peer.py --tcp PORT --trace FILE [--mute-write N] [--move-ms MS]

Prints "ready" and serves until it is ended. FILE gets one line a move, when it is set off: position and speed, whole
numbers, or "stop". --mute-write N: the Nth move is made, and its write is not answered.
"""

import argparse
import sys
import time

from pymodbus.datastore import ModbusServerContext, ModbusSlaveContext
from pymodbus.datastore.store import BaseModbusDataBlock
from pymodbus.server import StartTcpServer

BLOCK, WORDS, STATUS, STOP = 25088, 8, 4099, 24578
TRIGGER, STOP_VALUE, MOVING = 16, 64, 4


class Drive(BaseModbusDataBlock):
    def __init__(self, options):
        self.move_s, self.until, self.moves = options.move_ms / 1000, 0.0, 0
        self.trace = open(options.trace, "w", encoding="ascii", buffering=1)
        self.address, self.values, self.default_value = 0, [0], 0

    def validate(self, address, count=1):
        return (address, count) in ((BLOCK, WORDS), (STATUS, 1), (STOP, 1))

    def getValues(self, address, count=1):
        return [MOVING if address == STATUS and time.monotonic() < self.until else 0] * count

    def setValues(self, address, values):
        if address == STOP and list(values) == [STOP_VALUE]:
            self.until = 0.0
            self.trace.write("stop\n")
        elif address == BLOCK and values[-1] == TRIGGER:
            self.moves += 1
            if time.monotonic() < self.until:
                self.trace.write("cut short\n")
            place = values[1] << 16 | values[2]
            self.trace.write(f"{place - (place >> 31 << 32)} {values[3]}\n")
            self.until = time.monotonic() + self.move_s


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tcp", type=int, required=True)
    parser.add_argument("--trace", required=True)
    parser.add_argument("--mute-write", type=int, default=0)
    parser.add_argument("--move-ms", type=float, default=30.0)
    options = parser.parse_args()
    drive = Drive(options)
    context = ModbusServerContext(slaves=ModbusSlaveContext(hr=drive, zero_mode=True), single=True)

    def answer(response):
        if response.function_code == 16 and options.mute_write and drive.moves == options.mute_write:
            response.should_respond = False
        return response, False

    print("ready", flush=True)
    StartTcpServer(context=context, address=("127.0.0.1", options.tcp), response_manipulator=answer)


if __name__ == "__main__":
    sys.exit(main())
