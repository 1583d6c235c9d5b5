"""Makes `helpers` importable from every test folder, and the command line callable in the process of a test."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def command(capfd, monkeypatch):
    """The command line in this process: arguments in, (exit code, what was printed, what was said on stderr) out."""
    from parsph.cli import main

    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments):
        capfd.readouterr()
        try:
            main([str(argument) for argument in arguments])
            code = 0
        except SystemExit as end:
            code = end.code or 0
        out, err = capfd.readouterr()
        return code, out, " ".join(err.split())

    return call
