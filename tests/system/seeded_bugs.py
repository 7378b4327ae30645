#!/usr/bin/python3
"""Puts each bug of a table into today's sources and expects the tests named beside it to fail. The sources stay as they are: a
copy of the file with the bug is compiled, and linked before the library that has the sound one. A file is found by its name
wherever it is; where two have it, the folder stands before it.

seeded_bugs.py BUILD_FOLDER [--only WORD]      the build folder has what `cmake --build` made of all tests
seeded_bugs.py --tests                         the tests that it needs, one a line
"""

import argparse
import concurrent.futures
import glob
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
TABLE = os.path.join(HERE, "seeded_bugs.toml")
PATIENCE = 1800  # seconds for one test: a hang and no measure of speed


class Unfit(Exception):
    """The table does not fit the sources any more."""


def bugs():
    with open(TABLE, "rb") as file:
        return tomllib.load(file)["bug"]


def program_of(test):
    return shlex.split(test)[0]


def seeded(text, change):
    """The text with the bug; spaces and line ends may differ."""
    found = list(re.finditer(r"\s+".join(re.escape(word) for word in change["was"].split()), text))
    if len(found) != 1:
        raise Unfit(f"{change['file']}: found {len(found)} times, not once: {change['was'].strip()}")
    return text[: found[0].start()] + change["is"] + text[found[0].end() :]


class Build:
    """What ninja knows of a build."""

    def __init__(self, folder):
        self.folder = os.path.abspath(folder)
        self.compiles = {}
        for entry in json.loads(self.ninja("compdb")):
            if entry["output"].endswith(".o"):
                self.compiles.setdefault(os.path.basename(entry["file"]), []).append(entry)

    def ninja(self, *words):
        return subprocess.run(["ninja", "-C", self.folder, "-t", *words], capture_output=True, text=True, check=True).stdout

    def shell(self, command, log):
        with open(log, "a", encoding="utf-8") as file:
            file.write(command + "\n")
            file.flush()
            return subprocess.run(command, shell=True, cwd=self.folder, stdout=file, stderr=file, check=False).returncode

    def compile(self, name, changes, work, log):
        """The object file of a source with its changes."""
        base = os.path.basename(name)
        entries = [e for e in self.compiles.get(base, []) if e["file"].endswith("/" + name) and "/tests/" not in e["file"]]
        if len(entries) != 1:
            raise Unfit(f"{name}: {len(entries)} sources have this name")
        with open(entries[0]["file"], encoding="utf-8") as file:
            text = file.read()
        for change in changes:
            text = seeded(text, change)
        source, to = os.path.join(work, base), os.path.join(work, base + ".o")
        with open(source, "w", encoding="utf-8") as file:
            file.write(text)
        words = shlex.split(entries[0]["command"])
        for option, value in (("-o", to), ("-MF", to + ".d"), ("-MT", to), ("-c", source)):
            words[words.index(option) + 1] = value
        if self.shell(shlex.join(words), log) != 0:
            raise Unfit(f"{name}: does not compile with the bug; {log}")
        return to

    def link(self, test, objects, work, log):
        """The program that has this file of tests, with these objects before all libraries."""
        command = self.ninja("commands", test).rstrip("\n").split("\n")[-1]
        begin, output = re.search(r"\S+\.o\s", command), re.search(r" -o bin/(\S+) ", command)
        if not begin or not output:
            raise Unfit(f"{test}: is linked in a way that is not known here")
        to = os.path.join(work, output[1])
        command = command[: begin.start()] + shlex.join(objects) + " " + command[begin.start() :]
        if self.shell(command.replace(output[0], f" -o {shlex.quote(to)} "), log) != 0:
            raise Unfit(f"{test}: cannot be linked with the bug; {log}")
        return to


def suites_of(test):
    """The option that takes the tests of this file from a program that has others, too."""
    (source,) = glob.glob(os.path.join(os.path.dirname(HERE), "*", test + ".cpp"))
    with open(source, encoding="utf-8") as file:
        suites = set(re.findall(r"^(?:TYPED_)?TEST(?:_[PF])?\((\w+),", file.read(), re.M))
    return "--gtest_filter=" + ":".join(pattern for suite in sorted(suites) for pattern in (suite + ".*", "*/" + suite + "*.*"))


def run(build, number, bug):
    """(what each test said, seconds). Every test that is named must fail."""
    begun = time.monotonic()
    work = os.path.join(build.folder, "seeded", f"{number:02}")
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    log = os.path.join(work, "log")
    files = sorted({change["file"] for change in bug["change"]})
    objects = [build.compile(name, [c for c in bug["change"] if c["file"] == name], work, log) for name in files]
    said = []
    for test in bug["tests"]:
        name, *options = shlex.split(test)
        # The first expectation that is not met is enough.
        words = [build.link(name, objects, work, log), *(options or [suites_of(name)]), "--gtest_break_on_failure"]
        try:
            ended = subprocess.run(words, cwd=work, capture_output=True, text=True, errors="replace", timeout=PATIENCE, check=False)
            began = re.findall(r"^\[ RUN      \] (\S+)", ended.stdout, re.M)
            said.append((ended.returncode != 0, began[-1] if began else f"status {ended.returncode}"))
            with open(log, "a", encoding="utf-8") as file:
                file.write(ended.stdout + ended.stderr)
        except subprocess.TimeoutExpired:
            said.append((False, "hangs"))
        os.remove(words[0])
    return said, time.monotonic() - begun


def outcome(build, number, bug):
    try:
        said, seconds = run(build, number, bug)
    except Unfit as unfit:
        return False, f"  {number:2} {bug['name']}\n     DOES NOT FIT: {unfit}"
    caught = all(red for red, _ in said)
    lines = [f"     {'caught by' if red else 'NOT CAUGHT by'} {test}: {what}" for test, (red, what) in zip(bug["tests"], said)]
    return caught, f"  {number:2} {bug['name']} ({seconds:.1f} s)\n" + "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?")
    parser.add_argument("--only", default="")
    parser.add_argument("--tests", action="store_true")
    options = parser.parse_args()
    table = bugs()
    if options.tests:
        print("\n".join(sorted({program_of(test) for bug in table for test in bug["tests"]})))
        return 0
    if options.build is None:
        parser.error("a build folder is missing")
    build = Build(options.build)
    chosen = [(number, bug) for number, bug in enumerate(table, 1) if options.only in bug["name"]]
    caught = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for good, text in pool.map(lambda one: outcome(build, *one), chosen):
            caught += good
            print(text, flush=True)
    print(f"{caught} of {len(chosen)} seeded bugs caught by every test named for them")
    return 0 if caught == len(chosen) and chosen else 1


if __name__ == "__main__":
    sys.exit(main())
