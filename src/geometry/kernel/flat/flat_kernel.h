// Tessera's own kernels, on flat arrays (docs/kernel.md).
#pragma once

#include <cstdint>
#include <memory>

#include "src/geometry/kernel/kernel.h"

namespace tessera {

// Options for tests: kernels as on other machines, and kernels that are full early.
struct FlatOptions {
  bool vectors = true;  // use vector instructions in 3D where the processor has them
  // A limit above what indices can number has no effect.
  std::uint32_t vertices_max = ~std::uint32_t{0}, cells_max = ~std::uint32_t{0};
};

std::unique_ptr<Kernel> make_flat_kernel_2(const FlatOptions& options = {});
std::unique_ptr<Kernel> make_flat_kernel_3(const FlatOptions& options = {});

}  // namespace tessera
