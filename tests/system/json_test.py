#!/usr/bin/python3
"""Every subcommand of tiltfeed that shows something shows it as one JSON object with --json, and nothing else on standard output.
The subcommands are those that --help lists, so a new one has to be walked here, too.

json_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import re
import subprocess
import sys

from service_run import ROOT, Run
from shop_cluster import Cluster, is_here

SILENT = {"desk", "mtconnect"}  # they serve until they are ended


def leaves(run, words=()):
    """Subcommands without subcommands of their own."""
    text = run.tiltfeed(*words, "--help")[1]
    found = text.partition("Subcommands:")[2]
    names = re.findall(r"^  ([a-z][a-z-]*)(?:\s|$)", found, re.MULTILINE)
    if words == ("verify",) or not names:
        return [(words, text)]
    return [leaf for name in names for leaf in leaves(run, (*words, name))]


def main():
    run = Run(sys.argv[1], sys.argv[2])
    walked = set()

    def ask(*arguments, words=1, status=0):
        done = subprocess.run([f"{run.bin}/tiltfeed", *arguments, "--json"], capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, check=False)
        name = " ".join(arguments)
        run.want(done.returncode == status or status is None, f"{name}: exit status {done.returncode}: {done.stdout}{done.stderr}")
        try:
            answer = json.loads(done.stdout)
        except ValueError as error:
            run.fail(f"{name}: no JSON ({error}): {done.stdout[:400]}")
        run.want(isinstance(answer, dict), f"{name}: no object")
        walked.add(tuple(arguments[:words]))
        return answer

    try:
        walk(run, ask)
        if is_here():
            walk_shop(run, ask)
        every = {words: text for words, text in leaves(run)}
        run.want(len(every) > 25, f"the subcommands are not understood: {sorted(every)}")
        for words, text in every.items():
            if words[0] not in SILENT:
                run.want("--json" in text, f"{' '.join(words)} --help does not offer --json")
        left = {words for words in every if words[0] not in SILENT} - walked
        if not is_here():
            left = {words for words in left if words[0] != "shop"}
        run.want(not left, f"not walked: {sorted(left)}")
    finally:
        run.end()
    print(f"json: {len(walked)} subcommands, all as expected")


def walk_shop(run, ask):
    cluster = Cluster(durable=False)
    cluster.start()
    try:
        shop = ["--shop", cluster.url()]
        ask("shop", "init", *shop, words=2)
        made = ask("submit", f"{run.work}/short.nc", *shop, "--machine", f"{ROOT}/config/machines/generic-ac.yaml", "--tool", "7")
        run.want(made["needs"]["tools"] == [{"number": 7}] and not made["fits_one"] and made["why_not"], f"not that job: {made}")
        again = ask("submit", f"{run.work}/short.nc", *shop, "--machine", f"{ROOT}/config/machines/generic-ac.yaml", "--id", made["id"])
        run.want(again["job"] == made["job"], "one id made two jobs")
        listed = ask("shop", "list", *shop, words=2)
        run.want([job["state"] for job in listed["jobs"]] == ["open"] and listed["machines"] == [], f"not that queue: {listed}")
        ask("shop", "withdraw", "1", *shop, words=2)
        run.want(ask("shop", "list", *shop, words=2)["jobs"] == [], "a job that is withdrawn waits")
        ask("shop", "release", "1", *shop, words=2)
        run.want(ask("shop", "raise", "--yes", *shop, words=2)["epoch"] == 2, "not the next epoch")
    finally:
        cluster.end()


def machine_check(run, ask, profile):
    """A table that turns the other way, by closed form: with the head upright the tip's place has Y with the other sign. A tip on the
    table's axis stays there either way."""
    for aside, status in ((0, 0), (50, 1)):
        program = ask("machine", "check", profile, "--aside", str(aside), words=2)["program"]
        stops = re.findall(r"^G1 X(\S+) Y(\S+) Z(\S+) A0 C\S+ F", program, re.MULTILINE)
        numbers = [int(number) for number, _ in re.findall(r"^\((\d+): .*\n\(.*\n(G1 .* A0 C)", program, re.MULTILINE)]
        run.want(len(stops) == len(numbers) == 4 and float(stops[0][0]) == aside, f"other stops: {program}")
        with open(f"{run.work}/found.csv", "w", encoding="ascii") as out:
            out.write("stop,x_mm,y_mm,z_mm\n")
            for number, (x, y, z) in zip(numbers, stops):
                out.write(f"{number},{x},{-float(y)},{z}\n")
        said = ask("machine", "check", profile, "--aside", str(aside), "--found", f"{run.work}/found.csv", words=2, status=status)
        if aside:
            run.want("rotary.sign: 1" in [one["change"] for one in said["remedies"]], f"not that sign: {said}")
        else:
            run.want(said["passed"] and "rotary.sign" in said["not_told"], f"nobody says that the sign is not told: {said}")


def walk(run, ask):
    work = run.work
    job = f"{work}/job.yaml"
    with open(f"{ROOT}/config/jobs/sphere.yaml", encoding="utf-8") as file:
        text = file.read()
    text = re.sub(r"(?m)^(\s*stl:\s*)\S+", rf"\g<1>{work}/sphere.stl", text)
    text = re.sub(r"(?m)^(\s*machine:\s*)\S+", rf"\g<1>{ROOT}/config/machines/generic-ac.yaml", text)
    text = re.sub(r"(?m)^(\s*side_step_mm:\s*)\S+", r"\g<1>4", text)
    with open(job, "w", encoding="utf-8") as out:
        out.write(text)
    subprocess.run([f"{run.bin}/tiltfeed-sim", "part", "sphere", "--out", f"{work}/sphere.stl"], check=True, capture_output=True)
    profile = f"{ROOT}/config/machines/generic-ac.yaml"
    run.want(ask("check", job)["facets"] > 0, "no part")
    run.want("--out" in ask("help", "plan")["text"], "no help")
    proposed = ask("suggest", f"{work}/sphere.stl", "--machine", profile)
    first = ask("init", f"{work}/sphere.stl", "--machine", profile, "--out", f"{work}/first.yaml")
    run.want(first["job"] == f"{work}/first.yaml", "not that job")
    run.want(proposed["proposals"] and proposed["facets"] > 0, f"nothing proposed: {list(proposed)}")
    library, table = f"{work}/tools.yaml", f"{work}/tool.tbl"
    run.want(ask("tools", "list", f"{ROOT}/config/tools/example.yaml", words=2), "no tools")
    with open(table, "w", encoding="ascii") as out:
        out.write("T1 P1 Z+80.0 D+6.0 ;ball\n")
    run.want(ask("tools", "import", table, "--unit", "mm", "--out", library, words=2), "nothing was brought in")
    report = ask("plan", job, "--out", f"{work}/part.nc", "--cl", f"{work}/part.cls")
    run.want(report["blocks"] > 0 and "proof" in report, f"no report: {list(report)}")
    ask("post", f"{work}/part.cls", "--machine", profile, "--out", f"{work}/posted.nc")
    run.want(ask("unpost", f"{work}/part.nc", "--machine", profile, "--out", f"{work}/back.cls")["blocks"] > 0, "no blocks")
    run.want(len(ask("post", "--list-dialects")["dialects"]) >= 5, "no dialects")
    run.want("verdict" in json.dumps(ask("verify", job, f"{work}/part.nc", "--resolution", "2")), "no verdict")
    run.want("G" in ask("machine", "check", profile, words=2)["program"], "no program")
    machine_check(run, ask, profile)
    run.want(len(ask("machine", "measure", profile, "--tool-length", "120", words=2)["next"]) > 4, "no places")

    short = f"{work}/short.nc"
    with open(short, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F600\nM2\n")
    alone = run.simulate("--grbl-tcp", "127.0.0.1:0")
    over = ["--machine", profile, "--link", f"grbl-tcp:{alone}"]
    run.want(ask("send", short, *over)["executed"], "not executed")
    run.want(ask("reset", "--yes", "--link", f"grbl-tcp:{alone}")["reset"], "no word of the reset")
    for words in (["status"], ["unlock"], ["jog", "X1"], ["offsets"], ["settings"], ["override", "feed", "90"],
                  ["console", "$G"], ["tool", "park"]):
        ask("machine", *words, *over, words=2)
    ask("machine", "settings", "set", "22=1", *over, words=2)
    ask("machine", "home", *over, words=2)

    wide = f"{work}/wide.nc"
    with open(wide, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n" + "".join(f"G1X{i % 97}F60\n" for i in range(5000)) + "G94\nM2\n")
    run.configure("grbl-tcp:" + run.simulate("--grbl-tcp", "127.0.0.1:0", "--speed", "1", "--probe-plate", "-20"))
    machine = ask("serve", "--check", "--config", f"{work}/service.yaml")
    run.want(machine["queue"] == "", "a queue that nobody has named")
    run.want(machine["link"].startswith("grbl-tcp:127.0.0.1:") and machine["machine"] == "generic-ac", f"not that service: {machine}")

    def finding(what, *options):
        # Versions, clock and processes are this computer's: all may be good, or not.
        said = ask("doctor", "--config", f"{work}/service.yaml", *options, status=None)
        bad = [one for one in said["findings"] if one["verdict"] == "to do"]
        run.want(said["good"] == (not bad), f"good, and yet: {bad}")
        return next((one["verdict"], one["text"]) for one in said["findings"] if one["what"] == what)

    run.want(finding("controller")[0] == "not asked", "the line was opened without being told to")
    run.want(finding("service")[0] == "not asked", "a service that is not there answers")
    run.want(finding("controller", "--open") == ("good", "state    Idle: ready"), "the controller does not answer")
    run.serve_ready()
    run.want(finding("service")[0] == "good", "the service does not answer")
    verdict, text = finding("controller", "--open")
    run.want(verdict == "to do" and "serves already" in text, f"a service's machine was asked behind its back: {text}")
    number = str(ask("submit", wide)["job"])
    run.until("the program is not ready", lambda: run.show(number, "state") == "ready")
    ask("machine", "probe", "Z-25", "F3000", words=2)
    ask("list")
    ask("history")
    ask("show", number)
    run.want(ask("show", number, "--block", "10")["origin"]["line"] == 10, "not that block")
    beyond = ask("show", number, "--block", "99999", status=1)
    run.want("the program has 5005" in beyond["origin"]["error"], f"not said that it is beyond the end: {beyond}")

    def figures():
        return dict(re.findall(r"(?m)^(tiltfeed_.*) (\S+)$", ask("metrics", "--config", f"{work}/service.yaml")["text"]))

    still = figures()
    run.want(still["tiltfeed_up"] == "1.0" and still['tiltfeed_jobs{state="ready"}'] == "1.0" and "tiltfeed_run_blocks" not in still,
             f"not those figures: {still}")
    ask("start", number)
    ask("hold")
    run.until("not held", lambda: run.show(number, "held") == "held on request")
    run.want("held on request" in ask("machine", "status", words=2)["held"], "the status does not say that it is held")
    run.until("the log does not say that it is held", lambda: "held on request" in run.text("serve.log"))
    run.until("no figures of the hold", lambda: figures().get('tiltfeed_run_phase{phase="hold"}') == "1.0")
    run.want(int(float(figures()["tiltfeed_run_blocks"])) == int(run.show(number, "blocks")), "not as many blocks as the program has")
    ask("resume", number)
    text = ask("support-bundle", "--config", f"{work}/service.yaml")["text"]
    for part in ("==== doctor ====", "generic-ac", f'"job":{number}', '"outcome":"running"', "spool: spool"):
        run.want(part in text, f"the bundle does not have {part}: {text}")
    ask("override", number, "80")
    ask("stop", number)
    run.until("it does not stop", lambda: run.show(number, "state") == "stopped")
    ask("watch", number, status=1)
    ask("backup", "--config", f"{work}/service.yaml", f"{work}/copy")
    ask("remove", number)
    turns = f"{work}/turns.nc"
    with open(turns, "w", encoding="ascii") as out:
        out.write("G21 G90 G94\nT3 M6 (ball)\nG0 X0 Y0 Z50 A0 C0\nM2\n")
    number = str(ask("submit", turns)["job"])
    run.until("the program is not ready", lambda: run.show(number, "state") == "ready")
    ask("start", number)
    run.until("no tool change", lambda: run.show(number, "state") == "tool change")
    shown = ask("tool", number, "show")
    run.want((shown["tool"], shown["tool_name"], shown["line"]) == (3, "ball", 2), f"not that tool: {shown}")
    run.want(shown["parked"].startswith("parked"), f"not parked: {shown}")
    run.want("80" in ask("tool", number, "length", "80")["text"], "not that length")
    run.want(ask("tool", number)["length"] == 80, "the length is not kept")
    ask("tool", number, "go", "--yes")
    run.until("it does not go on", lambda: run.show(number, "state") == "done")
    run.kill()
    run.want(figures()["tiltfeed_up"] == "0.0", "a service that is gone is up")
    text = ask("support-bundle", "--config", f"{work}/service.yaml")["text"]
    run.want("no service answers at" in text, f"not said in the bundle: {text}")
    ask("safe-stop", "--config", f"{work}/service.yaml")


if __name__ == "__main__":
    main()
