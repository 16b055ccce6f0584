// COPC files made by hand: point format 6, single returns, x, y and z alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/input/io_testing.h"

namespace tessera::testing_region {

using testing_io::Bytes;

struct CopcFile {
  std::array<double, 3> scale{0.01, 0.01, 0.01}, offset{};
  std::vector<std::array<std::int32_t, 3>> points;
  // A node has the first point of each of the cells that cut its cube, so many along each axis, and its children the
  // others, unless these are few: as the usual writers do it.
  std::int32_t cells = 128;
  std::size_t few = 256;

  Bytes bytes() const;
};

}  // namespace tessera::testing_region
