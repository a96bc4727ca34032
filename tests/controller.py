"""`columba fly` while it flies: what it says as it says it, and the operator's words."""

import queue
import subprocess
import threading
import time

from conftest import Run

PATIENCE_S = 150


class Controller:
    """`columba fly`, started."""

    def __init__(self, program, folder, *options):
        self.folder = folder
        words = [program, "fly", *options, "--out", folder, "--no-report"]
        self.process = subprocess.Popen(
            [str(word) for word in words],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.lines = []
        self.unread = queue.Queue()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.unread.put(line)
        self.unread.put(None)

    def say(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def wait_for(self, text, patience_s=PATIENCE_S):
        """The next line that holds a text."""
        deadline = time.monotonic() + patience_s
        while True:
            try:
                line = self.unread.get(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"no {text!r} in {patience_s} s: {''.join(self.lines)}") from None
            assert line is not None, f"it ended without {text!r}: {''.join(self.lines)}"
            self.lines.append(line)
            if text in line:
                return line

    def end(self):
        """Its folder, once it has ended by itself."""
        self.process.stdin.close()
        self.process.wait(PATIENCE_S)
        self.reader.join(PATIENCE_S)
        while (line := self.unread.get(timeout=PATIENCE_S)) is not None:
            self.lines.append(line)
        return Run(self.folder, self.process.returncode, "".join(self.lines))

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait(PATIENCE_S)
        self.reader.join(PATIENCE_S)
