"""Turns coordinates of any numeric type into the arrays that the library takes: float64, C-contiguous, not rounded."""
import decimal
import numbers
import typing

import numpy as np

from ._errors import UsageError


def exact_float64(values: typing.Any, name: str) -> np.ndarray:
    """Returns `values` as a C-contiguous float64 array: the same object if it is such an array, else a copy.

    `values` may be an array of any bool, integer or float type, byte order and strides; anything else that
    numpy.asarray takes, such as lists of lists; an array of Python's numbers (int, float, Fraction, Decimal); or a
    DataFrame, whose columns keep their own types. Raises UsageError for other types, masked or missing entries, and
    numbers that float64 would round (integers beyond 2^53, longdouble): equal points must stay equal, and different
    points different. `name` is the name of the argument, for messages.
    """
    if hasattr(values, "columns") and hasattr(values, "iloc"):  # one array of all columns would round to a common type
        columns = [exact_float64(values.iloc[:, i], f"{name}[{column!r}]") for i, column in enumerate(values.columns)]
        return np.column_stack(columns) if columns else np.empty((len(values), 0))
    if np.ma.is_masked(values):
        raise UsageError(f"{name} has masked entries: leave those rows out")
    try:
        given = np.asarray(values)
        if isinstance(values, (list, tuple)) and given.dtype == np.float64:
            each = np.asarray(values, object)
            if any(isinstance(number, numbers.Integral) and abs(number) > 2**53 for number in each.flat):
                given = each  # NumPy turns a list of integers and floats into floats, and rounds
    except ValueError as error:  # rows of different lengths
        raise UsageError(f"{name} is not an array of numbers: {error}") from None
    if given.dtype.kind == "O":
        return exact_numbers(given, name)
    if given.dtype.kind not in "buif":
        raise UsageError(f"{name} must hold integers or floats, not {given.dtype}")
    exact = np.require(given, np.float64, ["C", "ALIGNED"])
    # A longdouble holds both 64-bit integers and float64 exactly: its mantissa has 64 bits on x86, and 113 elsewhere.
    if np.promote_types(given.dtype, np.float64) != np.float64 or is_wide_integer(given):
        wide = given.astype(np.longdouble)
        refuse_rounded((wide != exact) & ~np.isnan(wide), given, name)
    return exact


def exact_numbers(given: np.ndarray, name: str) -> np.ndarray:
    """Does the same as exact_float64() for an array of objects."""
    exact = np.empty(given.shape)
    rounded = np.zeros(given.shape, bool)
    for at, number in np.ndenumerate(given):
        if not isinstance(number, (numbers.Real, decimal.Decimal, np.bool_)):
            what = f"{name}{list(at)} is {number!r}: it must be a number"
            raise UsageError(what if at else f"{name} is {number!r}: it must be an array of numbers")
        try:
            exact[at] = number
        except OverflowError:
            rounded[at] = True
        else:
            rounded[at] = exact[at].item() != number and number == number
    refuse_rounded(rounded, given, name)
    return exact


def refuse_rounded(rounded: np.ndarray, given: np.ndarray, name: str) -> None:
    """Raises UsageError if an entry of `rounded` is True. The message has the first such number."""
    if rounded.any():
        at = tuple(int(i) for i in np.argwhere(rounded)[0])
        raise UsageError(f"{name}{list(at)} is {given[at]!r}, which no float64 equals exactly ({rounded.sum()} such numbers): "
                         "tessera is exact and does not round; subtract an offset, or convert them yourself")


def is_wide_integer(array: np.ndarray) -> bool:
    """Returns whether the array has integers beyond 2^53, which float64 may not hold exactly."""
    return array.dtype.kind in "ui" and array.size > 0 and (int(array.max()) > 2**53 or int(array.min()) < -(2**53))
