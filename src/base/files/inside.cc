#include "src/base/files/inside.h"

#include <algorithm>
#include <system_error>

namespace tessera {

Status check_inside(const std::filesystem::path& folder, const std::filesystem::path& path) {
  std::error_code failed;
  const auto real = [&](const std::filesystem::path& named) {
    const auto absolute = std::filesystem::absolute(named, failed);
    return failed ? std::filesystem::path() : std::filesystem::weakly_canonical(absolute, failed);
  };
  const auto outside = [&] { return error(Errc::usage, path.string() + ": lies outside " + folder.string()); };
  if (path.empty()) return outside();
  const auto outer = real(folder), inner = real(path);
  if (failed) return error(Errc::io, path.string() + ": cannot be examined: " + failed.message());
  const auto [at_outer, at_inner] = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
  if (at_outer == outer.end() && at_inner != inner.end()) return success();
  return outside();
}

}  // namespace tessera
