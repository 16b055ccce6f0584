// Thrown where a tile holds more than can be numbered; what() follows the tile's name: "has more points than ...".
#pragma once

#include <stdexcept>

namespace tessera {

struct TileTooLarge : std::length_error {
  using std::length_error::length_error;
};

}  // namespace tessera
