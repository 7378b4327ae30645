#!/usr/bin/env python3
"""The server of `tiltfeed desk` from outside: what it refuses, what slow and many clients can do, its events.

desk_server_test.py BIN FOLDER
"""
import gzip
import http.client
import json
import os
import re
import select
import shutil
import subprocess
import sys
import time

from desk_client import API, HANG, Desk


def expect(found, wanted, what):
    if found != wanted:
        raise AssertionError(f"{what}: found {found}, expected {wanted}")


def closed_without_reply(sock):
    """The server closes before it has answered."""
    sock.settimeout(HANG)
    return sock.recv(1) == b""


def read_until(sock, text, got=b""):
    while text not in got:
        piece = sock.recv(4096)
        assert piece, f"closed after {got!r}"
        got += piece
    return got


def test_access(desk):
    state = "/api/v1/state"
    expect(desk.ask("GET", state)[0], 401, "before signing in")
    expect(desk.ask("POST", "/api/v1/session", json.dumps({"token": "0" * 64}))[0], 401, "a guessed token")
    expect(desk.ask("POST", "/api/v1/session", "{")[0], 400, "no JSON")
    expect(desk.ask("POST", "/api/v1/session", "[" * 4096)[0], 400, "deep JSON")
    desk.sign_in()
    expect(desk.ask("POST", "/api/v1/session", json.dumps({"token": desk.token}))[0], 401, "the token once more")
    expect(desk.ask("GET", state, **desk.signed)[0], 200, "signed in")
    expect(desk.ask("GET", state, Host="evil.example", **desk.signed)[0], 403, "a rebound name")
    expect(desk.ask("GET", "/", Host="evil.example")[0], 403, "the page by a rebound name")
    head = f"GET {state} HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nOrigin: {desk.origin}\r\nCookie: {desk.signed['Cookie']}\r\nContent-Length: 0\r\n"
    for twice, wanted in (("X: 1", 200), (f"Host: 127.0.0.1:{desk.port}", 400), ("Origin: http://evil.example", 400), ("content-length: 0", 400), ("Cookie: other=1", 400)):
        with desk.connect() as sock:
            sock.sendall(f"{head}{twice}\r\n\r\n".encode())
            expect(int(sock.recv(64).split()[1]), wanted, f"twice: {twice}")
    expect(desk.ask("GET", state, Cookie=desk.signed["Cookie"] + "0")[0], 401, "another cookie")
    unit = json.dumps({"unit": "mm"})
    expect(desk.ask("POST", "/api/v1/part/unit", unit, **desk.signed)[0], 400, "a unit without a part")
    expect(desk.ask("POST", "/api/v1/part/unit", unit, Cookie=desk.signed["Cookie"])[0], 403, "no CSRF secret")
    expect(desk.ask("POST", "/api/v1/part/unit", unit, **{**desk.signed, "Origin": None})[0], 403, "no origin")
    for path in ("/api/v1/nothing", "/api/v2/state", "/api/v1/state/", "/api/v1/../v1/state", "/..%2f..%2fetc/passwd", "/page.html"):
        expect(desk.ask("GET", path, **desk.signed)[0], 404, path)


def test_headers(desk):
    for path in ("/", "/page.js", "/page.css", "/icon.svg"):
        status, headers, plain = desk.ask("GET", path)
        expect(status, 200, path)
        policy = headers["Content-Security-Policy"]
        for part in ("default-src 'none'", "script-src 'self'", "frame-ancestors 'none'", "base-uri 'none'"):
            assert part in policy, policy
        assert "unsafe" not in policy and "*" not in policy, policy
        expect(headers["X-Content-Type-Options"], "nosniff", path)
        _, packed_headers, packed = desk.ask("GET", path, Accept_Encoding="gzip")
        expect(packed_headers["Content-Encoding"], "gzip", path)
        expect(gzip.decompress(packed) == plain, True, f"{path}: the same bytes, packed and plain")
        expect(desk.ask("GET", path, If_None_Match=headers["ETag"])[0], 304, path)


def test_uploads(desk, part):
    over = 512 * 1024 * 1024 + 1
    for method, path, length in (("PUT", "/api/v1/part", over), ("POST", "/api/v1/part/unit", 4097), ("GET", "/api/v1/state", 1)):
        with desk.connect() as sock:
            head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nOrigin: {desk.origin}\r\nContent-Type: application/octet-stream\r\n"
            head += f"Cookie: {desk.signed['Cookie']}\r\nX-Tiltfeed-Csrf: {desk.signed['X_Tiltfeed_Csrf']}\r\nContent-Length: {length}\r\n\r\n"
            sock.sendall(head.encode())
            expect(read_until(sock, b"\r\n").split()[1], b"413", f"{method} {path} of {length} bytes, refused before one is sent")
    with desk.connect() as sock:
        sock.sendall(f"PUT /api/v1/part HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nTransfer-Encoding: chunked\r\n\r\n".encode())
        expect(read_until(sock, b"\r\n").split()[1], b"411", "chunks")
    with open(part, "rb") as file:
        bytes_of_part = file.read()
    upload = {**desk.signed, "Content_Type": "application/octet-stream"}
    status, _, body = desk.ask("PUT", "/api/v1/part?name=../../a/pin.stl&unit=mm", bytes_of_part, **upload)
    expect(status, 202, body)
    while json.loads(body)["state"] == "reading":
        body = json.dumps(json.loads(desk.ask("GET", "/api/v1/state", **desk.signed)[2])["part"])
    about = json.loads(body)
    expect((about["name"], about["state"]), ("pin.stl", "ready"), "the part")
    status, headers, mesh = desk.ask("GET", "/api/v1/part/mesh", **desk.signed)
    expect((status, headers["Content-Type"], len(mesh)), (200, "application/octet-stream", about["facets"] * 36), "its mesh")
    # The corners are those of the file, bit by bit.
    facets = bytes_of_part[84:]
    expect(mesh == b"".join(facets[i + 12:i + 48] for i in range(0, len(facets), 50)), True, "the mesh is the file's")
    expect(desk.ask("PUT", "/api/v1/part", b"", **upload)[0], 400, "an empty file")
    expect(desk.ask("PUT", "/api/v1/part?unit=furlong", bytes_of_part, **upload)[0], 400, "an unknown unit")


def events(desk, last=None):
    sock = desk.connect()
    more = f"Last-Event-ID: {last}\r\n" if last is not None else ""
    sock.sendall(f"GET /api/v1/events HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nCookie: {desk.signed['Cookie']}\r\n{more}\r\n".encode())
    return sock


def test_events(desk):
    streams = [events(desk) for _ in range(30)]
    heads = [read_until(sock, b"\r\n\r\n") for sock in streams]
    assert all(b"text/event-stream" in head for head in heads)
    desk.ask("POST", "/api/v1/part/unit", json.dumps({"unit": "inch"}), **desk.signed)
    for sock in streams:
        got = read_until(sock, b'"state":"ready"')
        assert b"event: part" in got, got
    last = max(int(number) for number in re.findall(rb"id: (\d+)", got))
    for sock in streams:
        sock.close()
    with events(desk, last - 1) as sock:
        assert f"id: {last}\n".encode() in read_until(sock, b'"state":"ready"'), "the event after the last one that was heard"


def test_many(desk):
    """More connections than one address may have: the others are served again when those have gone."""
    crowd = []
    for _ in range(60):
        crowd.append(desk.connect())
    closed = [sock for sock in crowd if select.select([sock], [], [], 0)[0]]
    for sock in crowd:
        sock.close()
    deadline = time.monotonic() + HANG
    while True:
        try:
            if desk.ask("GET", "/api/v1/state", **desk.signed)[0] == 200:
                break
        except (ConnectionError, http.client.HTTPException):
            assert time.monotonic() < deadline, f"not served after {len(closed)} of 60 were closed"


def test_silent_crowd(desk):
    """Connections that are opened again and again, and say nothing: who is signed in is served beside them."""
    crowd, tries = [], 0
    for _ in range(20):
        crowd += [desk.connect() for _ in range(20)]
        for attempt in range(20):
            try:
                expect(desk.ask("GET", "/api/v1/state", **desk.signed)[0], 200, "beside a silent crowd")
                break
            except (ConnectionError, http.client.HTTPException):
                assert attempt < 19, f"not served beside {len(crowd)} silent connections"
                tries += 1
    print(f"20 requests beside {len(crowd)} silent connections: {tries} had to be repeated")
    for sock in crowd:
        sock.close()


def test_half_heads(desk):
    """Many begin a request at once and do not end it: 20 of them stay, and who is signed in is served."""
    crowd = []
    for _ in range(60):
        crowd.append(desk.connect())
        try:
            crowd[-1].sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nX-Slow: ".encode())
        except ConnectionError:
            pass
    there = crowd
    while len(there) > 20:
        there = [sock for sock in there if not select.select([sock], [], [], 0.01)[0]]
    assert there, "all of them stay until they are closed for their age"
    expect(desk.ask("GET", "/api/v1/state", **desk.signed)[0], 200, "beside half heads")
    for sock in crowd:
        sock.close()


def test_upload_in_a_crowd(desk):
    """A body that comes slowly on a connection of its own, as curl sends it: silent connections do not end it."""
    with desk.connect() as sock:
        sock.sendall((f"POST /api/v1/seat/beat HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nOrigin: {desk.origin}\r\nContent-Type: application/json\r\n"
                      f"Cookie: {desk.signed['Cookie']}\r\nX-Tiltfeed-Csrf: {desk.signed['X_Tiltfeed_Csrf']}\r\nContent-Length: 2\r\n\r\n").encode())
        expect(desk.ask("GET", "/api/v1/state", **desk.signed)[0], 200, "its head was read")
        crowd = [desk.connect() for _ in range(30)]
        expect(desk.ask("GET", "/api/v1/state", **desk.signed)[0], 200, "beside an upload")
        sock.sendall(b"{}")
        answer = sock.recv(4096)
        assert answer.startswith(b"HTTP/1.1 "), f"an upload beside silent connections: {answer[:100]}"
    for silent in crowd:
        silent.close()


def test_slow(desk):
    """A head, and a body, that arrive byte by byte: closed by the server, while others are served."""
    head = f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nX-Slow: ".encode()
    body = (f"POST /api/v1/part/unit HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\nOrigin: {desk.origin}\r\nContent-Type: application/json\r\n"
            f"Cookie: {desk.signed['Cookie']}\r\nX-Tiltfeed-Csrf: {desk.signed['X_Tiltfeed_Csrf']}\r\nContent-Length: 4000\r\n\r\n").encode()
    slow = [desk.connect(), desk.connect()]
    slow[0].sendall(head)
    slow[1].sendall(body)
    begun, ended = time.monotonic(), 0
    while slow:
        expect(desk.ask("GET", "/api/v1/state", **desk.signed)[0], 200, "beside slow clients")
        for sock in list(slow):
            try:
                sock.sendall(b" ")
                gone = select.select([sock], [], [], 0.2)[0] and sock.recv(100) == b""
            except ConnectionError:
                gone = True
            if gone:
                slow.remove(sock)
                ended = time.monotonic()
        assert time.monotonic() < begun + HANG, "a client that sends a byte now and then is never closed"
    print(f"slow clients closed after {ended - begun:.1f} s")


def pin_job(folder, part):
    """The job of config/jobs for this part, with wide rows."""
    root = os.path.dirname(os.path.abspath(__file__)) + "/../.."
    with open(f"{root}/config/jobs/pin.yaml", encoding="utf-8") as file:
        text = file.read()
    text = text.replace("../machines/", f"{root}/config/machines/").replace("side_step_mm: 0.5", "side_step_mm: 4")
    with open(f"{folder}/pin.yaml", "w", encoding="utf-8") as file:
        file.write(re.sub("stl: .*", f"stl: {part}", text))
    return f"{folder}/pin.yaml"


def operations_job(folder, part):
    """That of config/jobs with several operations."""
    root = os.path.dirname(os.path.abspath(__file__)) + "/../.."
    with open(f"{root}/config/jobs/pin_operations.yaml", encoding="utf-8") as file:
        text = file.read().replace("../machines/", f"{root}/config/machines/")
    for step, wide in (("1.5}", "4}"), ("0.5}", "4}"), ("0.3}", "4}")):
        text = text.replace(f"side_step_mm: {step}", f"side_step_mm: {wide}")
    with open(f"{folder}/operations.yaml", "w", encoding="utf-8") as file:
        file.write(re.sub("stl: .*", f"stl: {part}", text))
    return f"{folder}/operations.yaml"


def until(desk, what, states):
    while (told := desk.get("state")[what])["state"] in states:
        time.sleep(0.05)
    return told


def test_operations(binaries, folder, part):
    """Operations by the API: listed, changed, planned alone and together, cut one after the other."""
    desk = Desk(binaries, operations_job(folder, part))
    names = ["semi-finish", "finish", "middle once more"]
    try:
        desk.sign_in()
        until(desk, "part", ("reading",))
        expect([one["name"] for one in desk.get("state")["job"]["operations"]], names, "listed")
        expect(desk.get("schema?operation=2")["form"]["name"], "finish", "the keys of the second")
        for path, status in (("schema?operation=4", 409), ("schema?operation=x", 400)):
            expect(desk.ask("GET", f"/api/v1/{path}", **desk.signed)[0], status, path)
        for body, status in (({"do": "move", "number": 3, "to": 1}, 200), ({"do": "move", "number": 1, "to": 3}, 200), ({"do": "copy", "number": 1, "name": "more"}, 200),
                             ({"do": "copy", "number": 1, "name": "more"}, 409), ({"do": "remove", "number": 2}, 200), ({"do": "remove", "number": 9}, 400),
                             ({"do": "own", "number": 2, "section": "cutter"}, 200), ({"do": "share", "number": 2, "section": "cutter"}, 200),
                             ({"do": "own", "number": 2, "section": "machine"}, 409), ({"do": "turn", "number": 2}, 400), ({"number": 2}, 400)):
            got, answer = desk.post("job/operation", **body)
            expect(got, status, f"{body}: {answer}")
        job = desk.get("state")["job"]
        expect(([one["name"] for one in job["operations"]], job["errors"]), (names, []), "as at first")
        expect(desk.post("plan", operation="nobody")[0], 409, "no such operation")
        expect(desk.post("plan", optimise="wealth")[0], 400, "no such aim")
        for operation in ("finish", None):
            expect(desk.post("plan", **({"operation": operation} if operation else {}))[0], 202, "planning")
            plan = until(desk, "plan", ("planning",))
            expect((plan["state"], plan.get("operation")), ("planned", operation), f"planned: {plan}")
            report = desk.get("plan/report")
            expect([one["name"] for one in report["operations"]], [operation] if operation else names, "in the report")
            path = desk.ask("GET", "/api/v1/plan/path", **desk.signed)[2]
            expect(len(path), 56 * sum(one["blocks"] for one in report["operations"]), "a record for each block of each")
        expect(desk.post("cut")[0], 202, "cutting")
        cut = until(desk, "cut", ("working",))
        expect([one["name"] for one in cut["operations"]], names, f"cut: {cut}")
        reports = [desk.get(f"cut/report?operation={name.replace(' ', '%20')}") for name in names]
        expect([report["operation"] for report in reports], names, "reports")
        for before, after in zip(reports, reports[1:]):
            assert abs(before["left_mm3"] - after["stock_mm3"]) < 1e-3 * before["left_mm3"], "the stock is not carried on"
        expect(desk.ask("GET", "/api/v1/cut/view?operation=nobody", **desk.signed)[0], 409, "a view of no operation")
        expect(desk.stop(), 0, "the end")
    finally:
        desk.process.kill()


def test_openapi(desk):
    """The description, the page about the API and the server's own tables name the same requests."""
    root = os.path.dirname(os.path.abspath(__file__)) + "/../../desk/"
    status, _, served = desk.ask("GET", "/openapi.json")
    expect((status, json.loads(served)), (200, API.page), "the description is served, to everybody")
    described = {(method.upper(), path[1:]) for path, operations in API.page["paths"].items() for method in operations}
    answered = set()
    for name, prefix in (("api/desk.cpp", "/api/v1/"), ("api/run_api.cpp", "")):
        with open(root + name, encoding="utf-8") as file:
            answered |= set(re.findall(r'{"(GET|POST|PUT|DELETE)", "' + prefix + r'([a-z/]+)", &', file.read()))
    told = set()
    with open(root + "API.md", encoding="utf-8") as file:
        for first in re.findall(r"^\| (`(?:GET|POST|PUT|DELETE) [^|]*) \|", file.read(), re.MULTILINE):
            method, *paths = re.findall(r"GET|POST|PUT|DELETE|(?<=[`/ ])[a-z/]+(?=[`?])", first)
            told |= {(method, path) for path in paths}
    expect(sorted(answered ^ described), [], "requests of the server and of openapi.json")
    expect(sorted(told ^ described), [], "requests of API.md and of openapi.json")
    for method, path in sorted(described - {("GET", "events"), ("DELETE", "session"), ("POST", "session")}):
        status, _, body = desk.ask(method, f"/api/v1/{path}", b"{}" if method in ("POST", "PUT") else None, **desk.signed)
        assert status != 404 or path == "run/part", (method, path, body)


def test_api_page(binaries, folder, part, *job):
    """The examples of desk/API.md, as they stand there, in one shell; with a job, or without."""
    page = os.path.dirname(os.path.abspath(__file__)) + "/../../desk/API.md"
    with open(page, encoding="utf-8") as file:
        examples = re.findall(r"```sh\n(.*?)```", file.read(), re.S)
    assert len(examples) >= 6, examples
    work = f"{folder}/api{len(job)}"
    os.makedirs(work)
    shutil.copy(part, f"{work}/part.stl")
    desk = Desk(binaries, *job)
    try:
        script = "set -eu -o pipefail\n" + "\n".join(examples)
        done = subprocess.run(["bash", "-c", script], cwd=work, env={**os.environ, "ADDRESS": desk.address},
                              capture_output=True, text=True, timeout=HANG, check=False)
        expect((done.returncode, done.stderr), (0, ""), f"the examples: {done.stdout[-2000:]}")
        assert os.path.getsize(f"{work}/mesh.f32") > 0
        if job:
            assert os.path.getsize(f"{work}/part.nc") > 0
            expect(os.path.getsize(f"{work}/path.f32") % 56, 0, "the path's bytes, in records of 14 numbers")
        expect(desk.stop(), 0, "the end")
    finally:
        desk.process.kill()


def main():
    binaries, folder = sys.argv[1:3]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    part = f"{folder}/pin.stl"
    subprocess.run([f"{binaries}/tiltfeed-sim", "part", "pin", "--out", part], check=True, stdout=subprocess.DEVNULL)
    os.environ["TMPDIR"] = folder
    desk = Desk(binaries)
    try:
        test_access(desk)
        test_headers(desk)
        test_uploads(desk, part)
        test_events(desk)
        test_many(desk)
        test_slow(desk)
        listener = events(desk)
        read_until(listener, b"\r\n\r\n")
        expect(desk.stop(), 0, "the end, with a listener that waits")
    finally:
        desk.process.kill()
    expect([name for name in os.listdir(folder) if name.startswith("tiltfeed-desk")], [], "what is left in the folder")
    taken = Desk(binaries, part)
    refused = subprocess.run([f"{binaries}/tiltfeed", "desk", "--port", str(taken.port)], capture_output=True, text=True, check=False)
    expect((refused.returncode, f"127.0.0.1:{taken.port}: " in refused.stderr), (1, True), f"a port that is taken: {refused.stderr}")
    taken.sign_in()
    test_half_heads(taken)
    test_upload_in_a_crowd(taken)
    test_silent_crowd(taken)
    expect(json.loads(taken.ask("GET", "/api/v1/state", **taken.signed)[2])["part"]["name"], "pin.stl", "the part of the command line")
    test_openapi(taken)
    expect(taken.stop(), 0, "the end")
    test_operations(binaries, folder, part)
    test_api_page(binaries, folder, part)
    test_api_page(binaries, folder, part, pin_job(folder, part))
    print("desk_server_test: all passed")


try:
    main()
finally:
    Desk.kill_all()
