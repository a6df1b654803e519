"""The socket of a page of kilotouch view, without a browser."""
import json
import socket
import struct
import time

from view_unit_test import websocket_frame


class PageSocket:
    def __init__(self, view, path="/live", **more):
        status, self.connection, answer = view.upgrade(path, **more)
        if status != 101:
            raise ConnectionError(f"refused: {status}")
        self.buffer = answer.split(b"\r\n\r\n", 1)[1]
        self.status, self.hello, self.answers, self.closed = None, None, [], None
        self.parts, self.opcode = b"", 0

    def send(self, **message):
        self.connection.sendall(websocket_frame(json.dumps(message).encode()))

    def frame(self):
        """(opcode, whether it is the last of its message, payload) of the next one, or None: it is not here yet."""
        if len(self.buffer) < 2:
            return None
        size, at = self.buffer[1], 2
        for code, form, width in ((126, ">H", 2), (127, ">Q", 8)):
            if self.buffer[1] == code:
                if len(self.buffer) < 2 + width:
                    return None
                size, at = struct.unpack(form, self.buffer[2:2 + width])[0], 2 + width
        if len(self.buffer) < at + size:
            return None
        first, payload, self.buffer = self.buffer[0], self.buffer[at:at + size], self.buffer[at + size:]
        return first & 15, first >> 7, payload

    def read(self):
        found = self.frame()
        while not found:
            more = self.connection.recv(65536)
            if not more:
                raise ConnectionError("closed")
            self.buffer += more
            found = self.frame()
        opcode, is_last, payload = found
        self.parts = payload if opcode else self.parts + payload
        self.opcode = opcode or self.opcode
        if not is_last:
            return
        if self.opcode == 8:
            self.closed = struct.unpack(">H", self.parts[:2])[0], self.parts[2:].decode()
        elif self.opcode == 1:
            self.take(json.loads(self.parts))

    def take(self, message):
        if message["type"] == "status":
            self.status = message
        elif message["type"] == "hello":
            self.hello, self.status = message, None
        elif message["type"] == "answer":
            self.answers.append(message)

    def until(self, what, seconds=180):
        """Reads until what() is true, and returns that."""
        end = time.time() + seconds
        while time.time() < end:
            found = what()
            if found:
                return found
            try:
                self.read()
            except socket.timeout:
                pass
        raise AssertionError(f"not within {seconds} s; status {self.status}, answers {self.answers[-3:]}")

    def ask(self, **message):
        """The answer to it."""
        count = len(self.answers)
        self.send(**message)
        return self.until(lambda: self.answers[count] if len(self.answers) > count else None)

    def runs(self):
        self.until(lambda: self.status and self.status["refreshes"] > 3)
        return self
