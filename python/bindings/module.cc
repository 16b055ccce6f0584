#include "python/bindings/bindings.h"
#include "tessera/version.h"

PYBIND11_MODULE(_tessera, module) {
  module.def("version", &tessera::library_version);
  tessera::python::bind_failures();
  tessera::python::bind_delaunay(module);
  tessera::python::bind_triangulation(module);
  tessera::python::bind_questions(module);
  tessera::python::bind_surfaces(module);
  tessera::python::bind_update(module);
  tessera::python::bind_volumes(module);
  tessera::python::bind_voronoi(module);
  tessera::python::bind_alpha(module);
}
