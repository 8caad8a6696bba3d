"""Kernels of the browser tests: forks of one process that has imported everything, which takes each of them four seconds.

`python -m support.forked_kernels SOCKET` forks, for each connection, a kernel that lives as long as the connection; what a Jupyter server
starts instead of a kernel is this very file, which asks for one, hands on interrupts and ends when it ends.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def kernel_server(home: Path, environment: dict[str, str]) -> Iterator[dict[str, str]]:
    """A process to fork kernels from, ready or not yet; what to add to the environment of a Jupyter server, whose kernels are its forks."""
    address, spec = home / "kernels.sock", home / "forked" / "kernels" / "python3" / "kernel.json"
    spec.parent.mkdir(parents=True)
    command = [sys.executable, "-S", "-E", __file__, str(address), "{connection_file}"]
    spec.write_text(json.dumps({"argv": command, "display_name": "Python 3", "language": "python"}))
    paths = os.pathsep.join([str(Path(__file__).parents[1]), *filter(None, [environment.get("PYTHONPATH")])])
    with socket.socket(socket.AF_UNIX) as listening:  # before the process is ready, so that nobody who asks is refused
        listening.bind(str(address))
        listening.listen()
        inherited = {"pass_fds": [listening.fileno()], "env": {**environment, "PYTHONPATH": paths}}
        process = subprocess.Popen([sys.executable, "-m", "support.forked_kernels", str(listening.fileno())], **inherited)
    try:
        yield {"JUPYTER_PATH": str(home / "forked")}
    finally:
        process.kill()
        process.wait()


def serve(listening: socket.socket) -> None:
    """Fork a kernel for each connection; the process has no other thread, which forks would lack."""
    import ipykernel.kernelapp  # noqa: PLC0415
    import ipywidgets  # noqa: PLC0415

    import mechstyle_widgets.studio  # noqa: F401, PLC0415
    import support.sheet_studio  # noqa: F401, PLC0415

    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the system buries them
    while True:
        connection, _ = listening.accept()
        if os.fork():
            connection.close()
            continue
        listening.close()
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        os.setsid()
        asked = json.loads(connection.makefile().readline())
        connection.sendall(f"{os.getpid()}\n".encode())
        os.environ.clear()
        os.environ.update({name: value for name, value in asked["environment"].items() if name != "JPY_PARENT_PID"})
        os.chdir(asked["folder"])
        threading.Thread(target=_end_with, args=(connection,), daemon=True).start()
        sys.argv = ["ipykernel_launcher", "-f", asked["connection_file"]]
        kernel = ipykernel.kernelapp.IPKernelApp.instance()
        kernel.initialize()
        ipywidgets.register_comm_target()  # as its import does in a kernel; without it pages ask for each model by itself
        kernel.start()
        os._exit(0)


def _end_with(connection: socket.socket) -> None:
    connection.recv(1)
    os.kill(os.getpid(), signal.SIGKILL)


def ask(address: str, connection_file: str) -> None:
    """In place of a kernel: have one forked, and live as long as it does."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(address)
        asked = {"connection_file": connection_file, "folder": str(Path.cwd()), "environment": dict(os.environ)}
        connection.sendall(json.dumps(asked).encode() + b"\n")
        pid = int(connection.makefile().readline())
        signal.signal(signal.SIGINT, lambda *_: os.kill(pid, signal.SIGINT))
        with suppress(ConnectionError):
            connection.recv(1)


if __name__ == "__main__":
    if len(sys.argv) == 2:
        serve(socket.socket(fileno=int(sys.argv[1])))
    else:
        ask(*sys.argv[1:])
