// Our own kernels, on flat arrays (docs/kernel.md).
#pragma once

#include <cstdint>
#include <memory>

#include "src/geometry/kernel/kernel.h"

namespace tessera {

// For tests: what other machines have, and tiles that are too large.
struct FlatOptions {
  bool vectors = true;  // use vector instructions, in 3D, where the processor has them
  std::uint32_t vertices_max = ~std::uint32_t{0}, cells_max = ~std::uint32_t{0};  // at most what indices can number
};

std::unique_ptr<Kernel> make_flat_kernel_2(const FlatOptions& options = {});
std::unique_ptr<Kernel> make_flat_kernel_3(const FlatOptions& options = {});

}  // namespace tessera
