#include "tessera/failure.h"

#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include "python/bindings/bindings.h"

namespace tessera::python {

namespace py = pybind11;

void bind_failures() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(std::move(thrown));
    } catch (const Failure& failure) {
      const auto errors = py::module_::import("tessera._errors");
      const auto type = errors.attr("BY_CAUSE")[py::int_(static_cast<int>(failure.cause()))];
      const auto name = [&](std::string_view key, std::string_view value) {
        return errors.attr("argument")(key, value).cast<std::string>();
      };
      const std::string said = failure.sentence(name);
      // Names of files need not be UTF-8. Python writes other names with surrogateescape.
      const auto sentence = py::reinterpret_steal<py::object>(
          PyUnicode_DecodeUTF8(said.data(), static_cast<Py_ssize_t>(said.size()), "surrogateescape"));
      PyErr_SetObject(type.ptr(), sentence.ptr());
    }
  });
}

}  // namespace tessera::python
