"""MAVLink routers between vehicles and a ground station: MAVProxy and mavlink-router, where they are installed.

To run what uses them: pip install MAVProxy, and mavlink-routerd on the PATH.
"""

import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

ROUTERS = ["mavproxy.py", "mavlink-routerd"]


@contextmanager
def router(name, folder, vehicles_port, ground_port):
    """Runs a router: vehicles speak to one UDP port of loopback, and it speaks to the ground station's."""
    program = shutil.which(name)
    if program is None:
        pytest.skip(f"{name} is not on the PATH")
    if name == "mavproxy.py":
        words = [program, f"--master=udpin:127.0.0.1:{vehicles_port}", f"--out=udpout:127.0.0.1:{ground_port}"]
        words += ["--non-interactive", "--streamrate=-1"]
        # A script of a virtual environment has its interpreter in its first line; else ours.
        words = words if open(program, "rb").read(2) == b"#!" else [sys.executable, *words]
    else:
        configuration = folder / "router.conf"
        configuration.write_text(
            "[General]\nTcpServerPort = 0\n"
            f"[UdpEndpoint vehicles]\nMode = Server\nAddress = 127.0.0.1\nPort = {vehicles_port}\n"
            f"[UdpEndpoint ground]\nMode = Normal\nAddress = 127.0.0.1\nPort = {ground_port}\n"
        )
        words = [program, "-c", configuration]
    with open(folder / f"{name}.output", "w") as output:
        process = subprocess.Popen(
            [str(word) for word in words], cwd=folder, stdin=subprocess.DEVNULL, stdout=output, stderr=output
        )
    try:
        yield
    finally:
        process.kill()
        process.wait()
