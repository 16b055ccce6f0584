// Binds alpha shapes.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <utility>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/views.h"
#include "tessera/alpha.h"

namespace tessera::python {
namespace {

AlphaRequest alpha_request(std::optional<double> alpha, bool general, bool overwrite) {
  AlphaRequest request;
  if (alpha) request.alpha(*alpha);
  request.general(general).overwrite(overwrite);
  return request;
}

// Returns (radius, cells, ids, points, facets, singular facets, singular edges, singular vertices).
py::tuple make(const Triangulation& self, AlphaRequest request) {
  auto shape =
      run_interruptible([&](std::stop_token stop) { return make_alpha_shape(self, request.stop(std::move(stop))); });
  const int dimension = self.dimension();
  return py::make_tuple(
      shape.radius, shape.cells, given<std::int64_t>(std::move(shape.ids)),
      rows<double>(std::move(shape.points), dimension), rows<std::int64_t>(std::move(shape.facets), dimension),
      rows<std::int64_t>(std::move(shape.singular_facets), dimension),
      rows<std::int64_t>(std::move(shape.singular_edges), 2), given<std::int64_t>(std::move(shape.singular_vertices)));
}

double write_alpha(const Triangulation& self, const std::filesystem::path& target, AlphaRequest request) {
  return run_interruptible(
      [&](std::stop_token stop) { return write_alpha_shape(self, target, request.stop(std::move(stop))); });
}

}  // namespace

void bind_alpha(py::module_& module) {
  py::class_<AlphaRequest>(module, "AlphaRequest").def(py::init(&alpha_request));
  module.def("make_alpha_shape", &make);
  module.def("write_alpha_shape", &write_alpha);
}

}  // namespace tessera::python
