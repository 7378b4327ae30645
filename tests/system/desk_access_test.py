#!/usr/bin/python3
"""The page on a network: users by name and password, roles, TLS, the names it is known by, cookies.

desk_access_test.py BIN_FOLDER WORK_FOLDER
"""

import http.client
import json
import os
import re
import shutil
import ssl
import subprocess
import sys

HANG = 300  # seconds: no measure of speed
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PASSWORDS = {"ann": "the secret of ann", "bob": "the secret of bob"}


class Client:
    def __init__(self, port):
        self.port, self.origin = port, f"https://localhost:{port}"
        self.headers = {"Origin": self.origin, "Content-Type": "application/json"}

    def ask(self, method, path, body=None, **headers):
        connection = http.client.HTTPSConnection("127.0.0.1", self.port, timeout=HANG, context=ssl._create_unverified_context())
        sent = {"Host": f"localhost:{self.port}", **self.headers, **headers}
        connection.request(method, "/api/v1/" + path, json.dumps(body) if body is not None else None, sent)
        reply = connection.getresponse()
        return reply.status, reply.headers, json.loads(reply.read())

    def sign_in(self, name, password):
        status, headers, body = self.ask("POST", "session", {"name": name, "password": password})
        if status == 200:
            cookie = headers["Set-Cookie"]
            for part in ("__Host-tiltfeed-", "; Secure", "; HttpOnly", "; SameSite=Strict", "; Path=/"):
                assert part in cookie, cookie
            self.headers.update({"Cookie": cookie.split(";")[0], "X-Tiltfeed-Csrf": body["csrf"]})
        return status


def want(found, wanted, what):
    if found != wanted:
        raise AssertionError(f"{what}: found {found}, expected {wanted}")


def user(binaries, *words, typed=""):
    done = subprocess.run([f"{binaries}/tiltfeed", "desk", "user", *words], input=typed, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def users(binaries, file):
    for name, role in (("ann", "operate"), ("bob", "watch"), ("eve", "watch")):
        want(user(binaries, "add", name, "--role", role, "--users", file, typed=PASSWORDS.get(name, "some other one") + "\n")[0], 0, name)
    want(user(binaries, "list", "--users", file), (0, "ann operate\nbob watch\neve watch\n"), "the list")
    want(user(binaries, "remove", "eve", "--users", file)[0], 0, "removed")
    want(user(binaries, "remove", "eve", "--users", file)[0], 2, "removed twice")
    want(user(binaries, "add", "zoe", "--role", "watch", "--users", file, typed="short\n")[0], 2, "a short password")
    want(user(binaries, "add", "zoe", "--role", "admin", "--users", file, typed="a long one here\n")[0], 2, "a role")
    with open(file, encoding="ascii") as text:
        written = text.read()
    want(re.findall(r"^(\w+):(\w+):\$y\$", written, re.MULTILINE), [("ann", "operate"), ("bob", "watch")], "the file")
    assert not any(password in written for password in PASSWORDS.values())
    want(os.stat(file).st_mode & 0o007, 0, "readable by others")


def behind_proxy(ann):
    """All browsers come from the proxy's address, which keeps their connections: more than one address may have."""
    kept = []

    def ask(method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", ann.port, timeout=HANG)
        connection.request(method, "/api/v1/" + path, body and json.dumps(body), {"Host": f"localhost:{ann.port}", **ann.headers})
        reply = connection.getresponse()
        kept.append(connection)
        return reply, json.loads(reply.read())

    reply, body = ask("POST", "session", {"name": "ann", "password": PASSWORDS["ann"]})
    want(reply.status, 200, "ann, by a proxy")
    ann.headers.update({"Cookie": reply.headers["Set-Cookie"].split(";")[0], "X-Tiltfeed-Csrf": body["csrf"]})
    for number in range(100):
        want(ask("GET", "session")[0].status, 200, f"connection {number} of a proxy")


def main():
    binaries, folder = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    users(binaries, f"{folder}/users")
    for name in ("crt", "key"):
        shutil.copy(f"{ROOT}/tests/desk/tls/localhost.{name}", folder)
    with open(f"{folder}/open.yaml", "w", encoding="ascii") as out:
        out.write("listen: 0.0.0.0:0\n")
    refused = subprocess.run([f"{binaries}/tiltfeed", "desk", "--access", f"{folder}/open.yaml"], capture_output=True, text=True, check=False)
    assert refused.returncode == 1 and "users are needed" in refused.stderr, refused
    # A port that is free now; names carry it.
    probe = subprocess.Popen([f"{binaries}/tiltfeed", "desk"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    port = int(re.search(r":(\d+)/", probe.stdout.readline())[1])
    probe.terminate()
    probe.wait()
    with open(f"{folder}/desk.yaml", "w", encoding="ascii") as out:
        out.write(f"listen: 127.0.0.1:{port}\nnames: [localhost:{port}]\nusers: users\ncertificate: localhost.crt\nkey: localhost.key\n")
    desk = subprocess.Popen([f"{binaries}/tiltfeed", "desk", "--access", f"{folder}/desk.yaml"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        want(desk.stdout.readline(), f"https://localhost:{port}/\n", "the address, without a token")
        ann, bob, nobody = Client(port), Client(port), Client(port)
        status, _, body = ann.ask("GET", "session")
        want((status, "name and password" in body["error"]), (401, True), "before signing in")
        want(ann.ask("GET", "session", Host=f"127.0.0.1:{port}")[0], 403, "another name")
        want(ann.ask("POST", "session", {"token": "0" * 64})[0], 400, "a token, where there are users")
        os.chmod(f"{folder}/users", 0o666)
        status, _, body = ann.ask("POST", "session", {"name": "ann", "password": PASSWORDS["ann"]})
        want((status, folder in body["error"]), (500, False), f"everybody may write the file of users: {body}")
        status, said = user(binaries, "list", "--users", f"{folder}/users")
        want((status, "chmod o-w" in said), (1, True), f"the list of these: {said}")
        os.chmod(f"{folder}/users", 0o640)
        want(ann.sign_in("ann", PASSWORDS["bob"]), 401, "another's password")
        want(nobody.sign_in("eve", "some other one"), 401, "one that was removed")
        want(ann.sign_in("ann", PASSWORDS["ann"]), 200, "ann")
        want(bob.sign_in("bob", PASSWORDS["bob"]), 200, "bob")
        want(ann.ask("GET", "session")[2]["user"], "ann", "who it is")
        want(ann.ask("GET", "session", Origin="https://evil.example")[0], 200, "a reading needs no origin")
        want(ann.ask("POST", "seat/ask", {}, Origin=f"http://localhost:{port}")[0], 403, "an origin without TLS")
        want(bob.ask("GET", "state")[0], 200, "bob watches")
        for path in ("seat/ask", "run/hold", "plan"):
            want(bob.ask("POST", path, {})[0], 403, f"bob: {path}")
        status, _, seat = ann.ask("POST", "seat/ask", {})
        want((status, seat["owner"]["name"].split(",")[0]), (200, "ann"), "the seat")
        status, _, body = bob.ask("GET", "state", Authorization="Bearer " + "0" * 64)
        want((status, "takes no tokens" in body["error"]), (401, True), "a token where there are none")
        want(bob.ask("DELETE", "session")[0], 200, "bob signs out")
        want(bob.ask("GET", "state")[0], 401, "bob is out")
        plain = http.client.HTTPConnection("127.0.0.1", port, timeout=HANG)
        try:
            plain.request("GET", "/")
            raise AssertionError(f"plain HTTP is answered: {plain.getresponse().status}")
        except (http.client.HTTPException, ConnectionError):
            pass
        tries = [nobody.sign_in("mallory", f"guess number {i}") for i in range(12)]
        want((tries[0], tries[-1]), (401, 429), f"many guesses: {tries}")
        want(ann.ask("GET", "state")[0], 200, "who is signed in is not concerned")
        desk.terminate()
        want(desk.wait(HANG), 0, "the end")
        with open(f"{folder}/desk.yaml", "w", encoding="ascii") as out:
            out.write(f"listen: 127.0.0.1:{port}\nnames: [localhost:{port}]\nusers: users\nbehind_proxy: true\n")
        desk = subprocess.Popen([f"{binaries}/tiltfeed", "desk", "--access", f"{folder}/desk.yaml"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        want(desk.stdout.readline(), f"https://localhost:{port}/\n", "the address, of the proxy")
        behind_proxy(Client(port))
        desk.terminate()
        want(desk.wait(HANG), 0, "the end, behind a proxy")
    finally:
        desk.kill()
    print("desk_access_test: all passed")


main()
