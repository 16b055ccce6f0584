// GPSTIME11, RGB12 and BYTE, in versions 1 and 2, and WAVEPACKET13. Source: rapidlasso, LAZ Specification 1.4.
#include <array>
#include <cstring>
#include <memory>
#include <vector>

#include "src/input/bytes/fields.h"
#include "src/input/laz/colour.h"
#include "src/input/laz/gps_time.h"
#include "src/input/laz/pointwise.h"

namespace tessera::laz {
namespace {

class GpsTimeVersion2 : public PointItem {
 public:
  void first(const std::byte* raw) override { times_ = GpsTimes<true>(load<std::int64_t>(raw)); }
  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    const std::int64_t time = times_.next(decoder);
    std::memcpy(to, &time, sizeof time);
  }

 private:
  GpsTimes<true> times_;
};

class GpsTimeVersion1 : public PointItem {
 public:
  void first(const std::byte* raw) override { time_ = load<std::int64_t>(raw); }

  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    const bool known = difference_ != 0;
    const std::uint32_t code = known ? decoder.symbol(multiples_) : decoder.symbol(first_differences_);
    if (code == (known ? anew : 2)) {
      time_ = static_cast<std::int64_t>(decoder.bits64());
    } else if (!known && code == 1) {
      difference_ = corrections_.next(decoder, 0, 0);
      time_ = wrapping_add(time_, std::int64_t{difference_});
    } else if (known && code < anew) {
      time_ = wrapping_add(time_, std::int64_t{difference(code, decoder)});
    }  // otherwise the same time again
    std::memcpy(to, &time_, sizeof time_);
  }

 private:
  static constexpr std::uint32_t anew = 510;  // the code of a new time; 511: the same time again

  std::int32_t difference(std::uint32_t multiple, ArithmeticDecoder& decoder) {
    if (multiple == 1) {
      extremes_ = 0;
      return difference_ = corrections_.next(decoder, difference_, 1);
    }
    const std::int32_t predicted =
        multiple == 0 ? difference_ / 4 : wrapping_multiply(static_cast<std::int32_t>(multiple), difference_);
    const std::uint32_t context = multiple == 0 ? 2 : multiple < 10 ? 3 : multiple < 50 ? 4 : 5;
    const std::int32_t found = corrections_.next(decoder, predicted, context);
    if ((multiple == 0 || multiple == anew - 1) && ++extremes_ > 3) {
      difference_ = found;
      extremes_ = 0;
    }
    return found;
  }

  std::int64_t time_ = 0;
  std::int32_t difference_ = 0;
  std::uint32_t extremes_ = 0;
  SymbolModel<3> first_differences_;
  SymbolModel<512> multiples_;
  IntegerDecoder<32, 6> corrections_;
};

class RgbVersion2 : public PointItem {
 public:
  void first(const std::byte* raw) override { last_ = load<Rgb>(raw); }
  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    last_ = models_.next(decoder, last_);
    std::memcpy(to, &last_, sizeof last_);
  }

 private:
  Rgb last_;
  RgbModels models_;
};

class RgbVersion1 : public PointItem {
 public:
  void first(const std::byte* raw) override { std::memcpy(last_.data(), raw, last_.size()); }
  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    const std::uint32_t changed = decoder.symbol(changed_);
    for (std::uint32_t i = 0; i < last_.size(); ++i)
      if ((changed >> i & 1) != 0) last_[i] = static_cast<std::uint8_t>(bytes_.next(decoder, last_[i], i));
    std::memcpy(to, last_.data(), last_.size());
  }

 private:
  std::array<std::uint8_t, 6> last_{};  // low and high byte of red, green, blue
  SymbolModel<64> changed_;
  IntegerDecoder<8, 6> bytes_;
};

class BytesVersion2 : public PointItem {
 public:
  explicit BytesVersion2(std::size_t count) : last_(count), models_(count) {}
  void first(const std::byte* raw) override { std::memcpy(last_.data(), raw, last_.size()); }
  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    for (std::size_t i = 0; i < last_.size(); ++i)
      last_[i] = static_cast<std::uint8_t>(last_[i] + decoder.symbol(models_[i]));
    std::memcpy(to, last_.data(), last_.size());
  }

 private:
  std::vector<std::uint8_t> last_;
  std::vector<SymbolModel<256>> models_;
};

class BytesVersion1 : public PointItem {
 public:
  explicit BytesVersion1(std::size_t count) : last_(count) {}
  void first(const std::byte* raw) override { std::memcpy(last_.data(), raw, last_.size()); }
  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    for (std::size_t i = 0; i < last_.size(); ++i)
      last_[i] = static_cast<std::uint8_t>(bytes_.next(decoder, last_[i], static_cast<std::uint32_t>(i)));
    std::memcpy(to, last_.data(), last_.size());
  }

 private:
  std::vector<std::uint8_t> last_;
  IntegerDecoder<8, extra_bytes_max> bytes_;
};

// Where the waveform of a point is. Nobody needs it, but the fields of all items are in one stream.
class WavePacket : public PointItem {
 public:
  void first(const std::byte* raw) override { last_ = load<Packet>(raw); }
  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    last_.descriptor = static_cast<std::uint8_t>(decoder.symbol(descriptors_));
    last_place_ = decoder.symbol(places_[last_place_]);
    if (last_place_ == after_last) {
      last_.offset += last_.bytes;
    } else if (last_place_ == moved) {
      last_move_ = moves_.next(decoder, last_move_);
      last_.offset += static_cast<std::uint64_t>(std::int64_t{last_move_});
    } else if (last_place_ == anew) {
      last_.offset = decoder.bits64();
    }  // otherwise the same place again
    last_.bytes = static_cast<std::uint32_t>(bytes_.next(decoder, static_cast<std::int32_t>(last_.bytes)));
    last_.time = times_.next(decoder, last_.time);
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      last_.direction[axis] = directions_.next(decoder, last_.direction[axis], axis);
    std::memcpy(to, &last_, sizeof last_);
  }

 private:
  static constexpr std::uint32_t after_last = 1, moved = 2, anew = 3;
#pragma pack(push, 1)
  struct Packet {
    std::uint8_t descriptor = 0;
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
    std::int32_t time = 0;                       // the bits of a float
    std::array<std::int32_t, 3> direction = {};  // likewise
  };
#pragma pack(pop)

  Packet last_;
  std::uint32_t last_place_ = 0;
  std::int32_t last_move_ = 0;
  SymbolModel<256> descriptors_;
  std::array<SymbolModel<4>, 4> places_;
  IntegerDecoder<32> moves_, bytes_, times_;
  IntegerDecoder<32, 3> directions_;
};

}  // namespace

std::unique_ptr<PointItem> make_point_item(const LazItem& item) {
  const bool first_version = item.version == 1;
  if (item.type == ItemType::point_10) return make_point_10_item(item.version);
  if (item.type == ItemType::gps_time_11) {
    if (first_version) return std::make_unique<GpsTimeVersion1>();
    return std::make_unique<GpsTimeVersion2>();
  }
  if (item.type == ItemType::rgb_12) {
    if (first_version) return std::make_unique<RgbVersion1>();
    return std::make_unique<RgbVersion2>();
  }
  if (item.type == ItemType::wave_packet_13) return std::make_unique<WavePacket>();
  if (first_version) return std::make_unique<BytesVersion1>(item.bytes);
  return std::make_unique<BytesVersion2>(item.bytes);
}

}  // namespace tessera::laz
