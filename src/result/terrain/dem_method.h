// How the value of a pixel follows from the vertices around its centre.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace tessera {

// linear: between the corners of the cell that has the pixel. natural: Sibson's natural neighbours. laplace: the
// natural neighbours weighted by the faces of the pixel's Voronoi cell (natural_value.h).
enum class DemMethod : std::uint8_t { linear, natural, laplace };

inline constexpr std::array<std::string_view, 3> dem_method_names{"linear", "natural", "laplace"};
inline std::string_view name_of(DemMethod method) { return dem_method_names[static_cast<std::size_t>(method)]; }
inline std::optional<DemMethod> dem_method_of(std::string_view name) {
  for (std::size_t i = 0; i < dem_method_names.size(); ++i)
    if (dem_method_names[i] == name) return static_cast<DemMethod>(i);
  return std::nullopt;
}

}  // namespace tessera
