// The layers of point formats 6 to 8 after the first, one class for each field: see ChannelLayer.
// Source: LASzip, design/specification.rst; rapidlasso, LAZ Specification 1.4.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "src/input/laz/channel_layer.h"
#include "src/input/laz/colour.h"
#include "src/input/laz/gps_time.h"
#include "src/input/laz/integer_decoder.h"

namespace tessera::laz {

// A byte in one of 64 contexts. Most contexts never occur.
class ByteInContext {
 public:
  std::uint8_t next(ArithmeticDecoder& decoder, unsigned context) {
    auto& model = models_[context];
    if (!model) model = std::make_unique<SymbolModel<256>>();
    return static_cast<std::uint8_t>(decoder.symbol(*model));
  }

 private:
  std::array<std::unique_ptr<SymbolModel<256>>, 64> models_;
};

struct ZState {
  using Value = std::int32_t;
  explicit ZState(Value z) { of_level.fill(z); }
  Value next(ArithmeticDecoder& decoder, const PointStep& step, Value) {
    return of_level[step.level] = integers.next(decoder, of_level[step.level], step.z_context);
  }
  std::array<Value, 8> of_level;
  IntegerDecoder<32, 20> integers;
};

struct ClassificationState {
  using Value = std::uint8_t;
  explicit ClassificationState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep& step, Value last) {
    return bytes.next(decoder, (last & 31u) << 1 | (step.placement == 3));
  }
  ByteInContext bytes;
};

// Byte 15 of a record: four flags of the point, scan direction, edge of the flight line. Between them is the channel,
// which comes from the first layer.
struct FlagsState {
  using Value = std::uint8_t;
  explicit FlagsState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep&, Value last) {
    auto& model = models_[(last & 15u) | (last >> 2 & 48u)];
    if (!model) model = std::make_unique<SymbolModel<64>>();
    const unsigned flags = decoder.symbol(*model);
    return static_cast<Value>((flags & 15u) | (flags & 48u) << 2);
  }
  static Value in_record(Value value, const PointStep& step) {
    return static_cast<Value>((value & 0xCFu) | step.channel << 4);
  }

 private:
  std::array<std::unique_ptr<SymbolModel<64>>, 64> models_;
};

struct IntensityState {
  using Value = std::uint16_t;
  explicit IntensityState(Value first) { last_of.fill(first); }
  Value next(ArithmeticDecoder& decoder, const PointStep& step, Value) {
    Value& last = last_of[step.placement * 2u + step.new_time];
    return last = static_cast<Value>(integers.next(decoder, last, step.placement));
  }
  std::array<Value, 8> last_of;
  IntegerDecoder<16, 4> integers;
};

struct ScanAngleState {
  using Value = std::int16_t;
  explicit ScanAngleState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep& step, Value last) {
    return step.new_angle ? static_cast<Value>(integers.next(decoder, last, step.new_time)) : last;
  }
  IntegerDecoder<16, 2> integers;
};

struct UserDataState {
  using Value = std::uint8_t;
  explicit UserDataState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep&, Value last) { return bytes.next(decoder, last / 4u); }
  ByteInContext bytes;
};

struct SourceState {
  using Value = std::uint16_t;
  explicit SourceState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep& step, Value last) {
    return step.new_source ? static_cast<Value>(integers.next(decoder, last)) : last;
  }
  IntegerDecoder<16> integers;
};

struct GpsTimeState {
  using Value = std::int64_t;
  explicit GpsTimeState(Value first) : times(first) {}
  Value next(ArithmeticDecoder& decoder, const PointStep& step, Value last) {
    return step.new_time ? times.next(decoder) : last;
  }
  GpsTimes<false> times;
};

struct RgbState {
  using Value = Rgb;
  explicit RgbState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep&, const Value& last) { return models.next(decoder, last); }
  RgbModels models;
};

struct NirState {
  using Value = std::uint16_t;
  explicit NirState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep&, Value last) { return models.next(decoder, last); }
  NirModels models;
};

// One of the extra bytes.
struct ByteState {
  using Value = std::uint8_t;
  explicit ByteState(Value) {}
  Value next(ArithmeticDecoder& decoder, const PointStep&, Value last) {
    return static_cast<Value>(last + decoder.symbol(model));
  }
  SymbolModel<256> model;
};

}  // namespace tessera::laz
