"""`tiltfeed desk` as a client sees it, for the system tests in Python."""

import http.client
import json
import os
import re
import socket
import subprocess

import jsonschema

HANG = 300  # seconds: no measure of speed


class Api:
    """desk/api/openapi.json: every answer that a test gets is held against it."""

    ROOT = "/api/v1"

    def __init__(self):
        with open(os.path.dirname(os.path.abspath(__file__)) + "/../../desk/api/openapi.json", encoding="utf-8") as file:
            self.page = json.load(file)
        self.seen = set()

    def resolved(self, found):
        while "$ref" in found:
            place = self.page
            for name in found["$ref"].removeprefix("#/").split("/"):
                place = place[name]
            found = place
        return found

    def check(self, method, path, status, headers, body):
        path = path.partition("?")[0]
        operation = self.page["paths"].get(path.removeprefix(self.ROOT), {}).get(method.lower()) if path.startswith(self.ROOT) else None
        if operation is None:
            return
        responses = operation["responses"]
        response = responses.get(str(status)) or (responses.get(f"{status // 100}XX") if status >= 400 else None)
        assert response, f"{method} {path} answers {status}; openapi.json knows {list(responses)}"
        content = self.resolved(response)["content"]
        kind = headers["Content-Type"]
        assert kind in content, f"{method} {path} answers {kind}; openapi.json knows {list(content)}"
        self.seen.add((method, path.removeprefix(self.ROOT), status < 400))
        if kind == "application/json":
            schema = {**content[kind]["schema"], "components": self.page["components"]}
            try:
                jsonschema.Draft202012Validator(schema).validate(json.loads(body))
            except jsonschema.ValidationError as error:
                raise AssertionError(f"{method} {path}, {status}: {error.json_path}: {error.message[:300]}") from None


API = Api()


class Desk:
    started = []

    @staticmethod
    def kill_all():
        for process in Desk.started:
            process.kill()

    def __init__(self, binaries, *words, log=None):
        """`log`: a file to which its complaints are added."""
        errors = open(log, "a", encoding="utf-8") if log else None
        self.process = subprocess.Popen([f"{binaries}/tiltfeed", "desk", *words], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=errors, text=True)
        if errors:
            errors.close()
        Desk.started.append(self.process)
        self.address = self.process.stdout.readline().strip()
        match = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{64})", self.address)
        assert match, self.address
        self.port, self.token = int(match[1]), match[2]
        self.origin = f"http://127.0.0.1:{self.port}"

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), HANG)

    def ask(self, method, path, body=None, **headers):
        """(status, headers, body) of one request; a header given as None is left out."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=HANG)
        all_headers = {"Origin": self.origin, "Content-Type": "application/json", **headers}
        sent = {name.replace("_", "-"): value for name, value in all_headers.items() if value is not None}
        connection.request(method, path, body, sent)
        reply = connection.getresponse()
        answer = reply.status, reply.headers, reply.read()
        API.check(method, path, *answer)
        return answer

    def sign_in(self):
        status, headers, body = self.ask("POST", "/api/v1/session", json.dumps({"token": self.token}))
        assert status == 200, (status, body)
        cookie = headers["Set-Cookie"]
        for part in ("HttpOnly", "SameSite=Strict", "Path=/"):
            assert part in cookie, cookie
        self.signed = {"Cookie": cookie.split(";")[0], "X_Tiltfeed_Csrf": json.loads(body)["csrf"]}
        self.session = json.loads(body)["session"]

    def another(self):
        """A browser of its own, signed in by a new address."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.token = self.process.stdout.readline().strip().partition("#token=")[2]
        other.sign_in()
        return other

    def get(self, path):
        status, _, body = self.ask("GET", f"/api/v1/{path}", **self.signed)
        assert status == 200, (path, status, body)
        return json.loads(body)

    def post(self, path, **body):
        """(status, answer)."""
        status, _, answer = self.ask("POST", f"/api/v1/{path}", json.dumps(body), **self.signed)
        return status, json.loads(answer)

    def stop(self):
        self.process.terminate()
        return self.process.wait(HANG)
