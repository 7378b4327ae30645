#!/usr/bin/python3
"""Manual pages, help, completion and misspelt words: all from the command lines' own description.

Every page passes `mandoc -T lint`; every subcommand and every key has its place; options mean the same wherever they are;
the completion scripts are run in their shells (zsh and fish where they are installed).

manual_test.py BIN_FOLDER WORK_FOLDER
"""

import json
import os
import re
import shutil
import subprocess
import sys

BIN, WORK = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAMS = [name for name in ("tiltfeed", "tiltfeed-sim", "tiltfeed-desk", "tiltfeed-cad") if os.path.exists(f"{BIN}/{name}")]
failures = []


def want(holds, what):
    if not holds:
        failures.append(what)


def call(*words, **options):
    return subprocess.run(words, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL, **options)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def walk(command, path):
    yield path, command
    for inner in command["commands"]:
        yield from walk(inner, (*path, inner["name"]))


def check_pages(every):
    """Pages by mandoc itself: as it reads them, the text has every option."""
    pages = {}
    for folder, _, names in os.walk(f"{WORK}/man"):
        for name in names:
            path = f"{folder}/{name}"
            lint = call("mandoc", "-T", "lint", path)
            want(lint.returncode == 0 and not lint.stdout, f"{name}: {lint.stdout[:400]}{lint.stderr}")
            pages[name] = re.sub(r".\x08", "", call("mandoc", "-T", "ascii", "-O", "width=900", path).stdout)
    for path, command in every:
        if path[:2] == ("tiltfeed", "desk"):
            path = ("tiltfeed-desk", *path[2:])
        name = "-".join(path[:2] if path[0] == "tiltfeed" else path[:1]) + ".1"
        for option in command["options"]:
            want(option["names"][-1] in pages.get(name, ""), f"{name} lacks {' '.join(path)} {option['names'][-1]}")
        want(" ".join(path) in pages.get(name, "") or len(path) == 1, f"{name} lacks {' '.join(path)}")
    keys = set(re.findall(r"(?m)^ *(?:# |- )?([a-z_0-9]+):(?: |$)", read(f"{ROOT}/config/jobs/example.yaml")))
    want(len(keys) > 60, "the example is not understood")
    for key in keys:
        want(re.search(rf"(?m)(^|[ .]){key}(:|$| )", pages["tiltfeed-job-file.5"]), f"no key {key} in tiltfeed-job-file.5")
    want("heartbeat" in pages["tiltfeed-modbus.7"] and '"op":"submit' in pages["tiltfeed-api.7"], "no protocols")
    want("CYCLE800" in pages["tiltfeed-controls.7"] and "G187" in pages["tiltfeed-controls.7"], "no options of controls")


def check_meaning(every):
    """An option is a flag everywhere, or takes a value everywhere."""
    kinds = {}
    for path, command in every:
        for option in command["options"]:
            if not option["positional"]:
                kinds.setdefault(option["names"][-1], {}).setdefault(bool(option["value"]), " ".join(path))
    for name, kind in kinds.items():
        want(len(kind) == 1, f"{name} is a flag of '{kind.get(False)}' and takes a value of '{kind.get(True)}'")


def check_misspelt():
    desk = () if "tiltfeed-desk" not in PROGRAMS else (
        (["desk", "usr"], "user"), (["desk", "usr", "list"], "user"), (["desk", "--port", "1", "tokne"], "token"), (["desk", "user", "lst"], "list"))
    for words, nearest in (*desk, (["plna"], "plan"), (["plan", "--reprot"], "--report"), (["machine", "jgo"], "jog"),
                           (["machine", "jog", "--lnk=x"], "--link"), (["plan", "a", "--out", "b", "--maschine", "c"], "--machine"),
                           (["verify", "--stok", "box"], "--stock"), (["help", "jobfile"], "job-file")):
        done = call(f"{BIN}/tiltfeed", *words)
        want(done.returncode == 2 and f"the nearest is {nearest}\n" in done.stderr, f"{words}: {done.returncode} {done.stderr}")
    for file in ("usr.yaml", "./usr") if desk else ():
        done = call(f"{BIN}/tiltfeed", "desk", file)
        want(done.returncode == 1 and "nearest" not in done.stderr, f"desk {file}: {done.returncode} {done.stderr}")
    done = call(f"{BIN}/tiltfeed", "list", "much")
    want(done.returncode == 2 and "not understood: much" in done.stderr, f"list much: {done.stderr}")


def check_help():
    text = call(f"{BIN}/tiltfeed", "help", "machine-profile").stdout
    want("tilt.letter: A" in text and max(map(len, text.splitlines())) < 140, "help machine-profile")
    want("--resolution" in call(f"{BIN}/tiltfeed", "help", "verify").stdout, "help verify: not tiltfeed-sim's options")
    want("tiltfeed plan" in call(f"{BIN}/tiltfeed", "help").stdout, "help")


def complete_bash(*words):
    script = f"{WORK}/bash-completion/completions/{words[0]}"
    line = " ".join(f"'{word}'" for word in words)
    done = call("bash", "-uc", f". {script}; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}\n"
                f"_{words[0].replace('-', '_')}; printf '%s\\n' \"${{COMPREPLY[@]}}\"", env={"PATH": f"{WORK}/path:/usr/bin:/bin"})
    want(not done.stderr, f"bash: {words}: {done.stderr}")
    return done.stdout.split()


def check_completion():
    os.makedirs(f"{WORK}/path")
    with open(f"{WORK}/path/tiltfeed", "w", encoding="ascii") as out:
        out.write("#!/bin/sh\necho 'mill at grbl:/dev/ttyUSB0@115200'\necho '     7  ready       a part 12   0 of 9 blocks'\n"
                  "echo '    12  done        8x8   9 of 9 blocks'\n")
    os.chmod(f"{WORK}/path/tiltfeed", 0o755)
    want(complete_bash("tiltfeed", "pl") == ["plan"], "bash: plan")
    want(set(complete_bash("tiltfeed", "plan", "x.yaml", "--re")) == {"--report"}, "bash: --report")
    want("--resolution" in complete_bash("tiltfeed", "verify", "--"), "bash: verify has tiltfeed-sim's options")
    want("home" in complete_bash("tiltfeed", "machine", "ho") and complete_bash("tiltfeed", "machine", "jog", "--l") == ["--link"],
         "bash: machine")
    want(complete_bash("tiltfeed", "start", "1") == ["12"] and set(complete_bash("tiltfeed", "show", "")) >= {"7", "12"},
         f"bash: jobs: {complete_bash('tiltfeed', 'show', '')}")
    want(complete_bash("tiltfeed-sim", "part", "--o") == ["--out"], "bash: tiltfeed-sim")
    for program in PROGRAMS:
        if shutil.which("zsh"):
            done = call("zsh", "-n", f"{WORK}/zsh/vendor-completions/_{program}")
            want(done.returncode == 0, f"zsh: {done.stderr}")
    if shutil.which("fish"):
        script = f"{WORK}/fish/vendor_completions.d/tiltfeed.fish"
        for line, word in (("tiltfeed pl", "plan"), ("tiltfeed machine jog --l", "--link"), ("tiltfeed start 1", "12")):
            done = call("fish", "--no-config", "-c", f"source {script}; complete -C '{line}'",
                        env={"PATH": f"{WORK}/path:/usr/bin:/bin", "HOME": WORK})
            names = [entry.split("\t")[0] for entry in done.stdout.splitlines()]
            want(word in names and not done.stderr, f"fish: {line}: {names} {done.stderr}")


def main():
    shutil.rmtree(WORK, ignore_errors=True)
    os.makedirs(WORK)
    done = call(f"{BIN}/tiltfeed", "write-manual", WORK, "--date", "2026-01-02")
    want(done.returncode == 0, f"write-manual: {done.stderr}")
    every = []
    for program in PROGRAMS:
        every += walk(json.loads(call(f"{BIN}/{program}", "--describe-command-line").stdout), (program,))
    want(len(every) > 45, f"the command lines are not understood: {len(every)}")
    check_pages(every)
    check_meaning(every)
    check_misspelt()
    check_help()
    check_completion()
    for failure in failures[:20]:
        print(f"FAILED: {failure}")
    print(f"manual: {len(every)} commands")
    sys.exit(1 if failures else 0)


main()
