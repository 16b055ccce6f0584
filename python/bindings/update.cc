// Binds changes of results.
#include "tessera/update.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/views.h"

namespace tessera::python {
namespace {

UpdateRequest update_request(bool replace, unsigned threads) {
  UpdateRequest request;
  request.replace(replace).threads(threads);
  return request;
}

// The caller keeps `rows` alive until the update.
void add(UpdateRequest& self, const py::array& rows, const std::string& columns) {
  self.add(Records{{static_cast<const std::byte*>(rows.data()), static_cast<std::size_t>(rows.nbytes())},
                   static_cast<std::uint64_t>(rows.size()),
                   columns});
}

// Returns (first id, removed, added, equal, tiles awake, tiles changed).
py::tuple run_update(const Triangulation& self, UpdateRequest request) {
  const UpdateReport made =
      run_interruptible([&](std::stop_token stop) { return update(self, request.stop(std::move(stop))); });
  return py::make_tuple(made.first_id, made.removed, made.added, made.equal, made.tiles_awake, made.tiles_changed);
}

}  // namespace

void bind_update(py::module_& module) {
  py::class_<UpdateRequest>(module, "UpdateRequest")
      .def(py::init(&update_request))
      .def("add", &add)
      .def("remove", [](UpdateRequest& self,
                        const py::array_t<std::uint64_t, py::array::c_style>& ids) { self.remove(span_of(ids)); })
      .def("output", [](UpdateRequest& self, const std::filesystem::path& folder) { self.output(folder); });
  module.def("update", &run_update);
}

}  // namespace tessera::python
