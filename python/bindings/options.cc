// Binds the option classes as they are, except that their functions return nothing here.
#include "tessera/options.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/bindings/bindings.h"

namespace tessera::python {
namespace {

namespace py = pybind11;

template <class Options, class Value>
auto setter(Options& (Options::*set)(Value)) {
  return [set](Options& options, std::remove_cvref_t<Value> value) { (options.*set)(std::move(value)); };
}

}  // namespace

void bind_options(py::module_& module) {
  using Options = TriangulationOptions;
  py::class_<Options>(module, "Options")
      .def(py::init<>())
      .def("dimension", setter(&Options::dimension))
      .def("folder", setter(&Options::folder))
      .def("overwrite", setter(&Options::overwrite))
      .def("resume", setter(&Options::resume))
      .def("max_points_per_tile", setter(&Options::max_points_per_tile))
      .def("tiles", setter(&Options::tiles))
      .def("partition", setter(&Options::partition))
      .def("threads", setter(&Options::threads))
      .def("memory_bytes", setter(&Options::memory_bytes))
      .def("neighbors", setter(&Options::neighbors))
      .def("skip_invalid", setter(&Options::skip_invalid))
      .def("crop", setter(&Options::crop))
      .def("periodic", setter(&Options::periodic))
      .def("periodic_files", setter(&Options::periodic_files))
      .def("periodic_snap", setter(&Options::periodic_snap))
      .def("crs", setter(&Options::crs))
      .def("heights", setter(&Options::heights))
      .def("classes", setter(&Options::classes))
      .def("scans", setter(&Options::scans))
      .def("returns", setter(&Options::returns))
      .def("without", setter(&Options::without))
      .def("keep", setter(&Options::keep))
      .def("store", setter(&Options::store))
      .def("columns", setter(&Options::columns))
      .def("resolution", setter(&Options::resolution))
      .def("attributes", setter(&Options::attributes))
      .def("recursive", setter(&Options::recursive))
      .def("input_list", setter(&Options::input_list))
      .def("endpoint", setter(&Options::endpoint))
      .def("profile", setter(&Options::profile))
      .def("anonymous", setter(&Options::anonymous))
      .def("requester_pays", setter(&Options::requester_pays));
  py::class_<ExportRequest>(module, "ExportRequest")
      .def(py::init<>())
      .def("format", setter(&ExportRequest::format))
      .def("heights", setter(&ExportRequest::heights))
      .def("index", setter(&ExportRequest::index))
      .def("local", setter(&ExportRequest::local))
      .def("max_edge", setter(&ExportRequest::max_edge))
      .def("max_radius", setter(&ExportRequest::max_radius))
      .def("names", setter(&ExportRequest::names))
      .def("overwrite", setter(&ExportRequest::overwrite));
  py::class_<VerifyRequest>(module, "VerifyRequest")
      .def(py::init<>())
      .def("memory_bytes", setter(&VerifyRequest::memory_bytes))
      .def("scratch", setter(&VerifyRequest::scratch))
      .def("against_cgal", setter(&VerifyRequest::against_cgal));
  py::class_<MeasureRequest>(module, "MeasureRequest")
      .def(py::init<>())
      .def("volume", setter(&MeasureRequest::volume))
      .def("quality", setter(&MeasureRequest::quality))
      .def("voronoi", setter(&MeasureRequest::voronoi))
      .def("density", setter(&MeasureRequest::density))
      .def("mass", setter(&MeasureRequest::mass))
      .def("memory_bytes", setter(&MeasureRequest::memory_bytes))
      .def("threads", setter(&MeasureRequest::threads));
}

}  // namespace tessera::python
