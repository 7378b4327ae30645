#!/usr/bin/python3
"""Two MTConnect agents hear of a service with a run on a simulated machine: states in their order, lines and places of
the program, a hold, the end; the service's death and return; an agent that comes back hears everything again.

mtconnect_test.py BIN_FOLDER WORK_FOLDER [--measure]

The agents are of this file, by the rules of SHDR 1.
"""

import re
import socket
import sys
import threading
import time
import xml.etree.ElementTree

from service_run import ROOT, Run, write_feeds

CONDITION = r"(NORMAL|WARNING|FAULT|UNAVAILABLE)\|[^|]*\|[^|]*\|[^|]*\|.*"


class Agent:
    """Keeps the newest value of each item, and all that were told; notes lines that break the rules."""

    def __init__(self, address, conditions):
        self.now, self.told, self.wrong, self.last_time = {}, [], [], ""
        self.conditions = conditions
        host, port = address.rsplit(":", 1)
        self.wire = socket.create_connection((host, int(port)))
        self.wire.sendall(b"* PING\n")
        self.pongs = 0
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        with self.wire.makefile("r", encoding="utf-8") as lines:
            for line in lines:
                self.take(line.rstrip("\n"))

    def take(self, line):
        if line.startswith("* "):
            self.pongs += line == "* PONG 10000"
            return
        fields = re.split(r"(?<!\\)\|", line)
        if not re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", fields[0]) or fields[0] < self.last_time:
            self.wrong.append(line)
        self.last_time = fields[0]
        if fields[1] in self.conditions:
            if not re.fullmatch(CONDITION, "|".join(fields[2:])):
                self.wrong.append(line)
            self.keep(fields[1], fields[2])
            return
        if len(fields) % 2 == 0:
            self.wrong.append(line)
        for key, value in zip(fields[1::2], fields[2::2]):
            self.keep(key, value)

    def keep(self, key, value):
        if self.now.get(key) != value:
            self.told.append((key, value))
        self.now[key] = value

    def values(self, key):
        return [value for name, value in self.told if name == key]

    def close(self):
        self.wire.shutdown(socket.SHUT_RDWR)
        self.wire.close()


def measure(run, agent, address, items, conditions):
    """From the answer to an order to the agent's line; agents that come again and again, each until it has heard all."""
    waits = {"FEED_HOLD": [], "ACTIVE": []}
    for _ in range(20):
        for order, state in (("hold", "FEED_HOLD"), ("resume", "ACTIVE")):
            run.want(run.tiltfeed(order)[0] == 0, order)
            begun = time.monotonic()
            run.until(f"no {state}", lambda: agent.now["execution"] == state)
            waits[state].append(time.monotonic() - begun)
    comes = []
    for _ in range(100):
        begun = time.monotonic()
        other = Agent(address, conditions)
        run.until("who comes again does not hear all", lambda: set(other.now) == items)
        comes.append(time.monotonic() - begun)
        other.close()
        run.want(not other.wrong, other.wrong)
    for name, times in (*waits.items(), ("all items after a connect", comes)):
        times.sort()
        print(f"{name}: median {1000 * times[len(times) // 2]:.0f} ms, slowest {1000 * times[-1]:.0f} ms of {len(times)}")


def main():
    run = Run(sys.argv[1], sys.argv[2])
    program = f"{run.work}/program.nc"
    write_feeds(program, [(0.01 * (i % 1000), 0, 50, 0, 0.05 * i) for i in range(60000 if "--measure" in sys.argv else 600)], 600)
    with open(program, encoding="ascii") as text:
        lines = text.read().split("\n")
    run.configure(f"grbl:{run.simulate('--pty', f'{run.work}/machine', '--speed', '5', '--trace', f'{run.work}/trace.csv')}")
    run.serve_ready()

    config = f"{run.work}/service.yaml"
    status, text = run.tiltfeed("mtconnect", "--config", config, "--device-file", "-")
    run.want(status == 0, text)
    items = {item.get("name"): item for item in xml.etree.ElementTree.fromstring(text).iter() if item.tag.endswith("}DataItem")}
    conditions = {key for key, item in items.items() if item.get("category") == "CONDITION"}
    run.start("mtconnect.log", [f"{run.bin}/tiltfeed", "mtconnect", "--config", config, "--listen", "127.0.0.1:0"])
    ready = lambda: re.search(r"^ready on (\S+)$", run.text("mtconnect.log"), re.MULTILINE)
    run.until("no adapter", ready)
    agents = [Agent(ready().group(1), conditions) for _ in range(2)]
    for agent in agents:
        run.until("not ready", lambda: agent.now.get("execution") == "READY")
        run.until("no answer to PING", lambda: agent.pongs == 1)
        run.want(set(agent.now) == set(items), f"items: {set(agent.now) ^ set(items)}")
    first = agents[0]
    run.want(first.now["X_position"] == "UNAVAILABLE", "a place of a machine that nobody has asked")

    job = run.job_in_the_cut(10)
    run.until("the run is not seen", lambda: first.now["execution"] == "ACTIVE" and first.now["C_angle"] != "UNAVAILABLE")
    run.until("feed and spindle are not told", lambda: float(first.now["feedrate"].replace("UNAVAILABLE", "0")) > 0 and float(first.now["S_speed"].replace("UNAVAILABLE", "0")) == 8000)
    run.want(first.now["program"] == "program" and first.now["mode"] == "AUTOMATIC", f"{first.now}")
    run.want(run.tiltfeed("hold")[0] == 0, "not held")
    for agent in agents:
        run.until("the hold is not seen", lambda: agent.now["execution"] == "FEED_HOLD" and agent.now["motion"] == "WARNING")
    if first.now["line"] != "UNAVAILABLE":
        run.want(first.now["block"] == lines[int(first.now["line"]) - 1], f"{first.now['line']}: {first.now['block']}")

    if "--measure" in sys.argv:
        run.want(run.tiltfeed("resume")[0] == 0, "not resumed")
        measure(run, first, ready().group(1), set(items), conditions)
        run.end()
        return

    agents[1].close()
    run.want(run.tiltfeed("resume")[0] == 0, "not resumed")
    run.until("not done", lambda: run.show(job, "state") == "done")
    run.until("the end is not seen", lambda: first.now["execution"] == "PROGRAM_COMPLETED" and first.now["parts"] == "1")
    run.want(first.now["motion"] == "NORMAL" and {first.now[key] for key in ("X_position", "feedrate", "S_speed")} == {"UNAVAILABLE"}, f"{first.now}")
    turns = first.values("execution")
    run.want(turns[:1] == ["READY"] or turns[:2] == ["UNAVAILABLE", "READY"], f"{turns}")
    run.want([turn for turn in turns if turn in ("FEED_HOLD", "PROGRAM_COMPLETED")] == ["FEED_HOLD", "PROGRAM_COMPLETED"], f"{turns}")
    angles = [float(value) for value in first.values("C_angle") if value != "UNAVAILABLE"]
    run.want(angles == sorted(angles) and len(angles) > 2, f"C turns one way only: {angles}")

    run.kill()
    run.until("the dead service is not seen", lambda: first.now["avail"] == "UNAVAILABLE")
    run.want(set(first.now.values()) == {"UNAVAILABLE"}, f"{first.now}")
    run.serve_ready()
    run.until("the service is not seen again", lambda: first.now["avail"] == "AVAILABLE" and first.now["parts"] == "1")
    again = Agent(ready().group(1), conditions)
    run.until("who comes back does not hear all", lambda: again.now == first.now)
    for agent in [*agents, again]:
        run.want(not agent.wrong, f"lines: {agent.wrong[:3]}")
    run.end()
    print(f"mtconnect: {len(items)} items, execution {' '.join(turns)}, {len(angles)} angles")


main()
