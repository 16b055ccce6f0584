#include "src/kernel/flat_explore_impl.h"
#include "src/kernel/flat_image_impl.h"
#include "src/kernel/flat_kernel.h"
#include "src/kernel/flat_mesh_3.h"

namespace tessera {

std::unique_ptr<Kernel> make_flat_kernel_3() { return std::make_unique<flat::FlatKernel<flat3::Mesh>>(); }
std::unique_ptr<Kernel> make_plain_flat_kernel_3() { return std::make_unique<flat::FlatKernel<flat3::Mesh>>(false); }

}  // namespace tessera
