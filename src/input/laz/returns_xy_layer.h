// The first layer of point formats 6 to 8, on which all others depend: channel, returns, changes, x and y.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "src/input/laz/arithmetic_decoder.h"
#include "src/input/laz/channel_layer.h"
#include "src/input/laz/integer_decoder.h"
#include "src/input/laz/prediction.h"

namespace tessera::laz {

class ReturnsXyLayer {
 public:
  // `first` is the record of the chunk's first point.
  ReturnsXyLayer(ByteFeed feed, const std::byte* first);

  // Decodes the next points. x, y, returns and channel go into records (`stride` bytes each), the rest into `steps`.
  void decode(std::span<PointStep> steps, std::byte* records, std::size_t stride);

  const ByteFeed& feed() const { return decoder_.feed(); }

 private:
  struct Channel {
    std::int32_t x = 0, y = 0;
    std::uint8_t returns = 0, number = 0;  // of the channel's last point
    std::array<RunningMedian, 12> dx, dy;  // by the kind of return, and by whether the GPS time is new
    SymbolModel<3> next_channel;
    std::array<SymbolModel<16>, 16> returns_after, number_after;
    SymbolModel<13> number_at_same_time;
    std::array<SymbolModel<128>, 8> changes;
    IntegerDecoder<32, 2> x_differences;
    IntegerDecoder<32, 22> y_differences;
  };

  void next(PointStep& step, std::byte* record);
  void enter_channel(std::uint32_t channel);

  ArithmeticDecoder decoder_;
  std::uint32_t current_;
  std::array<std::unique_ptr<Channel>, 4> channels_;
  bool last_time_was_new_ = false;
};

}  // namespace tessera::laz
