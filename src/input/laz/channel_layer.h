// What all layers but the first have in common: a stream, and a state for each scanner channel.
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

// What the first layer says of a point that the others are predicted from.
struct PointStep {
  std::uint8_t channel = 0;    // of the scanner, 0-3
  std::uint8_t placement = 0;  // 3 single, 2 first of several, 1 last, 0 between
  std::uint8_t level = 0;      // return_level()
  std::uint8_t z_context = 0;
  bool new_time = false, new_angle = false, new_source = false;  // compared to the last point of the channel
};

// A layer other than the first.
class Layer {
 public:
  virtual ~Layer() = default;
  // Writes its field into as many records as there are `steps`.
  virtual void decode(std::span<const PointStep> steps, std::byte* records, std::size_t stride) = 0;
  // Null for an empty layer.
  virtual const ByteFeed* feed() const = 0;
  // Whether its field is one of the extra bytes.
  virtual bool extra_byte() const = 0;
};

// `State` has the models of one channel: Value next(decoder, step, last) gives the value after `last`, and
// State(Value) begins a channel. A channel that appears first takes the last value of the channel before it. An empty
// layer says that all values are that of the first point. in_record(value, step), if there is one, adds what the first
// layer has said.
template <class State>
class ChannelLayer : public Layer {
 public:
  using Value = typename State::Value;

  // `first`: the value of the chunk's first point, of `channel`; `at`: of the field in a record. `version_3`: colours
  // and extra bytes of version 3 take, at a change to a channel already seen, the last value of the channel that is
  // left, and put the new one there; files were written so, and version 4 exists because of it.
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
  bool extra_byte() const override { return State::extra_byte; }

 private:
  struct Channel {
    explicit Channel(Value v) : state(v), last(v) {}
    State state;
    Value last;
  };

  Value next(const PointStep& step) {
    if (step.channel == current_) [[likely]] {
      Channel& c = *channels_[current_];
      return c.last = c.state.next(decoder_, step, c.last);
    }
    Channel& left = *channels_[current_];
    current_ = step.channel;
    auto& entered = channels_[current_];
    const bool seen = entered != nullptr;
    if (!seen) entered = std::make_unique<Channel>(left.last);
    Channel& from = seen && version_3_ ? left : *entered;
    const Value value = entered->state.next(decoder_, step, from.last);
    return (State::keeps_own_last ? *entered : from).last = value;
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
