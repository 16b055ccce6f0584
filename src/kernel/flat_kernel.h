// Our own kernels, on flat arrays (docs/kernel.md).
#pragma once

#include <memory>

#include "src/kernel/kernel.h"

namespace tessera {

std::unique_ptr<Kernel> make_flat_kernel_2();
std::unique_ptr<Kernel> make_flat_kernel_3();
// The same without vector instructions: for tests, and what machines without them get.
std::unique_ptr<Kernel> make_plain_flat_kernel_3();

}  // namespace tessera
