#!/usr/bin/env python3
"""The include arrows.

Between folders: tests -> all; daemon -> config -> pathgen -> kinematics <- sim. sim may also use config and the data
types of pathgen, never the daemon; desk and cad what the daemon may, and nothing uses them; nothing uses tests; only `tiltfeed
plan` and the jobs reach for plan().
Between the rooms of a folder: as the rows tiltfeed_room(NAME USES ...) of its CMakeLists.txt say.
Files of a folder form no circles, header and source counted as one.
A folder's sources open the namespace tiltfeed::FOLDER; kinematics, on which all stand, opens tiltfeed.
In headers no library beside the standard one, tl::expected in kinematics/basics/result.h excepted.
Types and constants of unnamed namespaces have names that no other source of their room uses: they are compiled together.

  arrows_test.py [ROOT]        checks the tree (default: the one this script is in)
  arrows_test.py --self-test   puts each kind of wrong include into a small tree and expects it to be found
"""
import os
import re
import sys
import tempfile

FOLDERS = ("kinematics", "pathgen", "config", "cad", "daemon", "sim", "desk", "tests")
USES = {
    "kinematics": (),
    "pathgen": ("kinematics",),
    "config": ("pathgen", "kinematics"),
    "cad": ("config", "pathgen", "kinematics"),
    "daemon": ("config", "pathgen", "kinematics"),
    "sim": ("config", "kinematics"),
    "desk": ("config", "pathgen", "kinematics"),
    "tests": FOLDERS,
}
PLAN = "pathgen/plan/plan.h"
MAY_PLAN = ("daemon/plan/operation_plan.h", "config/job.h")
# What sim may use of pathgen: data types, and what reads them.
SIM_DATA = ("mesh/mesh.h", "mesh/mesh_check.h", "mesh/stl.h", "options/cutter.h", "plan/plan.h")
LIBRARY_IN_HEADER = ("kinematics/basics/result.h", "tl/expected.hpp")
INCLUDE = re.compile(r'\s*#\s*include\s*(["<])([^">]*)[">]')
NAMESPACE = re.compile(r"namespace (tiltfeed[\w:]*) \{")
TYPE = re.compile(r"(?:struct|class|enum(?: class)?) (\w+)\b[^;]*$")
CONSTANT = re.compile(r"const(?:expr)? [^=;(]*?[ *&](k[A-Z]\w*)")
NEXT_CONSTANT = re.compile(r", (k[A-Z]\w*)(?= ?[={])")
ROW = re.compile(r"^tiltfeed_room\(([^)]*)\)", re.M)


def rooms_of(root, folder):
    """{room: rooms that it may use}, in the order of the rows; none where the folder has no rows."""
    rooms = {}
    with open(f"{root}/{folder}/CMakeLists.txt", encoding="utf-8") as file:
        for row in ROW.findall(file.read()):
            words = row.split()
            uses = []
            if "USES" in words:
                for word in words[words.index("USES") + 1:]:
                    if word in ("LIBRARIES", "SOURCES"):
                        break
                    uses.append(word)
            rooms[words[0]] = uses
    return rooms


def sources(root):
    for folder in FOLDERS:
        for path, _, names in os.walk(f"{root}/{folder}"):
            for name in sorted(names):
                if name.endswith((".h", ".cpp")):
                    yield os.path.relpath(os.path.join(path, name), root)


def room(file):
    parts = file.split("/")
    return parts[1] if len(parts) == 3 else ""


def why_not(file, included, rooms):
    """"" where `file` may include "included", else what is wrong."""
    here, there = file.split("/")[0], included.split("/")[0]
    if here == "tests":
        return "" if there in FOLDERS else "not a path from the root"
    if included == PLAN and here in ("daemon", "config", "desk"):
        return "" if file in MAY_PLAN else "only `tiltfeed plan` plans"
    if here == "sim" and there == "pathgen":
        return "" if included.removeprefix("pathgen/") in SIM_DATA else "sim uses the data types of pathgen only"
    if here != there:
        return "" if there in USES[here] else "daemon -> config -> pathgen -> kinematics <- sim"
    mine, other = room(file), room(included)
    if mine == other or not mine:
        return ""
    return "" if other in rooms[here].get(mine, ()) else f"{here}/CMakeLists.txt: room {mine} does not use {other}"


def circles(graph):
    """The strongly connected components of more than one unit [Tarjan 1972]."""
    index, low, stack, found = {}, {}, [], []

    def visit(unit):
        index[unit] = low[unit] = len(index)
        stack.append(unit)
        for other in sorted(graph.get(unit, ())):
            if other not in index:
                visit(other)
                low[unit] = min(low[unit], low[other])
            elif other in stack:
                low[unit] = min(low[unit], index[other])
        if low[unit] == index[unit]:
            at = stack.index(unit)
            if len(stack) - at > 1:
                found.append(sorted(stack[at:]))
            del stack[at:]

    for unit in sorted(graph):
        if unit not in index:
            visit(unit)
    return found


def namespaces_of(folder, name):
    """Those that sources of a folder may open; tests may open any."""
    if folder == "tests":
        return (name,)
    return ("tiltfeed",) if folder == "kinematics" else (f"tiltfeed::{folder}",)


def local_names(lines):
    """(name, line) of each type and constant of the unnamed namespaces: those that begin at a line's first column."""
    inside = False
    for number, line in enumerate(lines, 1):
        if line.startswith("namespace {"):
            inside = True
        elif line.startswith("}  // namespace"):
            inside = False
        elif inside:
            kind, constant = TYPE.match(line), CONSTANT.match(line)
            if kind:
                yield kind[1], number
            if constant:
                yield from ((name, number) for name in [constant[1], *NEXT_CONSTANT.findall(line)])


def check(root):
    """The complaints about a tree."""
    missing = [folder for folder in FOLDERS if not os.path.isdir(f"{root}/{folder}")]
    if missing:
        return [f"{root}: no folder {', '.join(missing)}"]
    complaints, graph, local = [], {}, {}
    rooms = {folder: rooms_of(root, folder) for folder in FOLDERS}
    for folder, rows in rooms.items():
        seen = []
        for name, uses in rows.items():
            late = [other for other in uses if other not in seen]
            if late:
                complaints.append(f"{folder}/CMakeLists.txt: room {name} uses {', '.join(late)}, which comes later")
            seen.append(name)
    for file in sources(root):
        header, unit = file.endswith(".h"), file.rsplit(".", 1)[0]
        if rooms[file.split("/")[0]] and room(file) and room(file) not in rooms[file.split("/")[0]]:
            complaints.append(f"{file}: its folder has no row tiltfeed_room({room(file)} ...)")
        with open(f"{root}/{file}", encoding="utf-8") as text:
            lines = text.readlines()
            for name, number in local_names(lines) if file.endswith(".cpp") and not file.startswith("tests/") else ():
                other = local.setdefault((os.path.dirname(file), name), file)
                if other != file:
                    complaints.append(f"{file}:{number}: {name} is in {other}, too, and both are compiled together: give it a name of its own")
            for number, line in enumerate(lines, 1):
                opened = NAMESPACE.match(line)
                if opened and opened[1] not in namespaces_of(file.split("/")[0], opened[1]):
                    complaints.append(f"{file}:{number}: opens {opened[1]}, which is not its folder's namespace")
                match = INCLUDE.match(line)
                if not match:
                    continue
                quote, name = match.groups()
                if quote == '"' or name.split("/")[0] in FOLDERS:
                    wrong = why_not(file, name, rooms)
                    if wrong:
                        complaints.append(f'{file}:{number}: may not include "{name}": {wrong}')
                    other = name.rsplit(".", 1)[0]
                    if other != unit and not file.startswith("tests/"):
                        graph.setdefault(unit, set()).add(other)
                elif header and not file.startswith("tests/") and not re.fullmatch(r"[a-z_0-9]+", name):
                    if (file, name) != LIBRARY_IN_HEADER:
                        complaints.append(f"{file}:{number}: a header may not include <{name}>: keep libraries in "
                                          "one .cpp")
    complaints += ["a circle of files: " + ", ".join(circle) for circle in circles(graph)]
    return complaints


GOOD = {
    "kinematics/CMakeLists.txt": "tiltfeed_room(basics)\n",
    "kinematics/basics/result.h": "#include <vector>\n#include <tl/expected.hpp>\n",
    "pathgen/CMakeLists.txt": "tiltfeed_room(mesh\n  SOURCES mesh)\ntiltfeed_room(plan\n  USES mesh\n  SOURCES plan)\n",
    "pathgen/mesh/mesh.h": "",
    "pathgen/mesh/mesh.cpp": '#include "pathgen/mesh/mesh.h"\n#include <CGAL/Surface_mesh.h>\n// #include "daemon/a.h"\n',
    "pathgen/plan/plan.h": '#include "kinematics/basics/result.h"\n#include "pathgen/mesh/mesh.h"\n',
    "config/CMakeLists.txt": "",
    "cad/CMakeLists.txt": "tiltfeed_room(text)\n",
    "cad/text/text.h": '#include "kinematics/basics/result.h"\n',
    "config/job.h": '#include "pathgen/plan/plan.h"\n',
    "daemon/CMakeLists.txt": "tiltfeed_room(post\n  SOURCES block)\ntiltfeed_room(plan\n  USES post\n  SOURCES operation_plan)\ntiltfeed_room(command\n  USES post\n  SOURCES main)\n",
    "daemon/post/block.h": "",
    "daemon/plan/operation_plan.h": '#include "pathgen/plan/plan.h"\n#include "daemon/post/block.h"\n',
    "sim/CMakeLists.txt": "tiltfeed_room(verify\n  SOURCES verify)\n",
    "sim/verify/verify.cpp": '#include "pathgen/mesh/stl.h"\n#include "config/job.h"\n#include <png.h>\n',
    "desk/CMakeLists.txt": "tiltfeed_room(view\n  SOURCES view)\ntiltfeed_room(api\n  USES view\n  SOURCES api)\n",
    "desk/view/view.h": '#include "pathgen/mesh/mesh.h"\n',
    "desk/api/api.cpp": '#include "desk/view/view.h"\n#include "config/job.h"\n#include <microhttpd.h>\n',
    "tests/CMakeLists.txt": "",
    "tests/sim/all_test.cpp": '#include <gtest/gtest.h>\n#include "sim/verify/verify.h"\n',
}
WRONG = """
kinematics/basics/wrong.cpp "pathgen/mesh/mesh.h"
kinematics/basics/wrong.h "sim/verify/verify.h"
pathgen/mesh/wrong.cpp "config/job.h"
pathgen/mesh/wrong.cpp "pathgen/plan/plan.h"
pathgen/plan/wrong.h "daemon/post/block.h"
pathgen/attic/wrong.cpp <vector>
config/wrong.cpp "daemon/post/block.h"
config/wrong.cpp "sim/verify/verify.h"
config/wrong.cpp "pathgen/plan/plan.h"
daemon/post/wrong.cpp "sim/verify/verify.h"
daemon/post/wrong.cpp <sim/verify/verify.h>
daemon/post/wrong.cpp "pathgen/plan/plan.h"
daemon/post/wrong.cpp "daemon/command/main.h"
daemon/post/wrong.cpp "tests/helper.h"
daemon/post/wrong.cpp "desk/view/view.h"
sim/verify/wrong.cpp "desk/view/view.h"
config/wrong.cpp "desk/view/view.h"
config/wrong.cpp "cad/text/text.h"
cad/text/wrong.cpp "daemon/post/block.h"
cad/text/wrong.h <TopoDS.hxx>
desk/api/wrong.cpp "daemon/post/block.h"
desk/api/wrong.cpp "sim/verify/verify.h"
desk/api/wrong.cpp "pathgen/plan/plan.h"
desk/view/wrong.h <microhttpd.h>
sim/verify/wrong.cpp "daemon/post/block.h"
sim/verify/wrong.cpp "pathgen/envelope/envelope.h"
sim/verify/wrong.cpp "../daemon/post/block.h"
sim/verify/wrong.cpp "trace.h"
pathgen/mesh/wrong.h <CGAL/Surface_mesh.h>
daemon/post/wrong.h <modbus.h>
config/wrong.h <yaml-cpp/yaml.h>
daemon/post/wrong.h <tl/expected.hpp>
pathgen/mesh/mesh.h "pathgen/mesh/mesh_circle.h"
""".split("\n")[1:-1]


def put(root, file, text):
    os.makedirs(os.path.dirname(f"{root}/{file}"), exist_ok=True)
    with open(f"{root}/{file}", "w", encoding="utf-8") as out:
        out.write(text)


def self_test():
    failed = []
    with tempfile.TemporaryDirectory() as root:
        if not check(root):
            failed.append("a tree without our folders passed")
        for file, text in GOOD.items():
            put(root, file, text)
        put(root, "pathgen/mesh/mesh_circle.cpp", '#include "pathgen/mesh/mesh.h"\n')
        failed += [f"the good tree was refused: {complaint}" for complaint in check(root)]
        for case in WRONG:
            file, included = case.split()
            put(root, file, f"#include {included}\n")
            if not check(root):
                failed.append(f"{file} with #include {included} was not found")
            if file in GOOD:
                put(root, file, GOOD[file])
            else:
                os.remove(f"{root}/{file}")
        put(root, "pathgen/mesh/names.cpp", "namespace {\nstruct Station {\n};\nconstexpr int kA = 1, kB = 2;\n}  // namespace\nstruct Own {\n};\n")
        for text in ("struct Station {", "constexpr double kA = 3;", "const std::string kB(1, 'b');", "enum class kB {", "constexpr int kC = 1, kA{2};"):
            put(root, "pathgen/mesh/wrong.cpp", f"namespace {{\n{text}\n}}  // namespace\n")
            if not check(root):
                failed.append(f"a second {text} in a room was not found")
        put(root, "pathgen/mesh/wrong.cpp", "namespace {\nstruct Own {\n};\nstruct Station;\n  struct Station {\nconstexpr int kD = kA;\n}  // namespace\n")
        put(root, "pathgen/plan/names.cpp", "namespace {\nstruct Station {\n};\n}  // namespace\n")
        failed += [f"names that meet nowhere were refused: {complaint}" for complaint in check(root)]
        os.remove(f"{root}/pathgen/mesh/wrong.cpp")
        for file, text in (("daemon/post/wrong.h", "namespace tiltfeed {\n"), ("kinematics/basics/wrong.h", "namespace tiltfeed::sim {\n")):
            put(root, file, text)
            if not check(root):
                failed.append(f"{file} with {text.strip()} was not found")
            os.remove(f"{root}/{file}")
        put(root, "pathgen/CMakeLists.txt", "tiltfeed_room(mesh\n  USES plan)\ntiltfeed_room(plan\n  USES mesh)\n")
        if not check(root):
            failed.append("rooms that use each other passed")
    return failed


def main():
    root = os.path.abspath(os.path.dirname(os.path.abspath(__file__)) + "/../..")
    if sys.argv[1:] == ["--self-test"]:
        complaints = self_test()
    else:
        complaints = check(sys.argv[1] if len(sys.argv) > 1 else root)
    print("\n".join(complaints + ([f"arrows: {len(complaints)} complaints"] if complaints else [])))
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
