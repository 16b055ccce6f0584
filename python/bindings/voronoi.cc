// Binds Voronoi cells.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "tessera/voronoi.h"

namespace tessera::python {
namespace {

namespace py = pybind11;

VoronoiRequest voronoi_request(std::uint64_t memory, unsigned threads, bool overwrite) {
  VoronoiRequest request;
  request.memory_bytes(memory).threads(threads).overwrite(overwrite);
  return request;
}

// Returns (cells, unbounded, outside, size, note).
py::tuple write_voronoi_cells(const Triangulation& self, const std::filesystem::path& target, VoronoiRequest request) {
  const auto written = run_interruptible(
      [&](std::stop_token stop) { return write_voronoi(self, target, request.stop(std::move(stop))); });
  return py::make_tuple(written.cells, written.unbounded, written.outside, written.size, written.note);
}

}  // namespace

void bind_voronoi(py::module_& module) {
  py::class_<VoronoiRequest>(module, "VoronoiRequest")
      .def(py::init(&voronoi_request))
      .def("clip_to_hull", [](VoronoiRequest& self) { self.clip_to_hull(); })
      .def("clip_to_nothing", [](VoronoiRequest& self) { self.clip_to_nothing(); })
      .def("clip_to_box", [](VoronoiRequest& self, const std::vector<double>& box) { self.clip_to_box(box); })
      .def("clip_to_file",
           [](VoronoiRequest& self, const std::filesystem::path& polygons) { self.clip_to_file(polygons); });
  module.def("write_voronoi", &write_voronoi_cells);
}

}  // namespace tessera::python
