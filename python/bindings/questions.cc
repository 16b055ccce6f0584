#include "tessera/questions.h"

#include <pybind11/stl.h>

#include <utility>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/views.h"

namespace tessera::python {
namespace {

py::tuple locate(const Questions& self, const Coordinates& points, int dimension) {
  const auto span = span_of(points);
  auto found = run_interruptible([&](std::stop_token stop) { return self.locate(span, std::move(stop)); });
  return py::make_tuple(given<std::int64_t>(std::move(found.tiles)), given<std::int64_t>(std::move(found.cells)),
                        rows<std::int64_t>(std::move(found.vertices), dimension + 1));
}

py::tuple star(const Questions& self, std::uint64_t vertex, std::optional<std::uint32_t> tile, int dimension) {
  auto found = run_interruptible([&](std::stop_token stop) { return self.star(vertex, tile, std::move(stop)); });
  std::vector<double> point(found.point.begin(), found.point.begin() + dimension);
  return py::make_tuple(found.vertex, found.tile, given<double>(std::move(point)), found.voronoi_volume,
                        given<std::int64_t>(std::move(found.neighbors)),
                        rows<std::int64_t>(std::move(found.cells), dimension + 1),
                        given<std::int32_t>(std::move(found.cell_tiles)));
}

py::array neighbours(const Questions& self, std::uint64_t vertex, std::optional<std::uint32_t> tile) {
  return given<std::int64_t>(
      run_interruptible([&](std::stop_token stop) { return self.neighbours(vertex, tile, std::move(stop)); }));
}

py::tuple interpolate(const Questions& self, const Coordinates& points, const std::string& value, bool natural,
                      bool weights) {
  const auto span = span_of(points);
  const auto method = natural ? Method::natural : Method::linear;
  auto found = run_interruptible(
      [&](std::stop_token stop) { return self.interpolate(span, value, method, weights, std::move(stop)); });
  return py::make_tuple(given<double>(std::move(found.values)), given<std::int64_t>(std::move(found.offsets)),
                        given<std::int64_t>(std::move(found.vertices)), given<double>(std::move(found.weights)));
}

}  // namespace

void bind_questions(py::module_& module) {
  py::class_<Questions>(module, "Questions")
      .def(py::init<const Triangulation&, std::uint64_t, unsigned>(), py::call_guard<py::gil_scoped_release>())
      .def("locate", &locate, py::arg("points").noconvert(), py::arg("dimension"))
      .def("star", &star)
      .def("neighbours", &neighbours)
      .def("cells_of_box",
           [](const Questions& self, const std::vector<double>& box, std::uint64_t cells_max) {
             return run_interruptible(
                 [&](std::stop_token stop) { return self.cells_of_box(box, cells_max, std::move(stop)); });
           })
      .def("cells_of_polygons",
           [](const Questions& self, const std::string& geojson, std::uint64_t cells_max) {
             return run_interruptible(
                 [&](std::stop_token stop) { return self.cells_of_polygons(geojson, cells_max, std::move(stop)); });
           })
      .def("interpolate", &interpolate, py::arg("points").noconvert(), py::arg("value"), py::arg("natural"),
           py::arg("weights"));
}

}  // namespace tessera::python
