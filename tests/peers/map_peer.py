#!/usr/bin/python3
"""A ring controller and a plain drive over Modbus TCP, written from daemon/wire/MODBUS.md alone: sockets, registers, and axes that
move in real time (or `speed` times as fast). map_peer_test.py runs `tiltfeed` against both."""

import math
import select
import socket
import struct
import threading
import time
import zlib

IDENTITY, WINDOW, MAILBOX, STATUS, POSITIONS, HEARTBEAT = 0x0000, 0x0100, 0x0180, 0x0200, 0x0220, 0x0240
OPEN, HOLD, RESUME, STOP, RESET, OVERRIDE, CLEAR_ALARM, CLOSE = range(1, 9)
IDLE, RUNNING, HELD, DONE, ALARM, NO_SESSION = range(6)
RAPID, FEED, DWELL, M_CODE = range(1, 5)
INVERSE_TIME, KEPT_X, MACHINE = 0x01, 0x02, 0x40
SCALE, RAPID_SPEED, Z_END = 10**4, 100.0, 1000000  # counts; mm/s and degrees/s; counts


class Exception_(Exception):
    """A Modbus exception with its code."""

    def __init__(self, code):
        super().__init__(code)
        self.code = code


def uint32(words, at):
    return words[at] << 16 | words[at + 1]


def int32(words, at):
    return (uint32(words, at) ^ 0x80000000) - 0x80000000


def pair(value):
    return [value >> 16 & 0xFFFF, value & 0xFFFF]


def ahead(seq, of):
    return ((seq - of & 0xFFFF) ^ 0x8000) - 0x8000


def crc(words, at):
    return zlib.crc32(b"".join(word.to_bytes(2, "big") for word in words[:at] + words[at + 2 :]))


class Block:
    def __init__(self, words):
        self.seq, self.op, self.flags, self.line = words[0], words[1] & 0xFF, words[1] >> 8, uint32(words, 2)
        self.axes, self.f = [int32(words, at) for at in range(4, 14, 2)], uint32(words, 14)

    def good(self):
        if self.op == RAPID:
            return self.flags & 0x81 == 0 and self.f == 0
        if self.op == FEED:
            return self.flags & ~INVERSE_TIME == 0 and self.f > 0
        if self.op == DWELL:
            return self.flags == 0
        return self.op == M_CODE and self.flags == 0 and (0 <= self.axes[0] <= 9 or self.axes[0] == 30)

    def row(self):
        return (self.seq, self.op, self.flags, self.line, *self.axes, self.f)

    def target(self, at):
        if self.op in (DWELL, M_CODE):
            return list(at)
        to = [at[i] if self.flags >> i & KEPT_X else self.axes[i] for i in range(5)]
        if self.flags & MACHINE and not self.flags & KEPT_X << 2:
            to[2] += Z_END
        return to

    def seconds(self, at, override):
        ways = [(b - a) / SCALE for a, b in zip(at, self.target(at))]
        if self.op == RAPID:
            return max(map(abs, ways)) / RAPID_SPEED
        if self.op == DWELL:
            return self.f / 1000
        if self.op == M_CODE:
            return 0.0
        per_minute = self.f / 1000 * override / 100
        if self.flags & INVERSE_TIME:
            return 60 / per_minute
        return 60 * (math.hypot(*ways[:3]) or math.hypot(*ways[3:])) / per_minute


class Ring:
    def __init__(self, slots=64, speed=1.0, fc23=True, watchdog_s=1.0):
        self.slots, self.speed, self.fc23, self.watchdog_s, self.boot = slots, speed, fc23, watchdog_s, 4711
        self.executed, self.commands, self.watchdog_holds = [], [], 0
        self.at, self.status_seq, self.ack, self.result = [0] * 5, 0, 0, 0
        self.now, self.beat_at = time.monotonic(), None
        self.most = math.inf  # so many blocks are executed, then it stays in the next one
        self.clear()

    def clear(self):
        self.session = self.accepted = self.started = self.completed = 0
        self.nack = self.nack_seq = self.heartbeat = self.alarm = 0
        self.override, self.queue, self.spent, self.held, self.end_seq, self.done = 100, [], False, False, None, False
        self.beat_at, self.from_, self.share = None, list(self.at), 0.0

    # ---- the machine ------------------------------------------------------------------------------------
    def advance(self):
        """To now: the watchdog, then the blocks whose time has passed."""
        now = time.monotonic()
        left, self.now = (now - self.now) * self.speed, now
        if self.late() and self.queue and not self.held:
            self.held, self.watchdog_holds = True, self.watchdog_holds + 1
        while self.queue and not self.held and not self.alarm:
            block = self.queue[0]
            self.started = block.seq
            if len(self.executed) >= self.most:
                return
            span = block.seconds(self.from_, self.override)
            rest = span * (1 - self.share)
            if rest > left:
                self.share += left / span
                self.at = [a + (b - a) * self.share for a, b in zip(self.from_, block.target(self.from_))]
                return
            left -= rest
            self.finish(self.queue.pop(0))

    def finish(self, block):
        self.at = self.from_ = block.target(self.from_)
        self.share, self.completed = 0.0, block.seq
        self.executed.append(block.row())
        self.held = block.op == M_CODE and block.axes[0] in (0, 1, 6)
        self.done = self.done or block.seq == self.end_seq

    def late(self):
        return self.beat_at is not None and self.now - self.beat_at >= self.watchdog_s

    def drop(self):
        """Stands, its ring empty; nothing follows what was dropped."""
        self.queue, self.held, self.spent = [], False, True
        self.from_, self.share = list(self.at), 0.0

    def raise_alarm(self, number):
        self.drop()
        self.alarm = number

    def restart(self):
        self.clear()
        self.boot, self.ack, self.result = self.boot + 1 & 0xFFFF or 1, 0, 0

    def state(self):
        if self.alarm:
            return ALARM
        if self.session == 0:
            return NO_SESSION
        if self.held:
            return HELD
        return RUNNING if self.queue else DONE if self.done else IDLE

    # ---- the registers ----------------------------------------------------------------------------------
    def read(self, address, count):
        if (address, count) == (IDENTITY, 16):
            return [0x5446, 1, 0b1110 | self.fc23, self.slots, 16, 7, 0b11111, 4, 4, self.boot, 0, 0, 0, 0, 0, 0]
        if (address, count) == (POSITIONS, 10):
            return [word for value in self.at for word in pair(round(value))]
        if (address, count) != (STATUS, 24):
            raise Exception_(2)
        self.status_seq = self.status_seq + 1 & 0xFFFF
        running = self.queue[0] if self.queue else None
        words = [self.status_seq, self.boot, self.session, self.accepted]
        words += [self.started if running or self.alarm else self.completed, self.completed]
        words += [self.slots - len(self.queue), self.state(), self.alarm, self.nack, self.nack_seq, self.ack, self.result]
        words += [self.override, self.heartbeat, *pair(running.line if running else 0)]
        return words + [0] * 6 + [self.status_seq]

    def write(self, address, words):
        if (address, len(words)) == (WINDOW, 118):
            self.nack, self.nack_seq = self.take_window(words)
        elif (address, len(words)) == (MAILBOX, 7):
            self.take_mailbox(words)
        elif (address, len(words)) == (HEARTBEAT, 1):
            if self.beat_at is None or words[0] != self.heartbeat:
                self.beat_at = self.now
            self.heartbeat = words[0]
        else:
            raise Exception_(2)

    def take_window(self, words):
        first, count = words[1], words[2]
        if crc(words, 4) != uint32(words, 4):
            return 2, first
        if self.session == 0 or words[0] != self.session or self.spent:
            return 3, first
        if not 1 <= count <= 7 or words[3] & ~1:
            return 4, first
        if self.alarm:
            return self.nack, self.nack_seq
        if ahead(first, self.accepted) > 1:
            return 1, first
        blocks = [Block(words[at : at + 16]) for at in range(6, 6 + 16 * count, 16)]
        for place, block in enumerate(blocks):
            if block.seq != first + place & 0xFFFF or ahead(block.seq, self.accepted) > 0 and not block.good():
                return 4, first + place & 0xFFFF
        for block in blocks:
            if ahead(block.seq, self.accepted) > 0 and len(self.queue) < self.slots:
                self.queue.append(block)
                self.accepted, self.done = block.seq, False
        if words[3] & 1 and self.accepted == blocks[-1].seq:
            self.end_seq = self.accepted
            self.done = self.completed == self.accepted
        return 0, 0

    def take_mailbox(self, words):
        if crc(words, 5) != uint32(words, 5) or words[1] == self.ack:
            return
        done = self.execute(words[2], words[0], uint32(words, 3))
        self.commands.append((words[2], done))
        self.result, self.ack = 0 if done else 1, words[1]

    def execute(self, code, session, argument):
        """False: refused."""
        if code == OPEN:
            if session == self.session != 0:
                return True
            if session == 0 or self.queue or self.alarm:
                return False
            override = self.override
            self.clear()
            self.session, self.override = session, override
            return True
        if session != self.session:
            return False
        if code in (HOLD, RESUME) and (self.session == 0 or self.alarm) or code == RESUME and self.late():
            return False
        if code in (HOLD, RESUME):
            self.held = code == HOLD
        elif code == STOP:
            self.drop()
        elif code == RESET:
            moved = bool(self.queue) and not self.held
            self.clear()
            self.boot, self.alarm = self.boot + 1 & 0xFFFF or 1, 99 if moved else 0
        elif code == OVERRIDE and 10 <= argument <= 200:
            self.override = argument
        elif code == CLEAR_ALARM:
            self.alarm = 0
        elif code == CLOSE and self.session != 0 and not self.queue:
            self.session, self.held, self.beat_at = 0, False, None
        else:
            return False
        return True


class Drive:
    """One axis with the registers that a profile has when it says nothing; the alarm bit is set from outside."""

    fc23 = False

    def __init__(self, speed=1.0):
        self.speed, self.moves, self.stops, self.at, self.alarm = speed, [], 0, 0.0, False
        self.target, self.rate, self.now = 0, 0.0, time.monotonic()

    def advance(self):
        now = time.monotonic()
        way, self.now = self.rate * (now - self.now) * self.speed, now
        self.at += max(-way, min(way, self.target - self.at))

    def read(self, address, count):
        if (address, count) != (0x1003, 1):
            raise Exception_(2)
        return [(4 if self.at != self.target else 0) | (1 if self.alarm else 0)]

    def write(self, address, words):
        if address == 0x6002 and words == [0x0040]:
            self.target, self.stops = self.at, self.stops + 1
        elif address == 0x6200 and len(words) == 8 and words[0] == 1 and words[7] == 0x0010:
            self.target, self.rate = int32(words, 1), words[3] * 1000 / 60
            self.moves.append((self.target, words[3]))
        else:
            raise Exception_(2)


class Server(threading.Thread):
    """Modbus TCP for `device`. One connection: a new one takes the place of the old one."""

    def __init__(self, device):
        super().__init__(daemon=True)
        self.device, self.lock, self.ended, self.peer, self.data = device, threading.Lock(), False, None, b""
        self.cut, self.unanswered, self.silent, self.refuse = False, 0, False, lambda pdu: False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.start()

    def hang_up(self):
        self.cut = True

    def mute(self, requests):
        """Does so many requests and does not answer."""
        self.unanswered = requests

    def end(self):
        self.ended = True
        self.join()

    def run(self):
        while not self.ended:
            ready = select.select([self.listener] + ([self.peer] if self.peer else []), [], [], 0.002)[0]
            with self.lock:
                self.device.advance()
            if self.listener in ready:
                self.hear(self.listener.accept()[0])
            elif self.peer in ready:
                self.serve()
            if self.cut:
                self.hear(None)
                self.cut = False
        self.hear(None)
        self.listener.close()

    def hear(self, peer):
        if self.peer:
            self.peer.close()
        self.peer, self.data = peer, b""
        if peer:
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def serve(self):
        try:
            more = self.peer.recv(4096)
            self.data += more
            while len(self.data) >= 6 and len(self.data) >= 6 + struct.unpack(">H", self.data[4:6])[0]:
                size = 6 + struct.unpack(">H", self.data[4:6])[0]
                head, unit, pdu, self.data = self.data[:4], self.data[6], self.data[7:size], self.data[size:]
                with self.lock:
                    reply = b"" if self.silent else self.answer(pdu)
                if self.unanswered > 0:
                    self.unanswered, reply = self.unanswered - 1, b""
                if reply:
                    self.peer.sendall(head + struct.pack(">HB", len(reply) + 1, unit) + reply)
        except OSError:
            more = b""
        if not more:
            self.hear(None)

    def answer(self, pdu):
        try:
            if self.refuse(pdu):
                raise Exception_(4)
            return self.act(pdu)
        except Exception_ as refused:
            return bytes([pdu[0] | 0x80, refused.code])

    def act(self, pdu):
        function, device = pdu[0], self.device
        if function == 3:
            address, count = struct.unpack(">HH", pdu[1:5])
            return self.registers(function, device.read(address, count))
        if function == 16:
            address, count, _ = struct.unpack(">HHB", pdu[1:6])
            device.write(address, list(struct.unpack(f">{count}H", pdu[6:])))
            device.advance()
            return pdu[:5]
        if function == 23 and device.fc23:
            read_at, read_count, address, count, _ = struct.unpack(">HHHHB", pdu[1:10])
            if (read_at, read_count) != (STATUS, 24):
                raise Exception_(2)
            device.write(address, list(struct.unpack(f">{count}H", pdu[10:])))
            device.advance()
            return self.registers(function, device.read(read_at, read_count))
        raise Exception_(1)

    @staticmethod
    def registers(function, words):
        return struct.pack(f">BB{len(words)}H", function, 2 * len(words), *words)
