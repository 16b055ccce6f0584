#include "tessera/triangulation.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/views.h"
#include "tessera/voids.h"

namespace tessera::python {
namespace {

// Returns a Python string, decoded as names of files are, because the text may contain such names.
py::str text_of(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape"));
}

// Returns triangulate(input, options), which Ctrl-C can end. `report` is a callable, or None, that gets the progress.
// The caller keeps `input` alive. Only the callbacks run with the GIL. An exception that `report` raises ends the job
// and comes out unchanged.
template <class Input>
Triangulation run(const Input& input, TriangulationOptions options, const py::object& report, const py::object& warn) {
  options.progress([&report](const JobProgress& p) {
    const py::gil_scoped_acquire acquire;
    check_signals();
    if (!report.is_none()) {
      report(p.phase, p.points_total, p.points_routed, p.points_triangulated, p.tiles_total, p.tiles_triangulated,
             p.tiles_stored, p.seconds);
    }
  });
  options.warning([&warn](const std::string& sentence) {
    const py::gil_scoped_acquire acquire;
    warn(text_of(sentence));
  });
  const py::gil_scoped_release release;
  return triangulate(input, options);
}

// Returns self.export_to(target, request), which Ctrl-C can end.
std::string export_to(const Triangulation& self, const std::filesystem::path& target, ExportRequest request) {
  request.progress([](double) {
    const py::gil_scoped_acquire acquire;
    check_signals();
  });
  const py::gil_scoped_release release;
  return self.export_to(target, request);
}

Proof verify(const Triangulation& self, VerifyRequest request) {
  return run_interruptible([&](std::stop_token stop) { return self.verify(request.stop(std::move(stop))); });
}

py::array points_view(const py::object& self) {
  const auto& tile = self.cast<const Tile&>();
  constexpr py::ssize_t size = sizeof(double);
  return view(py::dtype::of<double>(), tile.points().data(),
              {static_cast<py::ssize_t>(tile.points().size()) / 3, tile.dimension()}, {3 * size, size}, self);
}

// Returns flags as an array of bool. They are 0 or 1, so the bytes are the same.
py::array mask_view(std::span<const std::uint8_t> flags, const py::object& self) {
  return column_view(flags, self, py::dtype::of<bool>());
}

py::dict views_of(const std::vector<Tile::Field>& fields, const py::object& self) {
  py::dict views;
  for (const auto& field : fields) views[py::str(field.name)] = column_view(field.values, self, py::dtype(field.type));
  return views;
}

py::list columns_of(const Triangulation& self) {
  py::list columns;
  for (const auto& column : self.columns()) {
    py::dict one;
    one["name"] = column.name;
    one["of"] = column.of_cells ? "cells" : "vertices";
    one["type"] = column.type;
    one["unit"] = text_of(column.unit);
    one["version"] = column.version;
    columns.append(one);
  }
  return columns;
}

py::tuple measure(Triangulation& self, MeasureRequest request) {
  const MeasureReport report =
      run_interruptible([&](std::stop_token stop) { return self.measure(request.stop(std::move(stop))); });
  return py::make_tuple(report.total, text_of(report.unit), report.made, text_of(report.note));
}

// Returns (structured array, column, whether it was made, vertices in no zone).
py::tuple find_voids(Triangulation& self, const std::string& by, const std::filesystem::path& target, bool overwrite,
                     std::uint64_t memory_bytes, unsigned threads) {
  VoidsRequest request;
  request.by(by).output(target).overwrite(overwrite).memory_bytes(memory_bytes).threads(threads);
  const FoundVoids found =
      run_interruptible([&](std::stop_token stop) { return self.find_voids(request.stop(std::move(stop))); });
  return py::make_tuple(py::array_t<FoundVoid>(static_cast<py::ssize_t>(found.voids.size()), found.voids.data()),
                        text_of(found.column), found.made, found.outside);
}

void bind_tile(py::module_& module) {
  py::class_<Tile>(module, "Tile")
      .def_property_readonly("id", &Tile::id)
      .def_property_readonly("dimension", &Tile::dimension)
      .def_property_readonly("points", &points_view)
      // Ranks are below 2^63. They are signed here, because NumPy turns uint64 together with int64 into float64.
      .def_property_readonly("ids",
                             [](const py::object& self) {
                               return column_view(self.cast<const Tile&>().ids(), self, py::dtype::of<std::int64_t>());
                             })
      .def_property_readonly("foreign",
                             [](const py::object& self) { return mask_view(self.cast<const Tile&>().foreign(), self); })
      .def_property_readonly(
          "offsets", [](const py::object& self) { return rows_view(self.cast<const Tile&>().offsets(), 3, self); })
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
      .def_property_readonly(
          "attributes", [](const py::object& self) { return views_of(self.cast<const Tile&>().attributes(), self); })
      .def_property_readonly("cell_columns", [](const py::object& self) {
        return views_of(self.cast<const Tile&>().cell_columns(), self);
      });
}

}  // namespace

void bind_triangulation(py::module_& module) {
  bind_tile(module);

  bind_options(module);

  PYBIND11_NUMPY_DTYPE(FoundVoid, zone, core_density, x, y, z, zone_points, zone_volume, saddle_vertex, saddle_density,
                       parent, void_zones, void_points, void_volume, contrast, probability);
  const py::call_guard<py::gil_scoped_release> without_gil;
  py::class_<Triangulation>(module, "Triangulation")
      .def_static("open", py::overload_cast<const std::filesystem::path&>(&Triangulation::open), without_gil)
      .def_static("open", py::overload_cast<const std::filesystem::path&, std::uint32_t>(&Triangulation::open),
                  without_gil)
      .def_property_readonly("folder", &Triangulation::folder)
      .def_property_readonly("dimension", &Triangulation::dimension)
      .def_property_readonly("vertices", &Triangulation::vertices)
      .def_property_readonly("cells", &Triangulation::cells)
      .def_property_readonly("points_read", &Triangulation::points_read)
      .def_property_readonly("duplicates", &Triangulation::duplicates)
      .def_property_readonly("duplicates_at_other_heights", &Triangulation::duplicates_at_other_heights)
      .def_property_readonly("digest", &Triangulation::digest)
      .def_property_readonly("crs", &Triangulation::crs)
      .def_property_readonly("period", &Triangulation::period)
      .def_property_readonly("tiles", &Triangulation::tiles)
      .def("tile", &Triangulation::tile, without_gil)
      .def("export_to", &export_to)
      .def("verify", &verify)
      .def("columns", &columns_of)
      .def("measure", &measure)
      .def("find_voids", &find_voids)
      .def("describe", [](const Triangulation& self) { return text_of(self.describe()); });
  py::class_<Proof>(module, "Proof")
      .def_property_readonly("cells", &Proof::cells)
      .def_property_readonly("facets", &Proof::facets)
      .def_property_readonly("hull_facets", &Proof::hull_facets)
      .def_property_readonly("vertices", &Proof::vertices)
      .def_property_readonly("checks", &Proof::checks);

  module.def(
      "triangulate_points",
      [](const Coordinates& points, const TriangulationOptions& options, const py::object& report,
         const py::object& warn) { return run(span_of(points), options, report, warn); },
      py::arg("points").noconvert(), py::arg("options"), py::arg("report"), py::arg("warn"));
  module.def(
      "triangulate_records", [](const py::array& rows, const std::string& columns, const TriangulationOptions& options,
                                const py::object& report, const py::object& warn) {
        const Records records{{static_cast<const std::byte*>(rows.data()), static_cast<std::size_t>(rows.nbytes())},
                              static_cast<std::uint64_t>(rows.size()),
                              columns};
        return run(records, options, report, warn);
      });
  module.def("file_checksum", &file_checksum, without_gil);
  module.def("triangulate_files", &run<std::vector<std::string>>);
  module.def("describe", [](const std::vector<std::string>& inputs, const TriangulationOptions& options) {
    return text_of(run_interruptible(
        [&](std::stop_token stop) { return describe(inputs, TriangulationOptions(options).stop(std::move(stop))); }));
  });
}

}  // namespace tessera::python
