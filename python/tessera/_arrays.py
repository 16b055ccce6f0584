"""Coordinates to what the library takes: float64, C-contiguous, and not one bit changed on the way."""
import typing

import numpy as np

from ._errors import UsageError


def exact_float64(values: typing.Any, name: str) -> np.ndarray:
    """`values` as a C-contiguous float64 array: itself when it is one, otherwise a copy.

    Any bool, integer or float type, byte order and strides; whatever numpy.asarray takes, lists of lists too.
    UsageError for other types, for masked entries, and for numbers that float64 would round (int64 and uint64 beyond
    2^53, longdouble): equal points must stay equal, different ones different. `name` is the argument's, for the sentence.
    """
    if np.ma.is_masked(values):
        raise UsageError(f"{name} has masked entries: leave those rows out")
    try:
        given = np.asarray(values)
    except ValueError as error:  # rows of different lengths
        raise UsageError(f"{name} is no array of numbers: {error}") from None
    if given.dtype.kind not in "buif":
        raise UsageError(f"{name} must hold integers or floats, not {given.dtype}")
    exact = np.require(given, np.float64, ["C", "ALIGNED"])
    # longdouble has the 64 bits of both: on x86 for its mantissa, on others 113.
    if np.promote_types(given.dtype, np.float64) != np.float64 or is_wide_integer(given):
        wide = given.astype(np.longdouble)
        changed = (wide != exact) & ~np.isnan(wide)
        if changed.any():
            at = tuple(int(i) for i in np.argwhere(changed)[0])
            raise UsageError(f"{name}{list(at)} is {given[at]!r}, which no float64 equals ({changed.sum()} such numbers): "
                             "tessera is exact and does not round; subtract an offset, or convert them yourself")
    return exact


def is_wide_integer(array: np.ndarray) -> bool:
    """Integers, of which some are beyond the 2^53 that float64 counts to."""
    return array.dtype.kind in "ui" and array.size > 0 and (int(array.max()) > 2**53 or int(array.min()) < -(2**53))
