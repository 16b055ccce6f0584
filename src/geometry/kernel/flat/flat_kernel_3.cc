#include "src/geometry/kernel/flat/flat_kernel.h"

#include "src/geometry/kernel/flat/explore_impl.h"
#include "src/geometry/kernel/flat/image_impl.h"
#include "src/geometry/kernel/flat/mesh_3.h"

namespace tessera {

std::unique_ptr<Kernel> make_flat_kernel_3(const FlatOptions& options) {
  return std::make_unique<flat::FlatKernel<flat3::Mesh>>(options);
}

}  // namespace tessera
