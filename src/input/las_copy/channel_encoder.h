// The layers of point formats 6 to 8 after the first, one class for each field; see ChannelLayer and layer_states.h.
// Source: LASzip, design/specification.rst; rapidlasso, LAZ Specification 1.4.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "src/input/bytes/fields.h"
#include "src/input/las_copy/colour_encoder.h"
#include "src/input/las_copy/gps_time_encoder.h"
#include "src/input/las_copy/integer_encoder.h"
#include "src/input/laz/channel_layer.h"

namespace tessera::laz {

// A layer after the first.
class LayerEncoder {
 public:
  virtual ~LayerEncoder() = default;
  // Encodes the layer's field of steps.size() records, `stride` bytes each.
  virtual void encode(std::span<const PointStep> steps, const std::byte* records, std::size_t stride) = 0;
  // Returns the bytes of the layer. They are empty when all points have the value of the chunk's first point.
  virtual std::vector<std::byte> finish() = 0;
};

// A layer whose `State` has the models of one channel. put(encoder, step, last, value) encodes the value after `last`.
// stored(value), if State has it, leaves out what the first layer says. State::always: the layer is never left out.
template <class State>
class ChannelEncoder : public LayerEncoder {
 public:
  using Value = typename State::Value;

  // The parameters are those of ChannelLayer.
  ChannelEncoder(Value first, unsigned channel, std::size_t at, bool version_3)
      : changed_(State::always), at_(at), version_3_(version_3), current_(channel), first_(stored(first)) {
    channels_[channel] = std::make_unique<Channel>(first_);
  }

  void encode(std::span<const PointStep> steps, const std::byte* records, std::size_t stride) override {
    const std::byte* from = records + at_;
    for (const auto& step : steps) {
      const Value value = stored(load<Value>(from));
      changed_ = changed_ || std::memcmp(&value, &first_, sizeof value) != 0;
      next(step, value);
      from += stride;
    }
  }

  std::vector<std::byte> finish() override { return changed_ ? encoder_.finish() : std::vector<std::byte>(); }

 private:
  struct Channel {
    explicit Channel(Value v) : state(v), last(v) {}
    State state;
    Value last;
  };

  static Value stored(Value value) {
    if constexpr (requires { State::stored(value); }) {
      return State::stored(value);
    } else {
      return value;
    }
  }

  void next(const PointStep& step, const Value& value) {
    Channel& left = *channels_[current_];
    const unsigned channel = item_channel(step, version_3_);
    const bool same = channel == current_;
    current_ = channel;
    auto& entered = channels_[current_];
    const bool seen = entered != nullptr;
    if (!seen) entered = std::make_unique<Channel>(left.last);
    // Version 3 confuses channels, and so must this encoder: see ChannelLayer.
    Channel& from = !same && seen && version_3_ ? left : *entered;
    entered->state.put(encoder_, step, from.last, value);
    from.last = value;
  }

  bool changed_;
  std::size_t at_;
  bool version_3_;
  unsigned current_;
  Value first_;
  ArithmeticEncoder encoder_;
  std::array<std::unique_ptr<Channel>, 4> channels_;
};

// A byte in one of 64 contexts. Most contexts never occur.
class ByteInContextEncoder {
 public:
  void next(ArithmeticEncoder& encoder, unsigned context, std::uint8_t value) {
    auto& model = models_[context];
    if (!model) model = std::make_unique<SymbolModel<256>>();
    encoder.symbol(*model, value);
  }

 private:
  std::array<std::unique_ptr<SymbolModel<256>>, 64> models_;
};

struct ZEncoder {
  using Value = std::int32_t;
  static constexpr bool always = true;
  explicit ZEncoder(Value z) { of_level.fill(z); }
  void put(ArithmeticEncoder& encoder, const PointStep& step, Value, Value value) {
    integers.next(encoder, of_level[step.level], value, step.z_context);
    of_level[step.level] = value;
  }
  std::array<Value, 8> of_level;
  IntegerEncoder<32, 20> integers;
};

struct ClassificationEncoder {
  using Value = std::uint8_t;
  static constexpr bool always = false;
  explicit ClassificationEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep& step, Value last, Value value) {
    bytes.next(encoder, (last & 31u) << 1 | (step.placement == 3), value);
  }
  ByteInContextEncoder bytes;
};

// Byte 15 of a record without the channel.
struct FlagsEncoder {
  using Value = std::uint8_t;
  static constexpr bool always = false;
  explicit FlagsEncoder(Value) {}
  static Value stored(Value value) { return value & 0xCF; }
  void put(ArithmeticEncoder& encoder, const PointStep&, Value last, Value value) {
    auto& model = models[six_bits(last)];
    if (!model) model = std::make_unique<SymbolModel<64>>();
    encoder.symbol(*model, six_bits(value));
  }
  static unsigned six_bits(Value value) { return (value & 15u) | (value >> 2 & 48u); }
  std::array<std::unique_ptr<SymbolModel<64>>, 64> models;
};

struct IntensityEncoder {
  using Value = std::uint16_t;
  static constexpr bool always = false;
  explicit IntensityEncoder(Value first) { last_of.fill(first); }
  void put(ArithmeticEncoder& encoder, const PointStep& step, Value, Value value) {
    Value& last = last_of[step.placement * 2u + step.new_time];
    integers.next(encoder, last, value, step.placement);
    last = value;
  }
  std::array<Value, 8> last_of;
  IntegerEncoder<16, 4> integers;
};

struct ScanAngleEncoder {
  using Value = std::int16_t;
  static constexpr bool always = false;
  explicit ScanAngleEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep& step, Value last, Value value) {
    if (step.new_angle) integers.next(encoder, last, value, step.new_time);
  }
  IntegerEncoder<16, 2> integers;
};

struct UserDataEncoder {
  using Value = std::uint8_t;
  static constexpr bool always = false;
  explicit UserDataEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep&, Value last, Value value) {
    bytes.next(encoder, last / 4u, value);
  }
  ByteInContextEncoder bytes;
};

struct SourceEncoder {
  using Value = std::uint16_t;
  static constexpr bool always = false;
  explicit SourceEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep& step, Value last, Value value) {
    if (step.new_source) integers.next(encoder, last, value);
  }
  IntegerEncoder<16> integers;
};

struct GpsTimeLayerEncoder {
  using Value = std::int64_t;
  static constexpr bool always = false;
  explicit GpsTimeLayerEncoder(Value first) : times(first) {}
  void put(ArithmeticEncoder& encoder, const PointStep& step, Value, Value value) {
    if (step.new_time) times.next(encoder, value);
  }
  GpsTimeEncoder<false> times;
};

struct RgbLayerEncoder {
  using Value = Rgb;
  static constexpr bool always = false;
  explicit RgbLayerEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep&, const Value& last, const Value& value) {
    models.next(encoder, last, value);
  }
  RgbEncoder models;
};

struct NirLayerEncoder {
  using Value = std::uint16_t;
  static constexpr bool always = false;
  explicit NirLayerEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep&, Value last, Value value) { models.next(encoder, last, value); }
  NirEncoder models;
};

// One of the extra bytes.
struct ByteLayerEncoder {
  using Value = std::uint8_t;
  static constexpr bool always = false;
  explicit ByteLayerEncoder(Value) {}
  void put(ArithmeticEncoder& encoder, const PointStep&, Value last, Value value) {
    encoder.symbol(model, static_cast<std::uint32_t>(value - last) & 0xFF);
  }
  SymbolModel<256> model;
};

}  // namespace tessera::laz
