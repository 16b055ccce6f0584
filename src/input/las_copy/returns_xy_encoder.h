// The first layer of point formats 6 to 8; see ReturnsXyLayer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/input/las_copy/integer_encoder.h"
#include "src/input/laz/channel_layer.h"
#include "src/input/laz/prediction.h"

namespace tessera::laz {

class ReturnsXyEncoder {
 public:
  // `first` is the record of the chunk's first point.
  explicit ReturnsXyEncoder(const std::byte* first);

  // Encodes the next points, steps.size() records of `stride` bytes. Fills `steps` with what the other layers use.
  void encode(std::span<PointStep> steps, const std::byte* records, std::size_t stride);
  std::vector<std::byte> finish() { return encoder_.finish(); }

 private:
  // The last point of a scanner channel.
  struct LastPoint {
    std::int32_t x = 0, y = 0;
    std::uint8_t returns = 0, number = 0;
    std::int16_t angle = 0;
    std::uint16_t source = 0;
    std::int64_t time = 0;
  };
  struct Channel {
    LastPoint last;
    std::array<RunningMedian, 12> dx, dy;  // by the kind of return, and by whether the GPS time is new
    SymbolModel<3> next_channel;
    std::array<SymbolModel<16>, 16> returns_after, number_after;
    SymbolModel<13> number_at_same_time;
    std::array<SymbolModel<128>, 8> changes;
    IntegerEncoder<32, 2> x_differences;
    IntegerEncoder<32, 22> y_differences;
  };

  static LastPoint point_of(const std::byte* record);
  void next(PointStep& step, const std::byte* record);
  void put_changes(const PointStep& step, const LastPoint& point, const LastPoint& last, std::uint32_t context);
  void put_xy(Channel& c, PointStep& step, const LastPoint& point);

  ArithmeticEncoder encoder_;
  std::uint32_t current_;
  std::array<std::unique_ptr<Channel>, 4> channels_;
  bool last_time_was_new_ = false;
};

}  // namespace tessera::laz
