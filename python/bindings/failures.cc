#include "tessera/failure.h"

#include <cstring>
#include <exception>
#include <utility>

#include "python/bindings/bindings.h"

namespace tessera::python {

namespace py = pybind11;

void bind_failures() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(std::move(thrown));
    } catch (const Failure& failure) {
      const auto types = py::module_::import("tessera._errors").attr("BY_CAUSE");
      const auto type = types[py::int_(static_cast<int>(failure.cause()))];
      // Names of files need not be UTF-8; surrogateescape is how Python writes those that are not.
      const auto sentence = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
          failure.what(), static_cast<Py_ssize_t>(std::strlen(failure.what())), "surrogateescape"));
      PyErr_SetObject(type.ptr(), sentence.ptr());
    }
  });
}

}  // namespace tessera::python
