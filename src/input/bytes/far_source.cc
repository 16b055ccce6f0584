#include "src/input/bytes/far_source.h"

namespace tessera {

Status bring_near(const ByteSource& source, std::span<const ByteRange> ranges) {
  const auto* far = dynamic_cast<const FarSource*>(&source);
  if (far == nullptr || ranges.empty()) return success();
  return far->bring(ranges);
}

std::uint64_t near_bytes_max(const ByteSource& source) {
  const auto* far = dynamic_cast<const FarSource*>(&source);
  return far == nullptr ? 0 : far->near_bytes_max();
}

}  // namespace tessera
