#!/usr/bin/python3
"""What the linker and the compiler put into the programs against what comes from outside, read from the ELF.

hardening_test.py PROGRAM... [--linked PROGRAM...]    of the latter only what the linker does
"""

import re
import subprocess
import sys


def told(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


COMPILED = ("stack protector", "FORTIFY")


def missing(program, linked):
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
    return [name for name, found in wanted.items() if not found and not (linked and name in COMPILED)]


def main():
    split = sys.argv.index("--linked") if "--linked" in sys.argv else len(sys.argv)
    programs = [(program, False) for program in sys.argv[1:split]] + [(program, True) for program in sys.argv[split + 1 :]]
    bad = [f"{program}: without {name}" for program, linked in programs for name in missing(program, linked)]
    print("\n".join(bad) if bad else f"{len(programs)} programs: as wanted")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
