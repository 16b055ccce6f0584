// POINT10, the 20 bytes that point formats 0 to 3 have in common, in versions 1 and 2.
// Source: rapidlasso, LAZ Specification 1.4.
#include <array>
#include <cstring>
#include <memory>

#include "src/input/laz/integer_decoder.h"
#include "src/input/laz/pointwise.h"
#include "src/input/laz/prediction.h"

namespace tessera::laz {
namespace {

struct Point10 {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  // return number (3 bits), number of returns (3 bits), scan direction, edge of flight line
  std::uint8_t returns = 0;
  std::uint8_t classification = 0;
  std::uint8_t scan_angle = 0, user_data = 0;
  std::uint16_t source = 0;
};
static_assert(sizeof(Point10) == 20);

// A byte that is predicted from its value in the last point. Each such value has a model, made when first needed.
class ByteByLast {
 public:
  std::uint8_t next(ArithmeticDecoder& decoder, std::uint8_t last) {
    auto& model = models_[last];
    if (!model) model = std::make_unique<SymbolModel<256>>();
    return static_cast<std::uint8_t>(decoder.symbol(*model));
  }

 private:
  std::array<std::unique_ptr<SymbolModel<256>>, 256> models_;
};

class Point10Version2 : public PointItem {
 public:
  void first(const std::byte* raw) override {
    std::memcpy(&last_, raw, sizeof last_);
    last_.intensity = 0;  // the first point's intensity predicts no other intensity
  }

  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    const std::uint32_t changed = decoder.symbol(changed_);
    if ((changed & 32) != 0) last_.returns = returns_.next(decoder, last_.returns);
    const std::uint32_t number = last_.returns & 7u, returns = last_.returns >> 3 & 7u;
    const std::uint32_t kind = return_kind_3bit[returns][number], level = return_level(returns, number);
    const bool single = returns == 1;
    if ((changed & 16) != 0)
      intensities_of_[kind] =
          static_cast<std::uint16_t>(intensity_.next(decoder, intensities_of_[kind], std::min(kind, 3u)));
    last_.intensity = intensities_of_[kind];
    if ((changed & 8) != 0) last_.classification = classification_.next(decoder, last_.classification);
    if ((changed & 4) != 0)
      last_.scan_angle =
          static_cast<std::uint8_t>(last_.scan_angle + decoder.symbol(scan_angle_[last_.returns >> 6 & 1u]));
    if ((changed & 2) != 0) last_.user_data = user_data_.next(decoder, last_.user_data);
    if ((changed & 1) != 0) last_.source = static_cast<std::uint16_t>(source_.next(decoder, last_.source));

    const std::int32_t dx = x_.next(decoder, dx_[kind].value(), single);
    dx_[kind].add(dx);
    last_.x = wrapping_add(last_.x, dx);
    const std::int32_t dy = y_.next(decoder, dy_[kind].value(), length_context(x_.length(), 20, single));
    dy_[kind].add(dy);
    last_.y = wrapping_add(last_.y, dy);
    last_.z = z_.next(decoder, z_of_[level], length_context((x_.length() + y_.length()) / 2, 18, single));
    z_of_[level] = last_.z;
    std::memcpy(to, &last_, sizeof last_);
  }

 private:
  Point10 last_;
  std::array<std::uint16_t, 16> intensities_of_{};  // those of the last points with the same kind of return
  std::array<RunningMedian, 16> dx_, dy_;
  std::array<std::int32_t, 8> z_of_{};
  SymbolModel<64> changed_;
  ByteByLast returns_, classification_, user_data_;
  std::array<SymbolModel<256>, 2> scan_angle_;  // by scan direction
  IntegerDecoder<16, 4> intensity_;
  IntegerDecoder<16> source_;
  IntegerDecoder<32, 2> x_;
  IntegerDecoder<32, 22> y_;
  IntegerDecoder<32, 20> z_;
};

class Point10Version1 : public PointItem {
 public:
  void first(const std::byte* raw) override { std::memcpy(&last_, raw, sizeof last_); }

  void next(ArithmeticDecoder& decoder, std::byte* to) override {
    const std::int32_t dx = x_.next(decoder, median(dx_));
    const std::int32_t dy = y_.next(decoder, median(dy_), std::min(x_.length(), 19u));
    const std::uint32_t length = (x_.length() + y_.length()) / 2;
    last_.x = wrapping_add(last_.x, dx);
    last_.y = wrapping_add(last_.y, dy);
    last_.z = z_.next(decoder, last_.z, std::min(length, 19u));
    dx_[turn_] = dx;
    dy_[turn_] = dy;
    turn_ = (turn_ + 1) % 3;

    const std::uint32_t changed = decoder.symbol(changed_);
    if ((changed & 32) != 0) last_.intensity = static_cast<std::uint16_t>(intensity_.next(decoder, last_.intensity));
    if ((changed & 16) != 0) last_.returns = returns_.next(decoder, last_.returns);
    if ((changed & 8) != 0) last_.classification = classification_.next(decoder, last_.classification);
    if ((changed & 4) != 0)
      last_.scan_angle = static_cast<std::uint8_t>(scan_angle_.next(decoder, last_.scan_angle, length < 3));
    if ((changed & 2) != 0) last_.user_data = user_data_.next(decoder, last_.user_data);
    if ((changed & 1) != 0) last_.source = static_cast<std::uint16_t>(source_.next(decoder, last_.source));
    std::memcpy(to, &last_, sizeof last_);
  }

 private:
  static std::int32_t median(const std::array<std::int32_t, 3>& v) {
    return std::max(std::min(v[0], v[1]), std::min(std::max(v[0], v[1]), v[2]));
  }

  Point10 last_;
  std::array<std::int32_t, 3> dx_{}, dy_{};
  std::size_t turn_ = 0;
  SymbolModel<64> changed_;
  ByteByLast returns_, classification_, user_data_;
  IntegerDecoder<16> intensity_, source_;
  IntegerDecoder<8, 2> scan_angle_;
  IntegerDecoder<32> x_;
  IntegerDecoder<32, 20> y_, z_;
};

}  // namespace

std::unique_ptr<PointItem> make_point_10_item(std::uint16_t version) {
  if (version == 1) return std::make_unique<Point10Version1>();
  return std::make_unique<Point10Version2>();
}

}  // namespace tessera::laz
