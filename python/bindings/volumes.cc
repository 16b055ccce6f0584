// Binds volumes between surfaces.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <utility>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "tessera/volumes.h"

namespace py = pybind11;

namespace tessera::python {
namespace {

using File = std::optional<std::filesystem::path>;

VolumeRequest volume_request(std::optional<double> plane, const File& base, const File& within, const std::string& name,
                             std::optional<double> max_edge, std::optional<double> max_radius,
                             const std::string& value) {
  VolumeRequest request;
  if (plane) request.plane(*plane);
  if (base) request.base(*base);
  if (within) request.within(*within);
  if (max_edge) request.max_edge(*max_edge);
  if (max_radius) request.max_radius(*max_radius);
  request.name(name).value(value);
  return request;
}

// Returns (columns by name, unit of areas, unit of volumes, note).
py::tuple volumes(const Triangulation& a, const Triangulation* b, VolumeRequest request) {
  auto table = run_interruptible([&](std::stop_token stop) {
    request.stop(std::move(stop));
    return b == nullptr ? compute_volumes(a, request) : compute_volumes(a, *b, request);
  });
  py::dict columns;
  if (!table.polygons.empty()) {
    columns["polygon"] = table.polygons;
    columns["name"] = table.names;
  }
  columns["cut"] = table.cut;
  columns["fill"] = table.fill;
  columns["net"] = table.net;
  columns["mean"] = table.mean;
  columns["area"] = table.area;
  columns["covered"] = table.covered;
  columns["uncovered"] = table.uncovered;
  columns["uncovered_by_a"] = table.uncovered_by_a;
  columns["uncovered_by_b"] = table.uncovered_by_b;
  return py::make_tuple(std::move(columns), table.area_unit, table.volume_unit, table.note);
}

void write_difference(const Triangulation& a, const Triangulation* b, const std::filesystem::path& target, double res,
                      VolumeRequest request, bool overwrite) {
  request.overwrite(overwrite);
  run_interruptible([&](std::stop_token stop) {
    request.stop(std::move(stop));
    if (b == nullptr)
      write_difference_raster(a, target, res, request);
    else
      write_difference_raster(a, *b, target, res, request);
    return true;
  });
}

}  // namespace

void bind_volumes(py::module_& module) {
  py::class_<VolumeRequest>(module, "VolumeRequest").def(py::init(&volume_request));
  module.def("volumes", &volumes);
  module.def("write_difference", &write_difference);
}

}  // namespace tessera::python
