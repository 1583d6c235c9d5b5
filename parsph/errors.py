"""The one exception family: each message says where, what is wrong, why, and what would be right."""

import difflib
import textwrap


class ParsphError(Exception):
    """A failure with a message for the user.

    Parameters
    ----------
    what : str
        What is wrong, in lower case and without a full stop.
    where : str, optional
        The scene key, file or particle that is meant.
    why : str, optional
        The reason, physics included.
    cure : str, optional
        What would be right.
    """

    exit_code = 1
    alike = False  # whether all ranks find it together, so that each can end by itself

    def __init__(self, what, where="", why="", cure=""):
        self.what, self.where, self.why, self.cure = what, where, why, cure
        super().__init__(str(self))

    def __str__(self):
        head = f"{self.where}: {self.what}" if self.where else self.what
        return "; ".join(part for part in (head, self.why, self.cure) if part)

    def __reduce__(self):  # so that it travels between ranks whole
        return (type(self), (self.what, self.where, self.why, self.cure))


class SceneError(ParsphError):
    """Bad input: nothing was run and nothing was written (exit code 2)."""

    exit_code = 2
    alike = True


class SceneFaults(SceneError):
    """All faults of one scene at once.

    Parameters
    ----------
    faults : list of SceneError
    """

    def __init__(self, faults):
        self.faults = list(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __str__(self):
        return "\n".join(str(fault) for fault in self.faults)

    def __reduce__(self):
        return (type(self), (self.faults,))


class RunError(ParsphError):
    """A run that went wrong while it ran; the last good output is kept (exit code 1)."""


class Interrupted(ParsphError):
    """A run that the user stopped (exit code 130)."""

    exit_code = 130


class Unfinished(ParsphError):
    """A run that was asked to end, or whose time is up; it can go on from its checkpoint (exit code 85)."""

    exit_code = 85


def paragraph(error, width=100):
    """The text of an error as one wrapped paragraph per fault, headed ``error:``."""
    whole = {"break_on_hyphens": False, "break_long_words": False}  # paths are there to be copied
    lines = str(error).splitlines()
    return "\n".join(textwrap.fill(f"error: {line}", width, subsequent_indent="  ", **whole) for line in lines)


def did_you_mean(word, choices):
    """Return "did you mean 'x'? " for the choice nearest to `word`, empty when none is near."""
    near = difflib.get_close_matches(str(word), list(choices), 1)
    return f"did you mean {near[0]!r}? " if near else ""


def shortened(text, most=80):
    """Return a text of the user's on one line, its middle left out where it is long."""
    text = text if text.isprintable() else repr(text)[1:-1]
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-most // 4 :]}"


def shown(value):
    """Return a value of the user's as it would be written, in short."""
    try:
        return shortened(repr(value))
    except ValueError:  # Python writes no numbers of more than some thousands of digits
        return "a number of thousands of digits"
