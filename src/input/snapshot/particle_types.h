// Types of particles, by the numbers of Gadget, and the stretches of a file that a choice of types keeps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"

namespace tessera::snapshot {

inline constexpr std::size_t types_max = 7;  // SWIFT has neutrinos as type 6

// "gas", "dark-matter", "disk", "bulge", "stars", "black-holes", "neutrinos"; a number for other types.
std::string name_of_type(std::uint32_t type);

// The types that names and numbers mean, each once, ascending; also of the names dark, halo, star and boundary. Error
// usage, with the end of a sentence, for other texts.
Result<std::vector<std::uint32_t>> types_of_names(std::span<const std::string> names);

// Whether the types that are `wanted` contain `type`; if none is named, all are wanted.
bool is_wanted(std::span<const std::uint32_t> wanted, std::uint32_t type);

// The particles of a file, which come type by type, of which some are points and the others are skipped.
class KeptParticles {
 public:
  struct Stretch {
    std::uint64_t begin = 0, end = 0;
  };
  // Adds the next `count` particles of the file. REQUIRES: all together fit into 64 bits.
  void add(std::uint64_t count, bool kept);

  std::uint64_t points() const { return points_; }
  std::uint64_t passed_over() const { return particles_ - points_; }
  // The rest of the first stretch of points at or behind a particle. At the end: nothing, behind the last particle.
  Stretch from(std::uint64_t particle) const;
  // The particle that is point `index`; behind the last one the number of particles.
  std::uint64_t particle_of(std::uint64_t index) const;

 private:
  std::vector<Stretch> stretches_;
  std::uint64_t particles_ = 0, points_ = 0;
};

}  // namespace tessera::snapshot
