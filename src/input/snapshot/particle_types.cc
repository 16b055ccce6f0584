#include "src/input/snapshot/particle_types.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "src/base/printable.h"

namespace tessera::snapshot {
namespace {

// The first name of a type is the one that is shown.
constexpr std::array<std::pair<std::string_view, std::uint32_t>, 11> type_names{{{"gas", 0},
                                                                                 {"dark-matter", 1},
                                                                                 {"disk", 2},
                                                                                 {"bulge", 3},
                                                                                 {"stars", 4},
                                                                                 {"black-holes", 5},
                                                                                 {"neutrinos", 6},
                                                                                 {"dark", 1},
                                                                                 {"halo", 1},
                                                                                 {"star", 4},
                                                                                 {"boundary", 5}}};

std::optional<std::uint32_t> type_of_name(std::string_view name) {
  const auto found = std::find_if(type_names.begin(), type_names.end(), [&](auto& n) { return n.first == name; });
  if (found != type_names.end()) return found->second;
  std::uint32_t type = 0;
  const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), type);
  if (problem != std::errc{} || end != name.data() + name.size() || type >= types_max) return std::nullopt;
  return type;
}

}  // namespace

std::string name_of_type(std::uint32_t type) {
  const auto found = std::find_if(type_names.begin(), type_names.end(), [&](auto& n) { return n.second == type; });
  return found == type_names.end() ? std::to_string(type) : std::string(found->first);
}

Result<std::vector<std::uint32_t>> types_of_names(std::span<const std::string> names) {
  std::set<std::uint32_t> types;
  for (const std::string& name : names) {
    const auto type = type_of_name(name);
    if (!type)
      return error(Errc::usage, in_quotes(name) +
                                    " is no type of particles: these are gas, dark-matter, disk, bulge, "
                                    "stars, black-holes and neutrinos, or numbers from 0 to 6");
    types.insert(*type);
  }
  return std::vector<std::uint32_t>(types.begin(), types.end());
}

bool is_wanted(std::span<const std::uint32_t> wanted, std::uint32_t type) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), type) != wanted.end();
}

void KeptParticles::add(std::uint64_t count, bool kept) {
  if (kept && count > 0) {
    if (!stretches_.empty() && stretches_.back().end == particles_) {
      stretches_.back().end += count;
    } else {
      stretches_.push_back({particles_, particles_ + count});
    }
    points_ += count;
  }
  particles_ += count;
}

KeptParticles::Stretch KeptParticles::from(std::uint64_t particle) const {
  for (const Stretch& stretch : stretches_)
    if (particle < stretch.end) return {std::max(particle, stretch.begin), stretch.end};
  return {particles_, particles_};
}

std::uint64_t KeptParticles::particle_of(std::uint64_t index) const {
  for (const Stretch& stretch : stretches_) {
    const std::uint64_t count = stretch.end - stretch.begin;
    if (index < count) return stretch.begin + index;
    index -= count;
  }
  return particles_;
}

}  // namespace tessera::snapshot
