"""The C data interface of Apache Arrow, with ctypes: the packages that hand over tables need not be known here.

https://arrow.apache.org/docs/format/CDataInterface.html and CStreamInterface.html define the structures, and the PyCapsule
interface how Python hands them over.
"""
from __future__ import annotations

import ctypes
import errno
import itertools
import sys
import typing

import numpy as np
import numpy.typing as npt

from ._errors import UsageError

Columns = typing.Dict[str, "npt.NDArray[typing.Any]"]

# Arrow's formats of numbers, and NumPy's.
_TYPES = {b"c": "i1", b"C": "u1", b"s": "<i2", b"S": "<u2", b"i": "<i4", b"I": "<u4", b"l": "<i8", b"L": "<u8", b"f": "<f4", b"g": "<f8"}
_FORMATS = {np.dtype(name): format for format, name in _TYPES.items()}
_BOOLEAN = b"b"
_STREAM = b"arrow_array_stream"


class Schema(ctypes.Structure):
    """ArrowSchema. Pointers to functions are plain pointers, so that NULL can be seen and set."""


Schema._fields_ = [("format", ctypes.c_char_p), ("name", ctypes.c_char_p), ("metadata", ctypes.c_void_p), ("flags", ctypes.c_int64),
                   ("n_children", ctypes.c_int64), ("children", ctypes.POINTER(ctypes.POINTER(Schema))), ("dictionary", ctypes.c_void_p),
                   ("release", ctypes.c_void_p), ("private_data", ctypes.c_void_p)]


class Array(ctypes.Structure):
    """ArrowArray."""


Array._fields_ = [("length", ctypes.c_int64), ("null_count", ctypes.c_int64), ("offset", ctypes.c_int64), ("n_buffers", ctypes.c_int64),
                  ("n_children", ctypes.c_int64), ("buffers", ctypes.POINTER(ctypes.c_void_p)),
                  ("children", ctypes.POINTER(ctypes.POINTER(Array))), ("dictionary", ctypes.c_void_p), ("release", ctypes.c_void_p),
                  ("private_data", ctypes.c_void_p)]


class Stream(ctypes.Structure):
    """ArrowArrayStream."""

    _fields_ = [("get_schema", ctypes.c_void_p), ("get_next", ctypes.c_void_p), ("get_last_error", ctypes.c_void_p),
                ("release", ctypes.c_void_p), ("private_data", ctypes.c_void_p)]


_GET = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
_LAST_ERROR = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)
_RELEASE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_new_capsule = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)(("PyCapsule_New", ctypes.pythonapi))
_in_capsule = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(("PyCapsule_GetPointer", ctypes.pythonapi))
# Of a capsule that is being destroyed, which must not be referred to again.
_in_old_capsule = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)(("PyCapsule_GetPointer", ctypes.pythonapi))


# Reading.

def batches(source: typing.Any) -> typing.Iterator[Columns]:
    """Yields the columns of each batch of a table that has __arrow_c_stream__. The arrays are copies."""
    capsule = source.__arrow_c_stream__()
    address = _in_capsule(capsule, _STREAM)
    stream = Stream.from_address(address)
    schema = Schema()
    try:
        _ask(stream, address, stream.get_schema, schema)
        names = _names(schema)
        while True:
            batch = Array()
            _ask(stream, address, stream.get_next, batch)
            if not batch.release:
                return
            try:
                yield _columns(names, batch)
            finally:
                release(batch)
    finally:
        release(schema)
        release(stream)
        del capsule


def release(structure: Schema | Array | Stream) -> None:
    """Tells the producer of a structure that it is not needed any more."""
    if structure.release:
        _RELEASE(structure.release)(ctypes.addressof(structure))


def _ask(stream: Stream, address: int, function: int, target: ctypes.Structure) -> None:
    status = _GET(function)(address, ctypes.addressof(target))
    if status != 0:
        said = _LAST_ERROR(stream.get_last_error)(address) if stream.get_last_error else None
        text = ctypes.string_at(said).decode(errors="replace") if said else f"error {status}"
        raise UsageError(f"the Arrow stream cannot be read: {text}")


def _names(schema: Schema) -> list[tuple[str, bytes]]:
    """Returns name and format of each column."""
    if schema.format != b"+s":
        raise UsageError(f"the Arrow stream has no columns: its format is {_text(schema.format)!r}, and not a table")
    columns = []
    for i in range(schema.n_children):
        child = schema.children[i].contents
        name, format = _text(child.name), child.format or b""
        if child.dictionary or (format not in _TYPES and format != _BOOLEAN):
            kind = "a dictionary" if child.dictionary else f"of the Arrow format {_text(format)!r}"
            raise UsageError(f"column {name!r} is {kind}, and not of integers, floats or bool: choose other columns")
        columns.append((name, format))
    return columns


def _text(value: bytes | None) -> str:
    return (value or b"").decode(errors="replace")


def _columns(names: list[tuple[str, bytes]], batch: Array) -> Columns:
    if batch.n_children != len(names) or batch.length < 0 or batch.offset < 0:
        raise UsageError(f"a batch of the Arrow stream has {batch.n_children} columns: its schema has {len(names)}")
    _refuse_nulls(batch, batch.offset, batch.length, "a row of the table")
    return {name: _values(name, format, batch.children[i].contents, batch) for i, (name, format) in enumerate(names)}


def _values(name: str, format: bytes, column: Array, batch: Array) -> npt.NDArray[typing.Any]:
    """Returns a copy of a column's values in the rows of the batch."""
    begin, count = column.offset + batch.offset, batch.length
    if column.n_buffers != 2 or column.length < begin - column.offset + count or column.offset < 0:
        raise UsageError(f"column {name!r} of the Arrow stream has {column.length} values in {column.n_buffers} buffers, "
                         f"for {count} rows: two buffers with at least as many values are needed")
    _refuse_nulls(column, begin, count, f"column {name!r}")
    if count > 0 and not column.buffers[1]:
        raise UsageError(f"column {name!r} of the Arrow stream has no values")
    if format == _BOOLEAN:
        return _bits(column.buffers[1], begin, count)
    dtype = np.dtype(_TYPES[format])
    if count == 0:
        return np.empty(0, dtype)
    held = (ctypes.c_char * (count * dtype.itemsize)).from_address(column.buffers[1] + begin * dtype.itemsize)
    return np.frombuffer(held, dtype).copy()


def _refuse_nulls(array: Array, begin: int, count: int, what: str) -> None:
    if array.null_count != 0 and array.n_buffers > 0 and array.buffers[0]:
        missing = np.flatnonzero(~_bits(array.buffers[0], begin, count))
        if len(missing):
            raise UsageError(f"{what} is null (row {missing[0]} of a batch, and {len(missing) - 1} others): leave those rows out")


def _bits(address: int, begin: int, count: int) -> npt.NDArray[np.bool_]:
    if count == 0:
        return np.empty(0, bool)
    held = (ctypes.c_uint8 * ((begin + count + 7) // 8)).from_address(address)
    return np.unpackbits(np.frombuffer(held, np.uint8), bitorder="little", count=begin + count)[begin:].astype(bool)


# Writing. What a consumer has not released yet is kept here, by the number in private_data.
_kept: dict[int, typing.Any] = {}
_numbers = itertools.count(1)
# By address, the streams of capsules: a consumer may have released one long before its capsule ends.
_streams: dict[int, Stream] = {}


def stream_of(first: Columns, made: typing.Iterator[Columns]) -> object:
    """Returns a capsule with a stream of batches. All have the columns of `first`, which is an example without rows."""
    stream = Stream(ctypes.cast(_get_schema, ctypes.c_void_p), ctypes.cast(_get_next, ctypes.c_void_p),
                    ctypes.cast(_get_last_error, ctypes.c_void_p), ctypes.cast(_release_stream, ctypes.c_void_p))
    stream.private_data = _keep(_Source(first, made))
    _streams[ctypes.addressof(stream)] = stream
    return _new_capsule(ctypes.addressof(stream), _STREAM, ctypes.cast(_destroy_capsule, ctypes.c_void_p))


class _Source:
    """What a stream gives."""

    def __init__(self, first: Columns, made: typing.Iterator[Columns]):
        self.first, self.made = first, made
        self.error = b""


def _keep(thing: object) -> int:
    number = next(_numbers)
    _kept[number] = thing
    return number


def _source(address: int) -> _Source:
    source = _kept[Stream.from_address(address).private_data]
    assert isinstance(source, _Source)
    return source


def _fill_schema(schema: Schema, columns: Columns) -> None:
    children = [Schema(_FORMATS[values.dtype], name.encode(), None, 0, 0, None, None, ctypes.cast(_release_schema, ctypes.c_void_p))
                for name, values in columns.items()]
    for child in children:
        child.private_data = _keep(child)
    pointers = (ctypes.POINTER(Schema) * len(children))(*map(ctypes.pointer, children))
    schema.format, schema.name, schema.metadata, schema.flags = b"+s", b"", None, 0
    schema.n_children, schema.children, schema.dictionary = len(children), pointers, None
    schema.release = ctypes.cast(_release_schema, ctypes.c_void_p)
    schema.private_data = _keep((children, pointers))


def _fill_array(array: Array, columns: Columns) -> None:
    children = []
    for values in columns.values():
        child = Array(len(values), 0, 0, 2, 0, None, None, None, ctypes.cast(_release_array, ctypes.c_void_p))
        buffers = (ctypes.c_void_p * 2)(None, values.ctypes.data)
        child.buffers = buffers
        child.private_data = _keep((values, buffers))
        children.append(child)
    pointers = (ctypes.POINTER(Array) * len(children))(*map(ctypes.pointer, children))
    buffers = (ctypes.c_void_p * 1)(None)
    array.length, array.null_count, array.offset, array.n_buffers = len(next(iter(columns.values()))), 0, 0, 1
    array.n_children, array.buffers, array.children, array.dictionary = len(children), buffers, pointers, None
    array.release = ctypes.cast(_release_array, ctypes.c_void_p)
    array.private_data = _keep((children, pointers, buffers))


@_GET
def _get_schema(address: int, target: int) -> int:
    _fill_schema(Schema.from_address(target), _source(address).first)
    return 0


@_GET
def _get_next(address: int, target: int) -> int:
    source = _source(address)
    try:
        columns = next(source.made, None)
        if columns is None:
            Array.from_address(target).release = None
        else:
            _fill_array(Array.from_address(target), columns)
    except Exception as error:  # noqa: BLE001 - C cannot take it; the consumer asks for the text
        source.error = str(error).encode()
        return errno.EIO
    return 0


@_LAST_ERROR
def _get_last_error(address: int) -> int | None:
    error = ctypes.c_char_p(_source(address).error)
    return ctypes.cast(error, ctypes.c_void_p).value


@_RELEASE
def _release_stream(address: int) -> None:
    stream = Stream.from_address(address)
    number, stream.release = stream.private_data, None
    _kept.pop(number, None)


@_RELEASE
def _release_schema(address: int) -> None:
    _release_with_children(Schema.from_address(address))


@_RELEASE
def _release_array(address: int) -> None:
    _release_with_children(Array.from_address(address))


def _release_with_children(structure: Schema | Array) -> None:
    for i in range(structure.n_children):
        release(structure.children[i].contents)
    number, structure.release = structure.private_data, None
    _kept.pop(number, None)


@ctypes.CFUNCTYPE(None, ctypes.c_void_p)
def _destroy_capsule(capsule: int) -> None:
    if sys.is_finalizing():
        return
    address = _in_old_capsule(capsule, _STREAM)
    release(Stream.from_address(address))
    _streams.pop(address, None)
