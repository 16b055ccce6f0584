#include "tessera/triangulation.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/views.h"

namespace tessera::python {
namespace {

// triangulate(), with `report` (a callable, or None) told of the progress, and Ctrl-C heeded. `input` belongs to the
// caller, who keeps it; only `report` runs with the GIL. What it raises unwinds the engine and comes out as it is.
template <class Input>
Triangulation run(const Input& input, TriangulationOptions options, const py::object& report) {
  options.progress = [&report](const JobProgress& p) {
    const py::gil_scoped_acquire acquire;
    check_signals();
    if (!report.is_none()) {
      report(p.phase, p.points_total, p.points_routed, p.points_triangulated, p.tiles_total, p.tiles_triangulated,
             p.tiles_stored, p.seconds);
    }
  };
  const py::gil_scoped_release release;
  return triangulate(input, options);
}

// Triangulation::export_to() with Ctrl-C heeded.
std::string export_to(const Triangulation& self, const std::filesystem::path& target, const std::string& format,
                      bool heights, bool overwrite) {
  const ExportRequest request{.format = format, .heights = heights, .overwrite = overwrite, .progress = [](double) {
                                const py::gil_scoped_acquire acquire;
                                check_signals();
                              }};
  const py::gil_scoped_release release;
  return self.export_to(target, request);
}

py::array points_view(const py::object& self) {
  const auto& tile = self.cast<const Tile&>();
  constexpr py::ssize_t size = sizeof(double);
  return view(py::dtype::of<double>(), tile.points().data(),
              {static_cast<py::ssize_t>(tile.points().size()) / 3, tile.dimension()}, {3 * size, size}, self);
}

// Flags are 0 or 1, so that they can be masks.
py::array mask_view(std::span<const std::uint8_t> flags, const py::object& self) {
  return column_view(flags, self, py::dtype::of<bool>());
}

py::dict attributes_of(const py::object& self) {
  py::dict attributes;
  for (const auto& field : self.cast<const Tile&>().attributes()) {
    attributes[py::str(field.name)] = column_view(field.values, self, py::dtype(field.type));
  }
  return attributes;
}

void bind_tile(py::module_& module) {
  py::class_<Tile>(module, "Tile")
      .def_property_readonly("id", &Tile::id)
      .def_property_readonly("dimension", &Tile::dimension)
      .def_property_readonly("points", &points_view)
      // Ranks are under 2^63. Signed, because NumPy makes float64 of uint64 with int64.
      .def_property_readonly("ids",
                             [](const py::object& self) {
                               return column_view(self.cast<const Tile&>().ids(), self, py::dtype::of<std::int64_t>());
                             })
      .def_property_readonly("foreign",
                             [](const py::object& self) { return mask_view(self.cast<const Tile&>().foreign(), self); })
      .def_property_readonly("cells",
                             [](const py::object& self) {
                               const auto& tile = self.cast<const Tile&>();
                               return rows_view(tile.cells(), tile.dimension() + 1, self);
                             })
      .def_property_readonly("ghost",
                             [](const py::object& self) { return mask_view(self.cast<const Tile&>().ghost(), self); })
      .def_property_readonly("neighbors",
                             [](const py::object& self) {
                               const auto& tile = self.cast<const Tile&>();
                               return rows_view(tile.neighbors(), tile.dimension() + 1, self);
                             })
      .def_property_readonly("attributes", &attributes_of);
}

}  // namespace

void bind_triangulation(py::module_& module) {
  bind_tile(module);

  py::class_<TriangulationOptions>(module, "Options")
      .def(py::init<>())
      .def_readwrite("dimension", &TriangulationOptions::dimension)
      .def_readwrite("folder", &TriangulationOptions::folder)
      .def_readwrite("overwrite", &TriangulationOptions::overwrite)
      .def_readwrite("max_points_per_tile", &TriangulationOptions::max_points_per_tile)
      .def_readwrite("threads", &TriangulationOptions::threads)
      .def_readwrite("memory_bytes", &TriangulationOptions::memory_bytes)
      .def_readwrite("neighbors", &TriangulationOptions::neighbors)
      .def_readwrite("skip_invalid", &TriangulationOptions::skip_invalid)
      .def_readwrite("recursive", &TriangulationOptions::recursive)
      .def_readwrite("attributes", &TriangulationOptions::attributes);

  const py::call_guard<py::gil_scoped_release> without_gil;
  py::class_<Triangulation>(module, "Triangulation")
      .def_static("open", &Triangulation::open, without_gil)
      .def_property_readonly("folder", &Triangulation::folder)
      .def_property_readonly("dimension", &Triangulation::dimension)
      .def_property_readonly("vertices", &Triangulation::vertices)
      .def_property_readonly("cells", &Triangulation::cells)
      .def_property_readonly("points_read", &Triangulation::points_read)
      .def_property_readonly("duplicates", &Triangulation::duplicates)
      .def_property_readonly("digest", &Triangulation::digest)
      .def_property_readonly("crs", &Triangulation::crs)
      .def_property_readonly("tiles", &Triangulation::tiles)
      .def("tile", &Triangulation::tile, without_gil)
      .def("export_to", &export_to);

  module.def(
      "triangulate_points",
      [](const Coordinates& points, const TriangulationOptions& options, const py::object& report) {
        return run(span_of(points), options, report);
      },
      py::arg("points").noconvert(), py::arg("options"), py::arg("report"));
  module.def("triangulate_files", &run<std::vector<std::string>>);
}

}  // namespace tessera::python
