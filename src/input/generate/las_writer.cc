#include "src/input/generate/las_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::size_t header_bytes = 375, record_bytes = 20;
constexpr std::uint8_t point_format = 0;  // has the least data: coordinates and class
constexpr double integer_max = 2147483647;

template <class T>
void store(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

// One axis: coordinate = X / per_unit + offset. per_unit is a power of ten, or the inverse of one.
struct Axis {
  double offset = 0;
  int decimals = 0;  // scale = 10^-decimals

  double per_unit() const { return std::pow(10.0, decimals); }
  double scale() const { return decimals >= 0 ? 1 / std::pow(10.0, decimals) : std::pow(10.0, -decimals); }
};

Axis make_axis(double lo, double hi, double step) {
  Axis axis;
  // An axis that is far from 0 for its size gets a whole number in its middle as offset.
  if (std::max(std::abs(lo), std::abs(hi)) > 4 * (hi - lo) && step == 0) axis.offset = std::floor(lo + (hi - lo) / 2);
  const double reach = std::max({std::abs(lo - axis.offset), std::abs(hi - axis.offset), 1e-300});
  if (step != 0) {
    axis.decimals = -static_cast<int>(std::lround(std::log10(step)));
    return axis;
  }
  axis.decimals = static_cast<int>(std::floor(std::log10(integer_max / reach)));
  axis.decimals = std::clamp(axis.decimals, -300, 22);  // 10^22 is the last power that is exact as a double
  return axis;
}

class LasWriter : public PointWriter {
 public:
  LasWriter(OutputFile file, const WriterOptions& options) : file_(std::move(file)), options_(options) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool given = !options.bounds.empty();
      axes_[static_cast<std::size_t>(axis)] =
          make_axis(given ? options.bounds.lo[axis] : 0, given ? options.bounds.hi[axis] : 0, options.step);
    }
  }

  Status begin() {
    const std::array<std::byte, header_bytes> empty{};
    return file_.append(empty);
  }

  Status write(std::span<const Point> points, std::span<const std::uint8_t> classes) override {
    block_.assign(points.size() * record_bytes, std::byte{0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::byte* const record = block_.data() + i * record_bytes;
      for (int axis = 0; axis < 3; ++axis) {
        const Axis& a = axes_[static_cast<std::size_t>(axis)];
        const double value = options_.dimension == 2 && axis == 2 ? 0 : points[i][axis];
        const double steps = std::nearbyint((value - a.offset) * a.per_unit());
        if (!(std::abs(steps) <= integer_max))
          return error(Errc::bad_input, file_.path().string() + ", point " + std::to_string(written_ + i) + ": " +
                                            std::string(1, "xyz"[axis]) + " = " + std::to_string(value) +
                                            " is too large for the integers of the LAS file");
        store(record + 4 * axis, static_cast<std::int32_t>(steps));
        bounds_.lo[axis] = std::min(bounds_.lo[axis], value);
        bounds_.hi[axis] = std::max(bounds_.hi[axis], value);
      }
      store(record + 14, std::uint8_t{0x9});  // return 1 of 1
      if (!classes.empty()) store(record + 15, classes[i]);
    }
    written_ += points.size();
    return file_.append(block_);
  }

  Status finish() override {
    std::array<std::byte, header_bytes> h{};
    std::memcpy(h.data(), "LASF", 4);
    store<std::uint8_t>(h.data() + 24, 1);
    store<std::uint8_t>(h.data() + 25, 4);
    std::memcpy(h.data() + 26, "OTHER", 5);
    std::memcpy(h.data() + 58, "tessera generate", 16);
    store<std::uint16_t>(h.data() + 94, header_bytes);
    store<std::uint32_t>(h.data() + 96, header_bytes);
    store(h.data() + 104, point_format);
    store<std::uint16_t>(h.data() + 105, record_bytes);
    if (written_ <= std::numeric_limits<std::uint32_t>::max()) {  // for readers of LAS 1.2
      store(h.data() + 107, static_cast<std::uint32_t>(written_));
      store(h.data() + 111, static_cast<std::uint32_t>(written_));  // all are first returns
    }
    for (int axis = 0; axis < 3; ++axis) {
      const Axis& a = axes_[static_cast<std::size_t>(axis)];
      store(h.data() + 131 + 8 * axis, a.scale());
      store(h.data() + 155 + 8 * axis, a.offset);
      store(h.data() + 179 + 16 * axis, written_ > 0 ? bounds_.hi[axis] : 0.0);
      store(h.data() + 187 + 16 * axis, written_ > 0 ? bounds_.lo[axis] : 0.0);
    }
    store(h.data() + 247, written_);
    store(h.data() + 255, written_);
    BOOST_OUTCOME_TRYV(file_.overwrite(0, h));
    return file_.commit();
  }

 private:
  OutputFile file_;
  WriterOptions options_;
  std::array<Axis, 3> axes_;
  Bounds bounds_;
  std::uint64_t written_ = 0;
  std::vector<std::byte> block_;
};

}  // namespace

Result<std::unique_ptr<PointWriter>> open_las_writer(OutputFile file, const WriterOptions& options) {
  auto writer = std::make_unique<LasWriter>(std::move(file), options);
  BOOST_OUTCOME_TRYV(writer->begin());
  return std::unique_ptr<PointWriter>(std::move(writer));
}

}  // namespace tessera
