"""`mechstyle` and `python -m mechstyle`: the commands are loaded within, so that who ends them while they are is not shown where."""

from __future__ import annotations

import io
import signal
import sys


def main() -> None:
    """Run the command line. What asks it to end (SIGTERM, as of a queue or a container) ends it as Ctrl-C does, and its workers with it."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        from mechstyle.cli.app import app  # noqa: PLC0415 — takes a third of a second

        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="replace" if sys.stdout.errors == "strict" else sys.stdout.errors)
        app()
    except KeyboardInterrupt:
        raise SystemExit(128 + signal.SIGINT) from None


if __name__ == "__main__":
    main()
