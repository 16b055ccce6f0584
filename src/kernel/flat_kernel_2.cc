#include "src/kernel/flat_explore_impl.h"
#include "src/kernel/flat_image_impl.h"
#include "src/kernel/flat_kernel.h"
#include "src/kernel/flat_mesh_2.h"

namespace tessera {

std::unique_ptr<Kernel> make_flat_kernel_2() { return std::make_unique<flat::FlatKernel<flat2::Mesh>>(); }

}  // namespace tessera
