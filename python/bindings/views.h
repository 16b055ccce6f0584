// NumPy arrays over the memory of C++ objects.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tessera::python {

namespace py = pybind11;

// Arrays come from tessera/_arrays.py, which makes them float64 and C-contiguous or refuses them. So nothing is
// converted here.
using Coordinates = py::array_t<double, py::array::c_style>;
using Indices = py::array_t<std::int32_t, py::array::c_style>;

template <class T, int Flags>
std::span<const T> span_of(const py::array_t<T, Flags>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

// Returns a read-only array over `data`, without a copy. The array keeps `owner` alive, and so the memory.
inline py::array view(const py::dtype& type, const void* data, std::vector<py::ssize_t> shape,
                      std::vector<py::ssize_t> strides, const py::object& owner) {
  py::array array(type, std::move(shape), std::move(strides), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

// Returns a view of `values` as an array of n x columns, row after row.
template <class T>
py::array rows_view(std::span<const T> values, int columns, const py::object& owner) {
  constexpr py::ssize_t size = sizeof(T);
  return view(py::dtype::of<T>(), values.data(), {static_cast<py::ssize_t>(values.size()) / columns, columns},
              {columns * size, size}, owner);
}

// Returns a view of `values` as an array of one dimension. `type` may be another type for the same bytes, of any size.
template <class T>
py::array column_view(std::span<const T> values, const py::object& owner, const py::dtype& type = py::dtype::of<T>()) {
  return view(type, values.data(), {static_cast<py::ssize_t>(values.size_bytes()) / type.itemsize()}, {type.itemsize()},
              owner);
}

// Returns an array that owns the vector's memory. `To`: a type of the same size, as which NumPy sees the values.
// Unsigned ranks become int64, because they are below 2^63.
template <class To, class T>
py::array given(std::vector<T> values, std::vector<py::ssize_t> shape = {}) {
  static_assert(sizeof(To) == sizeof(T));
  auto* kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept, [](void* memory) { delete static_cast<std::vector<T>*>(memory); });
  if (shape.empty()) shape = {static_cast<py::ssize_t>(kept->size())};
  return py::array(py::dtype::of<To>(), std::move(shape), kept->data(), owner);
}

template <class To, class T>
py::array rows(std::vector<T> values, int columns) {
  const auto n = static_cast<py::ssize_t>(values.size()) / columns;
  return given<To>(std::move(values), {n, columns});
}

}  // namespace tessera::python
