"""The exceptions, one for each cause of docs/exit-status.md."""


class Error(Exception):
    """What goes wrong in tessera: one sentence that names the file or argument, the place and the reason.

    `cause` is "usage", "bad_input", "io", "corrupt", "not_delaunay", "memory", "interrupted" or "internal". Ctrl-C is not among them: it
    is KeyboardInterrupt, as everywhere in Python. Exceptions of a progress callback come out as they are.
    """

    cause = "internal"
    # Of what a daemon answers: the status of HTTP, and the type of its problem.
    _http_status = 0
    _problem_type = ""


class UsageError(Error, ValueError):
    """An argument that makes no sense, or a result folder that may not be replaced."""

    cause = "usage"


class BadInputError(Error, ValueError):
    """Points that are not finite, or span no volume (in 2D: no area), or a file that is not what it claims to be."""

    cause = "bad_input"


class IoError(Error, OSError):
    """The system refused: a file is missing or unreadable, the disk is full, a folder cannot be written."""

    cause = "io"


class CorruptError(Error):
    """A result folder that is damaged, or was written by a newer version."""

    cause = "corrupt"


class NotDelaunayError(Error):
    """A result that verify() found wrong: a mistake of tessera's, please report it."""

    cause = "not_delaunay"


class MemoryLimitError(Error, MemoryError):
    """The job cannot be done within the memory it was given, or the system has no more."""

    cause = "memory"


class InterruptedJobError(Error):
    """Something other than Ctrl-C stopped the job."""

    cause = "interrupted"


class InternalError(Error, RuntimeError):
    """A mistake of tessera's: please report it."""

    cause = "internal"


# What options are called here, where the command calls them otherwise but for dashes.
NAMES = {"class": "classes", "z": "heights", "type": "doubles"}


def argument(key: str, value: str) -> str:
    """How a sentence names the option `key`, and with a `value` that it is given: "memory", "skip_invalid=True"."""
    name = NAMES.get(key, key.replace("-", "_"))
    if not value:
        return name
    return f"{name}={value.title() if value in ('true', 'false') else value if value.isdecimal() else repr(value)}"


# By the numbers of tessera::Cause; the extension module looks here.
BY_CAUSE = {2: UsageError, 3: BadInputError, 4: IoError, 5: CorruptError, 6: NotDelaunayError, 7: MemoryLimitError, 8: InterruptedJobError,
            9: InternalError}
