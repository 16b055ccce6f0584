// The extension module tessera._tessera, which binds the public C++ library as it is. Python users use the package in
// python/tessera, which checks arguments and has docstrings.
#pragma once

#include <pybind11/pybind11.h>

namespace tessera::python {

void bind_alpha(pybind11::module_& module);
void bind_failures();
void bind_options(pybind11::module_& module);
void bind_delaunay(pybind11::module_& module);
void bind_questions(pybind11::module_& module);
void bind_surfaces(pybind11::module_& module);
void bind_triangulation(pybind11::module_& module);
void bind_update(pybind11::module_& module);
void bind_volumes(pybind11::module_& module);
void bind_voronoi(pybind11::module_& module);

}  // namespace tessera::python
