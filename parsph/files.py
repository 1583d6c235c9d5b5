"""Files that users name: what may be one, and text files of a bounded size."""

import os
import stat

from .errors import SceneError, shown

FORBIDDEN = r'<>:"/\|?*'  # in names of files, by one system or another
RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{number}" for port in ("com", "lpt") for number in range(10))}
LONGEST_NAME = 100  # characters, of up to two bytes, and an ending: file systems take 255 bytes


def is_file_name(name):
    """Return whether a file in a folder may be called so, on any system, with an ending put behind it."""
    return (
        0 < len(name) <= LONGEST_NAME
        and len(name.encode()) <= 2 * LONGEST_NAME
        and name.isprintable()
        and not any(character in FORBIDDEN for character in name)
        and name == name.strip(" .")
        and name.split(".")[0].lower() not in RESERVED
    )


def read_text(path, largest, what):
    """Return the text of a file; devices, pipes and folders are refused before they are opened, since those may never end.

    Parameters
    ----------
    path : path
    largest : float
        Most bytes that it may have.
    what : str
        What it should be, for the message.

    Raises
    ------
    SceneError
        When it cannot be read, is no regular file, is too large, or not UTF-8.
    """
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise SceneError("is not a regular file", where=str(path), cure=what)
        if status.st_size > largest:
            what_is = f"holds {status.st_size / 1e6:,.0f} MB, more than {largest / 1e6:,.0f} MB"
            raise SceneError(what_is, where=str(path), cure=what)
        with open(path, encoding="utf-8-sig") as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"cannot be read: {error}", where=str(path), cure=f"{what} that you may read") from None
    except ValueError:  # of a name with a null character
        raise SceneError("is no name of a file", where=shown(str(path)), cure=what) from None
