#!/usr/bin/env python3
"""The documents hold together.

Every room of a folder's CMakeLists.txt has a README. Every link of a Markdown file leads to a file.
An equation's tag, (K1) or (ME1), is defined in one README only, its letters stand in GLOSSARY.md, and every tag that
a comment names stands in a README. An option that a message or a folder's README names is one that some command has.

  documents_test.py [ROOT]        checks the tree (default: the one this script is in)
  documents_test.py --self-test   puts each kind of mistake into a small tree and expects it to be found
"""
import os
import re
import sys
import tempfile

FOLDERS = ("kinematics", "pathgen", "config", "cad", "daemon", "sim", "desk")
SKIPPED = ("build", "node_modules", ".git")
ROW = re.compile(r"^tiltfeed_room\((\w+)", re.M)
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
# A tag is defined where it opens a paragraph in bold, an entry of a list, a formula, or a row of a table.
DEFINITION = re.compile(r"^(?:\*\*|\* |    |\| )\(([A-Z]{1,2}\d*)\)", re.M)
TAG = re.compile(r"\(([A-Z]{1,2}\d)\)")
GLOSSARY_TAG = re.compile(r"\(([A-Z]{1,2})\d*\)")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*[a-z0-9]\b(?!-)")
OFFERED = re.compile(r'add_(?:option|flag)\w*\(\s*"([^"]*)"|"(--[a-z][a-z0-9-]*)"')
STRING = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
# Of the option parser, systemctl, journalctl, npm, cmake and GoogleTest.
OTHERS = {"--help", "--version", "--now", "--reload", "--lines", "--output", "--no-pager", "--offline", "--ignore-scripts", "--build",
          "--target", "--install", "--gtest"}


def files(root, endings):
    for path, folders, names in os.walk(root):
        folders[:] = sorted(name for name in folders if name not in SKIPPED)
        for name in sorted(names):
            if name.endswith(endings):
                yield os.path.relpath(os.path.join(path, name), root)


def read(root, file):
    with open(f"{root}/{file}", encoding="utf-8") as text:
        return text.read()


def comments(file, text):
    """What a source says in comments: G-code such as (M0) stands in its strings."""
    return text if file.endswith(".md") else "\n".join(re.findall(r"//.*", text))


def unknown_options(root):
    """Options that messages of our programs and READMEs name, and that no command has."""
    sources = {file: read(root, file) for file in files(root, (".cpp", ".py", ".sh", ".mjs"))}
    sources["run"] = read(root, "run") if os.path.exists(f"{root}/run") else ""
    offered = set(OTHERS)
    for file, text in sources.items():
        if file.endswith(".cpp") and not file.startswith("tests/"):
            offered.update(option for names in OFFERED.findall(text) for option in OPTION.findall(" ".join(names)))
    ours = {file: "\n".join(STRING.findall(text)) for file, text in sources.items()
            if file.endswith(".cpp") and file.split("/")[0] in FOLDERS}
    for file, text in ours.items():
        yield from ((file, option) for option in sorted(set(OPTION.findall(text)) - offered))
    for file, text in sources.items():
        if not file.endswith(".cpp") and "documents_test" not in file:
            offered.update(OPTION.findall(text))
    for file in files(root, ".md"):
        if file.split("/")[0] in FOLDERS:
            prose = re.sub(r"^```.*?^```", "", read(root, file), flags=re.MULTILINE | re.DOTALL)
            named = OPTION.findall("\n".join(re.findall(r"`([^`\n]*)`", prose)))
            yield from ((file, option) for option in sorted(set(named) - offered))


def check(root):
    """The complaints about a tree."""
    complaints, defined, known = [], {}, set()
    for folder in FOLDERS:
        rows = f"{folder}/CMakeLists.txt"
        for room in ROW.findall(read(root, rows)) if os.path.exists(f"{root}/{rows}") else ():
            if not os.path.exists(f"{root}/{folder}/{room}/README.md"):
                complaints.append(f"{rows}: room {room} has no README.md")
    letters = set(GLOSSARY_TAG.findall(read(root, "GLOSSARY.md")))
    for file in files(root, ".md"):
        text = read(root, file)
        for target in LINK.findall(text):
            if "://" not in target and not os.path.exists(os.path.join(root, os.path.dirname(file), target)):
                complaints.append(f"{file}: links to {target}, which is not there")
        if not file.endswith("/README.md") or file.split("/")[0] not in FOLDERS:
            continue
        known.update(TAG.findall(text))
        for tag in sorted(DEFINITION.findall(text)):
            if tag in defined:
                complaints.append(f"{file}: defines ({tag}), as {defined[tag]} does")
            if tag.rstrip("0123456789") not in letters:
                complaints.append(f"{file}: GLOSSARY.md has no row for ({tag})")
            defined[tag] = file
    for file in files(root, (".h", ".cpp")):
        for tag in TAG.findall(comments(file, read(root, file))):
            if tag[:-1] in letters and tag not in known and not re.match(r"[GM]\d", tag):
                complaints.append(f"{file}: ({tag}) stands in no README")
    return complaints + [f"{file}: names {option}, which no command has" for file, option in unknown_options(root)]


GOOD = {
    "GLOSSARY.md": "| (K1) to (K3) | [machine](kinematics/machine/README.md) |\n",
    "kinematics/CMakeLists.txt": "tiltfeed_room(machine\n  SOURCES chain)\n",
    "kinematics/machine/README.md": "**(K1)** one\n\n* (K2) two, by (K1)\n\n    (K3) x = y\n",
    "kinematics/machine/chain.cpp": '// By (K1).\nauto line = "(K9)";  // stop (M0)\n',
    "daemon/command/main.cpp": 'app.add_option("-s,--short", "as --short 3, --help");\n',
    "daemon/command/README.md": "`--short 3`, and a state --ready--> next\n",
}
WRONG = (
    ("kinematics/CMakeLists.txt", "tiltfeed_room(machine\n  SOURCES chain)\ntiltfeed_room(attic)\n", "attic"),
    ("README.md", "[house](house/README.md)", "house/README.md"),
    ("sim/motion/README.md", "**(K1)** again", "(K1)"),
    ("sim/motion/README.md", "**(Q1)** not in the glossary", "(Q1)"),
    ("kinematics/machine/chain.h", "/// (K7)", "(K7)"),
    ("daemon/command/text.cpp", 'say("give another --long 50");', "--long"),
    ("daemon/command/README.md", "With `--long 50` it is longer", "--long"),
)


def put(root, file, text):
    os.makedirs(os.path.dirname(f"{root}/{file}") or root, exist_ok=True)
    with open(f"{root}/{file}", "w", encoding="utf-8") as out:
        out.write(text)


def self_test():
    failed = []
    for case in (None,) + WRONG:
        with tempfile.TemporaryDirectory() as root:
            for file, text in GOOD.items():
                put(root, file, text)
            if case:
                put(root, case[0], case[1])
            complaints = check(root)
            if not case:
                failed += [f"the good tree was refused: {complaint}" for complaint in complaints]
            elif len(complaints) != 1 or case[2] not in complaints[0]:
                failed.append(f"{case[0]} with {case[1]!r}: {complaints}")
    return failed


def main():
    root = os.path.abspath(os.path.dirname(os.path.abspath(__file__)) + "/../..")
    if sys.argv[1:] == ["--self-test"]:
        complaints = self_test()
    else:
        complaints = check(sys.argv[1] if len(sys.argv) > 1 else root)
    print("\n".join(complaints + ([f"documents: {len(complaints)} complaints"] if complaints else [])))
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
