// How long the frames are that others announce: CAF takes memory for all of one as soon as it has read how long it is.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

// What comes over one connection. A frame: 32 bytes, of which those from the fifth on are the length of what follows,
// most significant first; then that.
class IncomingFrames {
 public:
  // Tables and plans of millions of tiles are the longest; all that are under way together, but short ones.
  static constexpr std::uint64_t frame_max = std::uint64_t{64} << 20, together_max = std::uint64_t{256} << 20;
  static constexpr std::uint64_t short_max = std::uint64_t{1} << 20;

  IncomingFrames() = default;
  IncomingFrames(const IncomingFrames&) = delete;
  IncomingFrames& operator=(const IncomingFrames&) = delete;
  ~IncomingFrames() { give_back(); }
  // False: one of them is too long, and the connection must end.
  bool take(std::span<const unsigned char> bytes);

 private:
  bool begin();
  void give_back();

  std::array<unsigned char, 32> header_{};
  std::size_t have_ = 0;       // of the header
  std::uint64_t left_ = 0;     // of what follows it
  std::uint64_t counted_ = 0;  // of this one, in all that are under way
  static std::atomic<std::uint64_t> under_way_;
};

}  // namespace tessera
