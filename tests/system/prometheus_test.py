#!/usr/bin/python3
"""Debian's Prometheus scrapes what the desk says at /metrics of a service with a run on a simulated machine (without a desk:
what `tiltfeed metrics` says): the figures that it stores are those of `tiltfeed list`; a hold and the death of the service are seen; the rules that come along are loaded and
raise their alarm. promtool finds figures and rules in order, and passes the tests of the rules.

prometheus_test.py BIN_FOLDER WORK_FOLDER TOOLS_FOLDER

Prometheus is the Debian package, unpacked into TOOLS_FOLDER and not installed: an installed one would run as a service.
"""

import glob
import http.server
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import urllib.error
import urllib.parse
import urllib.request

from service_run import ROOT, Run, write_feeds

RULES = f"{ROOT}/config/prometheus/tiltfeed.rules"
LONG = 40000  # feeds of 0.1 s: more than the test waits for


def unpack(tools):
    """The folder of prometheus and promtool; a half-made one never counts."""
    there = f"{tools}/prometheus"
    if not os.access(f"{there}/usr/bin/prometheus", os.X_OK):
        os.makedirs(tools, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=tools) as fresh:
            os.chmod(fresh, 0o755)
            download = ["apt-get", "-qq", "download", "prometheus"]
            if subprocess.run(download, cwd=fresh, capture_output=True, check=False).returncode:
                subprocess.run([*([] if os.geteuid() == 0 else ["sudo", "-n"]), "apt-get", "-qq", "update"], check=True)
                subprocess.run(download, cwd=fresh, check=True)
            subprocess.run(["dpkg", "-x", *glob.glob(f"{fresh}/prometheus_*.deb"), f"{fresh}/root"], check=True)
            shutil.rmtree(there, ignore_errors=True)
            os.rename(f"{fresh}/root", there)
    return f"{there}/usr/bin"


class Exporter(http.server.ThreadingHTTPServer):
    """Gives what `tiltfeed metrics` prints, as node_exporter gives a textfile."""

    def __init__(self, run):
        class Answer(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                status, text = run.tiltfeed("metrics", "--config", f"{run.work}/service.yaml")
                self.send_response(500 if status else 200)
                self.send_header("Content-Type", "text/plain; version=0.0.4")
                self.end_headers()
                self.wfile.write(text.encode())

            def log_message(self, *_):
                pass

        super().__init__(("127.0.0.1", 0), Answer)
        threading.Thread(target=self.serve_forever, daemon=True).start()


class DeskExporter:
    """The desk beside the service, and a token that watches."""

    def __init__(self, run):
        from desk_client import Desk
        added = [f"{run.bin}/tiltfeed", "desk", "token", "add", "prometheus", "--scope", "watch", "--tokens", f"{run.work}/tokens"]
        self.token = subprocess.run(added, capture_output=True, text=True, check=True).stdout.strip()
        run.write("desk.yaml", "listen: 127.0.0.1:0\ntokens: tokens\n")
        desk = Desk(run.bin, "--beside", f"{run.work}/service.yaml", "--access", f"{run.work}/desk.yaml")
        run.processes.append(desk.process)
        self.server_port = desk.port
        for token, wanted in (("0" * 64, 401), (self.token, 200)):
            status, headers, body = desk.ask("GET", "/metrics", Authorization=f"Bearer {token}", Origin=None)
            run.want(status == wanted, f"a token is answered {status}: {body}")
        run.want(headers["Content-Type"].startswith("text/plain; version=0.0.4"), headers)
        run.want(desk.ask("GET", "/metrics", Origin=None)[0] == 401, "figures for who is not known")


class Prometheus:
    def __init__(self, run, folder, exporter):
        token = getattr(exporter, "token", None)
        with open(f"{run.work}/prometheus.yaml", "w", encoding="utf-8") as out:
            json.dump({"global": {"scrape_interval": "500ms", "scrape_timeout": "500ms", "evaluation_interval": "500ms"},
                       "rule_files": [f"{RULES}.yaml"],
                       "scrape_configs": [{"job_name": "tiltfeed", "scrape_timeout": "500ms", **({"authorization": {"credentials": token}} if token else {}),
                                           "static_configs": [{"targets": [f"127.0.0.1:{exporter.server_port}"]}]}]}, out)
        self.run = run
        # Port 0 cannot be asked for here: Prometheus does not say which one it got.
        port = free_port()
        self.url = f"http://127.0.0.1:{port}/api/v1/"
        self.process = run.start("prometheus.log", [
            f"{folder}/prometheus", f"--config.file={run.work}/prometheus.yaml", f"--storage.tsdb.path={run.work}/tsdb",
            f"--web.listen-address=127.0.0.1:{port}"])

    def get(self, path, **words):
        try:
            with urllib.request.urlopen(f"{self.url}{path}?{urllib.parse.urlencode(words)}", timeout=60) as answer:
                return json.load(answer)["data"]
        except (urllib.error.URLError, ConnectionError):
            self.run.want(self.process.poll() is None, "prometheus has ended")
            return None

    def value(self, query):
        """Of the one series that the query has; None: of none."""
        data = self.get("query", query=query)
        found = data["result"] if data else []
        self.run.want(len(found) <= 1, f"{query}: {found}")
        return float(found[0]["value"][1]) if found else None


def free_port():
    with http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as server:
        return server.server_port


def promtool(run, folder, *words, text=None):
    done = subprocess.run([f"{folder}/promtool", *words], input=text, capture_output=True, text=True, check=False)
    run.want(done.returncode == 0 and not done.stderr.strip(), f"promtool {words}: {done.stdout}{done.stderr}")


def main():
    run = Run(sys.argv[1], sys.argv[2])
    folder = unpack(os.path.abspath(sys.argv[3]))
    promtool(run, folder, "check", "rules", f"{RULES}.yaml")
    promtool(run, folder, "test", "rules", f"{RULES}.test.yaml")

    write_feeds(f"{run.work}/program.nc", [(0.01 * (i % 1000), 0, 50, 0, 0) for i in range(LONG)], 600)
    run.configure(f"modbus-tcp:{run.simulate('--modbus-tcp', '127.0.0.1:0', '--trace', f'{run.work}/trace.csv')}")
    # Nobody is there; what is told of plans is told all the same.
    run.write("service.yaml", run.text("service.yaml") + f"queue: postgresql://nobody@/none?host={run.work}\n")
    run.serve_ready()
    prometheus = Prometheus(run, folder, (DeskExporter if os.path.exists(f"{run.bin}/tiltfeed-desk") else Exporter)(run))
    run.until("no scrape", lambda: prometheus.value("tiltfeed_up") == 1)
    run.want(prometheus.value("tiltfeed_run_blocks") is None, "figures of a run where none is")

    job = run.job_in_the_cut(10)
    promtool(run, folder, "check", "metrics", text=run.tiltfeed("metrics", "--config", f"{run.work}/service.yaml")[1])
    run.until("the run is not seen", lambda: prometheus.value('tiltfeed_run_phase{phase="run"}') == 1)
    run.until("no blocks are counted", lambda: (prometheus.value("tiltfeed_run_executed_blocks") or 0) > 10)
    run.want(prometheus.value("tiltfeed_run_blocks") == float(run.show(job, "blocks")), "another number of blocks")

    run.want(run.tiltfeed("hold")[0] == 0, "not held")
    run.until("the hold is not seen", lambda: prometheus.value('tiltfeed_run_phase{phase="hold"}') == 1)
    run.until("its answer's time is not seen", lambda: prometheus.value("tiltfeed_run_slowest_hold_seconds") is not None)
    run.want(prometheus.value('tiltfeed_plans_for_others_ended_total{outcome="done"}') == 0, "plans for nobody")
    waits = lambda alert: prometheus.value(f'ALERTS{{alertname="{alert}"}}') == 1
    run.until("no alarm of the hold is on its way", lambda: waits("TiltfeedHeld"))
    run.want(not waits("TiltfeedServiceDown"), "an alarm of a service that answers")

    run.kill()
    run.until("the dead service is not seen", lambda: prometheus.value("tiltfeed_up") == 0)
    run.until("no alarm of the dead service is on its way", lambda: waits("TiltfeedServiceDown"))
    rules = [rule for group in prometheus.get("rules")["groups"] for rule in group["rules"]]
    run.want(len(rules) >= 6 and all(rule["health"] == "ok" for rule in rules), f"rules: {rules}")
    run.end()
    print(f"prometheus: {len(rules)} rules, run, hold and death of the service seen")


main()
