"""The exceptions of tessera, one class for each cause of docs/exit-status.md."""


class Error(Exception):
    """The base class of all errors. The message is one sentence that names the file or argument, place and reason.

    `cause` is "usage", "bad_input", "io", "corrupt", "not_delaunay", "memory", "interrupted" or "internal". Ctrl-C
    raises KeyboardInterrupt, as everywhere in Python. Exceptions of a progress callback pass through unchanged.
    """

    cause = "internal"
    # For an answer of a daemon: the HTTP status, and the type of the problem (RFC 9457).
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
    """verify() found that a result is wrong. This is a bug of tessera: please report it."""

    cause = "not_delaunay"


class MemoryLimitError(Error, MemoryError):
    """The job does not fit into the memory that it may use, or the system has no more memory."""

    cause = "memory"


class InterruptedJobError(Error):
    """Something other than Ctrl-C stopped the job."""

    cause = "interrupted"


class InternalError(Error, RuntimeError):
    """A bug of tessera: please report it."""

    cause = "internal"


# The options that have another name here than in the command, apart from dashes.
NAMES = {"class": "classes", "scan": "scans", "z": "heights", "type": "doubles"}


def argument(key: str, value: str) -> str:
    """Returns how a message names the option `key`, with its `value` if given: "memory", "skip_invalid=True"."""
    name = NAMES.get(key, key.replace("-", "_"))
    if not value:
        return name
    return f"{name}={value.title() if value in ('true', 'false') else value if value.isdecimal() else repr(value)}"


# The classes by the numbers of tessera::Cause. The extension module reads this table.
BY_CAUSE = {2: UsageError, 3: BadInputError, 4: IoError, 5: CorruptError, 6: NotDelaunayError, 7: MemoryLimitError, 8: InterruptedJobError,
            9: InternalError}
