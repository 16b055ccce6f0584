#include "actors/cluster/frames.h"

#include <algorithm>

namespace tessera {

std::atomic<std::uint64_t> IncomingFrames::under_way_{0};

bool IncomingFrames::take(std::span<const unsigned char> bytes) {
  while (!bytes.empty()) {
    if (left_ > 0) {
      const std::size_t of_this = std::min<std::uint64_t>(left_, bytes.size());
      left_ -= of_this;
      bytes = bytes.subspan(of_this);
      if (left_ == 0) give_back();
      continue;
    }
    const std::size_t of_header = std::min(header_.size() - have_, bytes.size());
    std::copy_n(bytes.begin(), of_header, header_.begin() + static_cast<std::ptrdiff_t>(have_));
    have_ += of_header;
    bytes = bytes.subspan(of_header);
    if (have_ == header_.size() && !begin()) return false;
  }
  return true;
}

// Called when the header is there.
bool IncomingFrames::begin() {
  have_ = 0;
  left_ = 0;
  for (std::size_t i = 4; i < 8; ++i) left_ = left_ << 8 | header_[i];
  if (left_ > frame_max) return false;
  if (left_ <= short_max) return true;
  counted_ = left_;
  return under_way_.fetch_add(counted_) + counted_ <= together_max;
}

void IncomingFrames::give_back() {
  under_way_ -= counted_;
  counted_ = 0;
}

}  // namespace tessera
