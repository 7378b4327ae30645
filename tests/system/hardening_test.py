#!/usr/bin/python3
"""What the linker and the compiler put into the programs against what comes from outside, read from the ELF.

hardening_test.py PROGRAM... --of FILE...    FILE: the archives and object files that the programs are linked from
"""

import os
import re
import subprocess
import sys


def told(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def missing(program):
    """What is not there, by its name."""
    header, segments = told("readelf", "-hW", program), told("readelf", "-lW", program)
    dynamic, symbols = told("readelf", "-dW", program), told("readelf", "--dyn-syms", "-W", program)
    wanted = {
        "PIE": re.search(r"Type:\s+DYN", header) and "(FLAGS_1)" in dynamic and "PIE" in dynamic,
        "RELRO": "GNU_RELRO" in segments,
        "all symbols bound at the start": re.search(r"FLAGS.*BIND_NOW|FLAGS_1.*NOW", dynamic),
        "a stack without code": re.search(r"GNU_STACK\s.*\sRW\s", segments),
        "no segment to write and run": not re.search(r"LOAD\s.*\sRWE\s", segments),
        "stack protector": "__stack_chk_fail" in symbols,
        "FORTIFY": re.search(r"__\w+_chk(@|\s)", symbols.replace("__stack_chk_fail", "")),
        "no text relocations": "TEXTREL" not in dynamic,
    }
    if "X86-64" in header:  # what the compiler does where a frame is larger than a page
        wanted["stack growth that is checked"] = re.search(r"\sor[lq]\s+\$0x0,\(%rsp\)", told("objdump", "-d", program))
    return [name for name, found in wanted.items() if not found]


def unmarked(file):
    """Object files without the compiler's mark of control-flow protection."""
    if "X86-64" in told("readelf", "-hW", file):
        members = re.split(r"^File: ", told("readelf", "-nW", file), flags=re.M)
        for member in members[1:] or [file + "\n" + members[0]]:
            if not re.search(r"x86 feature:.*IBT.*SHSTK", member):
                yield member.split("\n", 1)[0] + ": without control-flow protection"


def unprotected(files):
    """Folders of archives of which none has the stack protector: a small archive may have nothing to protect."""
    found = {}
    for file in files:
        if file.endswith(".a"):
            folder = os.path.dirname(file)
            found[folder] = found.get(folder, False) or "__stack_chk_fail" in told("nm", "-u", file)
    return [folder + ": without stack protector" for folder, has in found.items() if not has]


def main():
    split = sys.argv.index("--of")
    programs, files = sys.argv[1:split], [file for file in sys.argv[split + 1 :] if file]
    bad = [f"{program}: without {name}" for program in programs for name in missing(program)]
    bad += [line for file in files for line in unmarked(file)] + unprotected(files)
    print("\n".join(bad) if bad else f"{len(programs)} programs and {len(files)} files they are linked from: as wanted")
    sys.exit(1 if bad or not programs or not files else 0)


if __name__ == "__main__":
    main()
