// Limits the length of incoming frames. CAF takes memory for a whole frame as soon as it has read the announced length.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

// The frames of one connection. A frame is a header of 32 bytes and a body. Bytes 4 to 7 of the header, from 0, are the
// length of the body, most significant first. The bytes under way are counted over all connections of the process. An
// object is not thread-safe.
class IncomingFrames {
 public:
  // The longest frame that is needed has a table or plan of millions of tiles. `together_max` bounds all frames under
  // way that are longer than `short_max`.
  static constexpr std::uint64_t frame_max = std::uint64_t{64} << 20, together_max = std::uint64_t{256} << 20;
  static constexpr std::uint64_t short_max = std::uint64_t{1} << 20;

  IncomingFrames() = default;
  IncomingFrames(const IncomingFrames&) = delete;
  IncomingFrames& operator=(const IncomingFrames&) = delete;
  ~IncomingFrames() { give_back(); }
  // Looks at bytes that have come. Returns false when a frame is too long: the connection must then be closed.
  bool take(std::span<const unsigned char> bytes);

 private:
  bool begin();
  void give_back();

  std::array<unsigned char, 32> header_{};
  std::size_t have_ = 0;       // bytes of the header that have come
  std::uint64_t left_ = 0;     // bytes of the body that have not come
  std::uint64_t counted_ = 0;  // how many of the bytes in under_way_ are those of this frame
  static std::atomic<std::uint64_t> under_way_;
};

}  // namespace tessera
