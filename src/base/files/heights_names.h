// The name of what the process hag writes.
#pragma once

#include <filesystem>

#include "src/base/files/names.h"

namespace tessera {

// The folder of copies with heights, among the exports of the ground, unless another name is asked for.
inline std::filesystem::path heights_of_result(const std::filesystem::path& out) {
  return exports_folder(out) / "heights";
}

}  // namespace tessera
