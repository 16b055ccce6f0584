// Our own kernel in 2D, on flat arrays.
#pragma once

#include <memory>

#include "src/kernel/kernel.h"

namespace tessera {

std::unique_ptr<Kernel> make_flat_kernel_2();

}  // namespace tessera
