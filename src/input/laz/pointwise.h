// Point formats 0 to 5: one stream has all fields of a point, item by item.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "src/input/laz/arithmetic_decoder.h"
#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// One item of a record: POINT10, GPSTIME11, RGB12 or BYTE, in version 1 or 2, or WAVEPACKET13.
class PointItem {
 public:
  virtual ~PointItem() = default;
  // Takes the item of a chunk's first point, which is not compressed.
  virtual void first(const std::byte* raw) = 0;
  // Writes the item of the next point to `to`.
  virtual void next(ArithmeticDecoder& decoder, std::byte* to) = 0;
};

// REQUIRES: `item` comes from read_laz_layout().
std::unique_ptr<PointItem> make_point_item(const LazItem& item);
std::unique_ptr<PointItem> make_point_10_item(std::uint16_t version);

}  // namespace tessera::laz
