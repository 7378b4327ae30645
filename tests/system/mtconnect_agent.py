#!/usr/bin/python3
"""The MTConnect Institute's C++ agent reads the adapter: /probe, /current and /sample with a run on a simulated machine, and
their schemas; adapter, agent and service die and come back. By hand: the agent is not in Debian.

mtconnect_agent.py BIN_FOLDER WORK_FOLDER AGENT SCHEMA_FOLDER

AGENT: the program of github.com/mtconnect/cppagent; SCHEMA_FOLDER: its `schemas`. xmllint reads those of 1.6, not of 1.8.
"""

import os
import re
import subprocess
import sys
import time
import urllib.request

from service_run import Run, write_feeds

VERSION, ADAPTER, AGENT = "1.6", 17878, 15000
RUNNING = ("program", "line", "block", "feedrate", "S_speed", "position", "X_position", "Y_position", "Z_position", "A_angle", "C_angle",
           "mode", "feed_override", "rapid_override", "S_override")


def get(path):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{AGENT}/{path}", timeout=5) as answer:
            return answer.read().decode()
    except OSError:
        return ""


def current():
    """Of each item by name: its value, or a condition's level."""
    found = {}
    for tag, words, text in re.findall(r"<(\w+) ([^>]*?)(?:/>|>([^<]*)</)", get("current")):
        name = re.search(r'\bname="([^"]*)"', words)
        if name and "dataItemId" in words:
            found[name[1]] = tag if tag in ("Normal", "Warning", "Fault", "Unavailable") else text
    return found


class Shop:
    def __init__(self, run):
        self.run = run
        self.schemas = os.path.abspath(sys.argv[4])
        self.agent = self.adapter = None

    def valid(self, kind, text):
        self.run.write("answer.xml", text)
        done = subprocess.run(["xmllint", "--noout", "--nonet", "--schema", f"{self.schemas}/MTConnect{kind}_{VERSION}_1.0.xsd", f"{self.run.work}/answer.xml"],
                              capture_output=True, text=True, check=False)
        self.run.want(done.returncode == 0, done.stderr[-2000:])

    def start_adapter(self):
        self.adapter = self.run.start("mtconnect.log", [f"{self.run.bin}/tiltfeed", "mtconnect", "--config", f"{self.run.work}/service.yaml",
                                                        "--listen", f"127.0.0.1:{ADAPTER}"])

    def start_agent(self):
        self.agent = self.run.start("agent.log", [os.path.abspath(sys.argv[3]), "debug", f"{self.run.work}/agent.cfg"])

    def until(self, what, holds):
        begun = time.monotonic()
        self.run.until(what, lambda: holds(current()), seconds=60)
        return time.monotonic() - begun


def main():
    run = Run(sys.argv[1], sys.argv[2])
    shop = Shop(run)
    write_feeds(f"{run.work}/program.nc", [(0.01 * (i % 1000), 0, 50, 0, 0.05 * i) for i in range(2000)], 600)
    run.configure(f"grbl:{run.simulate('--pty', f'{run.work}/machine', '--speed', '5', '--trace', f'{run.work}/trace.csv')}")
    run.serve_ready()
    status, text = run.tiltfeed("mtconnect", "--config", f"{run.work}/service.yaml", "--device-file", f"{run.work}/Devices.xml")
    run.want(status == 0, text)
    device = re.search(r'<Device [^>]*\bname="([^"]*)"', run.text("Devices.xml"))[1]
    run.write("agent.cfg", f"Devices = {run.work}/Devices.xml\nPort = {AGENT}\nReconnectInterval = 1000\nSchemaVersion = {VERSION}\nPretty = true\n"
              f"Adapters {{\n  {device} {{\n    Host = 127.0.0.1\n    Port = {ADAPTER}\n    UpcaseDataItemValue = false\n  }}\n}}\n"
              f"logger_config {{\n  logging_level = info\n  output = file {run.work}/agent_own.log\n}}\n")
    shop.start_adapter()
    shop.start_agent()
    shop.until("the agent does not hear the adapter", lambda now: now.get("avail") == "AVAILABLE" and now["execution"] == "READY")
    items = re.findall(r'<DataItem [^>]*\bname="([^"]*)"', run.text("Devices.xml"))
    probe = get("probe")
    run.want(all(f'name="{item}"' in probe for item in items), "the agent has taken other items")
    shop.valid("Devices", probe)
    shop.valid("Streams", get("current"))

    job = run.job_in_the_cut(10)
    shop.until("the run is not seen", lambda now: now["execution"] == "ACTIVE" and all(now[item] != "UNAVAILABLE" for item in RUNNING))
    run.want(current()["program"] == "program", current())
    shop.valid("Streams", get("current"))
    run.until("the lines do not come", lambda: get("sample?count=5000").count("<LineNumber") > 5, seconds=60)
    sample = get("sample?count=5000")
    shop.valid("Streams", sample)
    run.want(re.findall(r"<Execution[^>]*>(\w+)", sample)[-2:] == ["READY", "ACTIVE"], sample)
    run.want(run.tiltfeed("hold")[0] == 0, "not held")
    shop.until("the hold is not seen", lambda now: now["execution"] == "FEED_HOLD" and now["motion"] == "Warning")
    shop.valid("Streams", get("current"))

    shop.adapter.kill()
    gone = shop.until("a dead adapter is not seen", lambda now: all(now[item] in ("UNAVAILABLE", "Unavailable") for item in items))
    shop.start_adapter()
    back = shop.until("the adapter is not heard again", lambda now: now["execution"] == "FEED_HOLD" and now["motion"] == "Warning")
    shop.agent.kill()
    shop.agent.wait()
    shop.start_agent()
    again = shop.until("an agent that comes back does not hear all", lambda now: now.get("execution") == "FEED_HOLD" and now["position"] != "UNAVAILABLE")
    run.want(run.tiltfeed("resume")[0] == 0, "not resumed")
    shop.until("the run does not go on", lambda now: now["execution"] == "ACTIVE")
    run.kill()
    shop.until("the service's death is not seen", lambda now: now["avail"] == "UNAVAILABLE")
    time.sleep(25)  # longer than the agent waits for an answer to its pings
    run.serve_ready()
    shop.until("what became of the run is not told", lambda now: now["avail"] == "AVAILABLE" and now["execution"] == "INTERRUPTED" and now["comms"] == "Fault")
    shop.valid("Streams", get("current"))
    run.want(run.show(job, "state") in ("interrupted", "uncertain"), run.show(job, "state"))
    run.end()
    print(f"mtconnect_agent: {len(items)} items; a dead adapter seen after {gone:.2f} s, heard again {back:.2f} s after its start; all heard by a new agent after {again:.2f} s")


main()
