#include "src/geometry/kernel/kernel.h"

#include <cassert>

#include "src/geometry/kernel/cgal/cgal_kernels.h"
#include "src/geometry/kernel/flat/flat_kernel.h"

namespace tessera {

std::unique_ptr<Kernel> make_kernel(int dimension, KernelKind kind) {
  assert(dimension == 2 || dimension == 3);
  switch (kind) {
    case KernelKind::cgal:
      return dimension == 2 ? make_cgal_kernel_2() : make_cgal_kernel_3();
    case KernelKind::flat:
      return dimension == 2 ? make_flat_kernel_2() : make_flat_kernel_3();
  }
  return nullptr;
}

}  // namespace tessera
