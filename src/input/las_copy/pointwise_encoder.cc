// Point formats 0 to 3: POINT10, GPSTIME11, RGB12 and BYTE, all in version 2.
// Source: rapidlasso, LAZ Specification 1.4.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/las_copy/chunk_encoder.h"
#include "src/input/las_copy/colour_encoder.h"
#include "src/input/las_copy/gps_time_encoder.h"
#include "src/input/las_copy/integer_encoder.h"
#include "src/input/laz/prediction.h"

namespace tessera::laz {
namespace {

// One item of a record; see PointItem.
class ItemEncoder {
 public:
  virtual ~ItemEncoder() = default;
  virtual void first(const std::byte* raw) = 0;
  virtual void next(ArithmeticEncoder& encoder, const std::byte* raw) = 0;
};

// A byte that is predicted from its value in the last point.
class ByteByLastEncoder {
 public:
  void next(ArithmeticEncoder& encoder, std::byte last, std::byte value) {
    auto& model = models_[std::to_integer<std::size_t>(last)];
    if (!model) model = std::make_unique<SymbolModel<256>>();
    encoder.symbol(*model, std::to_integer<std::uint32_t>(value));
  }

 private:
  std::array<std::unique_ptr<SymbolModel<256>>, 256> models_;
};

// Byte 14 of the record has return number, number of returns, scan direction and edge of flight line; then follow
// classification, scan angle, user data and the source.
class Point10Encoder : public ItemEncoder {
 public:
  void first(const std::byte* raw) override { std::memcpy(last_.data(), raw, last_.size()); }

  void next(ArithmeticEncoder& encoder, const std::byte* raw) override {
    const auto returned = std::to_integer<std::uint32_t>(raw[14]);
    const std::uint32_t number = returned & 7u, returns = returned >> 3 & 7u;
    const std::uint32_t kind = return_kind_3bit[returns][number];
    const auto intensity = load<std::uint16_t>(raw + 12), source = load<std::uint16_t>(raw + 18);
    const auto last_source = load<std::uint16_t>(last_.data() + 18);
    const auto differs = [&](std::size_t at) { return std::uint32_t{raw[at] != last_[at]}; };
    const std::uint32_t changed = differs(14) << 5 | std::uint32_t{intensity != intensities_of_[kind]} << 4 |
                                  differs(15) << 3 | differs(16) << 2 | differs(17) << 1 | (source != last_source);
    encoder.symbol(changed_, changed);
    if ((changed & 32) != 0) returns_.next(encoder, last_[14], raw[14]);
    if ((changed & 16) != 0) intensity_.next(encoder, intensities_of_[kind], intensity, std::min(kind, 3u));
    intensities_of_[kind] = intensity;
    if ((changed & 8) != 0) classification_.next(encoder, last_[15], raw[15]);
    if ((changed & 4) != 0)
      encoder.symbol(scan_angle_[returned >> 6 & 1u],
                     (std::to_integer<std::uint32_t>(raw[16]) - std::to_integer<std::uint32_t>(last_[16])) & 0xFF);
    if ((changed & 2) != 0) user_data_.next(encoder, last_[17], raw[17]);
    if ((changed & 1) != 0) source_.next(encoder, last_source, source);
    put_coordinates(encoder, raw, kind, return_level(returns, number), returns == 1);
    std::memcpy(last_.data(), raw, last_.size());
  }

 private:
  void put_coordinates(ArithmeticEncoder& encoder, const std::byte* raw, std::uint32_t kind, std::uint32_t level,
                       bool single) {
    const std::int32_t dx = moved(load<std::int32_t>(last_.data()), load<std::int32_t>(raw));
    const std::int32_t dy = moved(load<std::int32_t>(last_.data() + 4), load<std::int32_t>(raw + 4));
    const auto z = load<std::int32_t>(raw + 8);
    x_.next(encoder, dx_[kind].value(), dx, single);
    dx_[kind].add(dx);
    y_.next(encoder, dy_[kind].value(), dy, length_context(x_.length(), 20, single));
    dy_[kind].add(dy);
    z_.next(encoder, z_of_[level], z, length_context((x_.length() + y_.length()) / 2, 18, single));
    z_of_[level] = z;
  }

  std::array<std::byte, 20> last_{};
  std::array<std::uint16_t, 16> intensities_of_{};  // those of the last points with the same kind of return
  std::array<RunningMedian, 16> dx_, dy_;
  std::array<std::int32_t, 8> z_of_{};
  SymbolModel<64> changed_;
  ByteByLastEncoder returns_, classification_, user_data_;
  std::array<SymbolModel<256>, 2> scan_angle_;  // by scan direction
  IntegerEncoder<16, 4> intensity_;
  IntegerEncoder<16> source_;
  IntegerEncoder<32, 2> x_;
  IntegerEncoder<32, 22> y_;
  IntegerEncoder<32, 20> z_;
};

class GpsTimeItemEncoder : public ItemEncoder {
 public:
  void first(const std::byte* raw) override { times_ = GpsTimeEncoder<true>(load<std::int64_t>(raw)); }
  void next(ArithmeticEncoder& encoder, const std::byte* raw) override {
    times_.next(encoder, load<std::int64_t>(raw));
  }

 private:
  GpsTimeEncoder<true> times_;
};

class RgbItemEncoder : public ItemEncoder {
 public:
  void first(const std::byte* raw) override { last_ = load<Rgb>(raw); }
  void next(ArithmeticEncoder& encoder, const std::byte* raw) override {
    const auto value = load<Rgb>(raw);
    models_.next(encoder, last_, value);
    last_ = value;
  }

 private:
  Rgb last_;
  RgbEncoder models_;
};

class BytesEncoder : public ItemEncoder {
 public:
  explicit BytesEncoder(std::size_t count) : last_(count), models_(count) {}
  void first(const std::byte* raw) override { std::memcpy(last_.data(), raw, last_.size()); }
  void next(ArithmeticEncoder& encoder, const std::byte* raw) override {
    for (std::size_t i = 0; i < last_.size(); ++i) {
      const auto value = load<std::uint8_t>(raw + i);
      encoder.symbol(models_[i], static_cast<std::uint32_t>(value - last_[i]) & 0xFF);
      last_[i] = value;
    }
  }

 private:
  std::vector<std::uint8_t> last_;
  std::vector<SymbolModel<256>> models_;
};

std::unique_ptr<ItemEncoder> make_item_encoder(const LazItem& item) {
  if (item.type == ItemType::point_10) return std::make_unique<Point10Encoder>();
  if (item.type == ItemType::gps_time_11) return std::make_unique<GpsTimeItemEncoder>();
  if (item.type == ItemType::rgb_12) return std::make_unique<RgbItemEncoder>();
  return std::make_unique<BytesEncoder>(item.bytes);
}

class PointwiseEncoder : public ChunkEncoder {
 public:
  PointwiseEncoder(const LazLayout& layout, std::size_t record_bytes) : record_bytes_(record_bytes) {
    for (const auto& item : layout.items) items_.push_back({make_item_encoder(item), item.bytes});
  }

  void encode(std::span<const std::byte> records) override {
    for (; !records.empty(); records = records.subspan(record_bytes_)) {
      const std::byte* at = records.data();
      const bool first = first_.empty();
      if (first) first_.assign(at, at + record_bytes_);
      for (const auto& item : items_) {
        if (first) {
          item.encoder->first(at);
        } else {
          item.encoder->next(encoder_, at);
        }
        at += item.bytes;
      }
    }
  }

  std::vector<std::byte> finish() override {
    std::vector<std::byte> bytes = std::move(first_);
    const auto rest = encoder_.finish();
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    return bytes;
  }

 private:
  struct Item {
    std::unique_ptr<ItemEncoder> encoder;
    std::size_t bytes;
  };
  std::size_t record_bytes_;
  std::vector<Item> items_;
  std::vector<std::byte> first_;  // the first point, which is not compressed
  ArithmeticEncoder encoder_;
};

}  // namespace

std::unique_ptr<ChunkEncoder> make_pointwise_encoder(const LazLayout& layout, std::size_t record_bytes) {
  return std::make_unique<PointwiseEncoder>(layout, record_bytes);
}

}  // namespace tessera::laz
