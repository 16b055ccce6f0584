// Thrown when a tile has more points or cells than can be numbered. what() continues a sentence that begins with the
// tile's name: "has more points than ...".
#pragma once

#include <stdexcept>

namespace tessera {

struct TileTooLarge : std::length_error {
  using std::length_error::length_error;
};

}  // namespace tessera
