// CGAL's triangulations behind the Kernel interface. Each has a translation unit of its own, because both take long to
// compile.
#pragma once

#include <memory>

#include "src/geometry/kernel/kernel.h"

namespace tessera {

std::unique_ptr<Kernel> make_cgal_kernel_2();
std::unique_ptr<Kernel> make_cgal_kernel_3();

}  // namespace tessera
