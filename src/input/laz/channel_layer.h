// The common part of all layers except the first: a stream, and a state for each scanner channel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "src/input/laz/arithmetic_decoder.h"

namespace tessera::laz {

// What the first layer says about a point. The other layers use it for predictions.
struct PointStep {
  std::uint8_t channel = 0;    // the scanner channel, 0-3
  bool new_channel = false;    // the point before has another channel
  std::uint8_t placement = 0;  // 3: single return, 2: first of several, 1: last, 0: in between
  std::uint8_t level = 0;      // see return_level()
  std::uint8_t z_context = 0;
  bool new_time = false, new_angle = false, new_source = false;  // compared with the last point of the channel
};

// The channel of which a point counts in a layer of version 3 or 4: see ChannelLayer.
inline unsigned item_channel(const PointStep& step, bool version_3) {
  return version_3 && !step.new_channel ? 0 : step.channel;
}

// A layer after the first.
class Layer {
 public:
  virtual ~Layer() = default;
  // Writes the layer's field into steps.size() records, `stride` bytes each.
  virtual void decode(std::span<const PointStep> steps, std::byte* records, std::size_t stride) = 0;
  // Null for an empty layer.
  virtual const ByteFeed* feed() const = 0;
};

// A layer whose `State` has the models of one channel. Value next(decoder, step, last) returns the value after `last`,
// and State(Value) begins a channel. A channel that is new begins with the last value of the channel before it. In an
// empty layer all values are that of the first point. in_record(value, step), if State has it, adds what the first
// layer says.
template <class State>
class ChannelLayer : public Layer {
 public:
  using Value = typename State::Value;

  // `first` is the value of the chunk's first point, which is of `channel`. `at` is the offset of the field in a
  // record. `version_3` is for colours and extra bytes. LASzip writes version 3 with two mistakes, because of which
  // version 4 exists. A point counts as one of channel 0 unless its channel is another than that of the point before.
  // And at a change to a channel that was seen before, the last value is that of the channel that is left, and the new
  // value is stored there.
  ChannelLayer(ByteFeed feed, Value first, unsigned channel, std::size_t at, bool version_3)
      : empty_(feed.position() == feed.end()), at_(at), version_3_(version_3), current_(channel), first_(first) {
    if (empty_) return;
    decoder_ = ArithmeticDecoder(std::move(feed));
    channels_[channel] = std::make_unique<Channel>(first);
  }

  void decode(std::span<const PointStep> steps, std::byte* records, std::size_t stride) override {
    std::byte* to = records + at_;
    for (const auto& step : steps) {
      Value value = empty_ ? first_ : next(step);
      if constexpr (requires { State::in_record(value, step); }) value = State::in_record(value, step);
      std::memcpy(to, &value, sizeof value);
      to += stride;
    }
  }

  const ByteFeed* feed() const override { return empty_ ? nullptr : &decoder_.feed(); }

 private:
  struct Channel {
    explicit Channel(Value v) : state(v), last(v) {}
    State state;
    Value last;
  };

  Value next(const PointStep& step) {
    const unsigned channel = item_channel(step, version_3_);
    if (channel == current_) [[likely]] {
      Channel& c = *channels_[current_];
      return c.last = c.state.next(decoder_, step, c.last);
    }
    Channel& left = *channels_[current_];
    current_ = channel;
    auto& entered = channels_[current_];
    const bool seen = entered != nullptr;
    if (!seen) entered = std::make_unique<Channel>(left.last);
    Channel& from = seen && version_3_ ? left : *entered;
    const Value value = entered->state.next(decoder_, step, from.last);
    return from.last = value;
  }

  bool empty_;
  std::size_t at_;
  bool version_3_;
  unsigned current_;
  Value first_;
  ArithmeticDecoder decoder_;
  std::array<std::unique_ptr<Channel>, 4> channels_;
};

}  // namespace tessera::laz
