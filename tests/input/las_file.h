// LAS files made by hand, right or wrong in every byte.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {

struct LasFile {
  int minor = 2;
  std::uint8_t format = 0;
  std::uint16_t extra_bytes = 0;
  std::array<double, 3> scale{0.01, 0.01, 0.01}, offset{0, 0, 0};
  std::vector<std::array<std::int32_t, 3>> points;
  struct Record {
    std::string user;
    std::uint16_t id;
    Bytes payload;
  };
  std::vector<Record> records, extended;

  static std::size_t base_bytes(int format) {
    constexpr std::array<std::size_t, 11> bytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    return bytes[static_cast<std::size_t>(format)];
  }
  std::size_t header_bytes() const { return minor == 4 ? 375 : minor == 3 ? 235 : 227; }
  std::size_t record_bytes() const { return base_bytes(format) + extra_bytes; }
  std::size_t points_at() const {
    std::size_t at = header_bytes();
    for (const auto& r : records) at += 54 + r.payload.size();
    return at;
  }

  Bytes bytes() const {
    Bytes b(header_bytes());
    std::memcpy(b.data(), "LASF", 4);
    put<std::uint8_t>(b, 24, 1);
    put<std::uint8_t>(b, 25, static_cast<std::uint8_t>(minor));
    put<std::uint16_t>(b, 94, static_cast<std::uint16_t>(header_bytes()));
    put<std::uint32_t>(b, 96, static_cast<std::uint32_t>(points_at()));
    put<std::uint32_t>(b, 100, static_cast<std::uint32_t>(records.size()));
    put<std::uint8_t>(b, 104, format);
    put<std::uint16_t>(b, 105, static_cast<std::uint16_t>(record_bytes()));
    put<std::uint32_t>(b, 107, minor == 4 && format >= 6 ? 0 : static_cast<std::uint32_t>(points.size()));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put(b, 131 + 8 * axis, scale[axis]);
      put(b, 155 + 8 * axis, offset[axis]);
    }
    const std::size_t points_end = points_at() + points.size() * record_bytes();
    if (minor == 4) {
      put<std::uint64_t>(b, 235, extended.empty() ? 0 : points_end);
      put<std::uint32_t>(b, 243, static_cast<std::uint32_t>(extended.size()));
      put<std::uint64_t>(b, 247, points.size());
    }
    for (const auto& r : records) add_record(b, r, false);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t at = b.size();
      b.resize(at + record_bytes());
      for (std::size_t axis = 0; axis < 3; ++axis) put(b, at + 4 * axis, points[i][axis]);
      // The rest of record i is i + 1, i + 2, ...: every attribute is then different.
      for (std::size_t k = 12; k < record_bytes(); ++k) put(b, at + k, static_cast<std::uint8_t>(i + k));
    }
    for (const auto& r : extended) add_record(b, r, true);
    return b;
  }

 private:
  static void add_record(Bytes& b, const Record& r, bool extended) {
    const std::size_t at = b.size();
    b.resize(at + (extended ? 60 : 54));
    std::memcpy(b.data() + at + 2, r.user.data(), std::min<std::size_t>(16, r.user.size()));
    put(b, at + 18, r.id);
    if (extended)
      put<std::uint64_t>(b, at + 20, r.payload.size());
    else
      put(b, at + 20, static_cast<std::uint16_t>(r.payload.size()));
    b.insert(b.end(), r.payload.begin(), r.payload.end());
  }
};

}  // namespace tessera::testing_io
