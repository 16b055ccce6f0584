// Names that are unique across machines.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>

namespace tessera {

// Returns 64 random bits as 16 hexadecimal digits.
inline std::string random_token() {
  std::random_device random;
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%08x%08x", static_cast<unsigned>(random()), static_cast<unsigned>(random()));
  return text.data();
}

}  // namespace tessera
