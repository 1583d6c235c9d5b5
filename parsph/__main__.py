"""``python -m parsph``: the command line, in a process of its own."""

import signal
import sys

from .errors import Unfinished


def main():
    """Run the command line; the signals by which queues end jobs do not kill it halfway, neither before a run nor after."""
    for number in (signal.SIGTERM, signal.SIGUSR1):
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, lambda *_: sys.exit(Unfinished.exit_code))
    from . import cli  # takes its time

    cli.main()


if __name__ == "__main__":
    main()
