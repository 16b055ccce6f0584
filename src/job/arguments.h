// Turns text from flags, environment and configuration files into values. All of the text is untrusted: every function
// accepts the whole text or returns Errc::usage with the end of a sentence ("'12x' is not a number like 500, 10k,
// ...").
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/cosmology.h"

namespace tessera {

// Parses a count with a decimal suffix: k (10^3), M (10^6), G (10^9). "1.5M" is 1500000; "1.5" is refused, as it is no
// whole number.
Result<std::uint64_t> parse_count(std::string_view text);

// Parses a number of bytes with a binary suffix: K (2^10), M, G, T, as in `ulimit` and `docker --memory`. "1.5G" is
// 1610612736. Fractions of a byte are dropped; at most six digits may follow the point.
Result<std::uint64_t> parse_memory(std::string_view text);

// Parses a whole number from lowest to highest, without suffix.
Result<std::int64_t> parse_integer(std::string_view text, std::int64_t lowest, std::int64_t highest);

// Parses true/false, yes/no, on/off, 1/0.
Result<bool> parse_switch(std::string_view text);

// Parses a closed box: xmin,ymin,xmax,ymax (any z) or xmin,ymin,zmin,xmax,ymax,zmax (3D only).
Result<Box> parse_crop(std::string_view text, int dimension);

// Parses "X,Y" or "X,Y,Z", as many numbers as there are dimensions; in 2D z is ignored.
Result<Point> parse_point(std::string_view text, int dimension);

// Parses a line in the plane, "X,Y X,Y ...": two points or more.
Result<std::vector<Point>> parse_line(const std::string& text);

// Parses a finite number.
Result<double> parse_finite(std::string_view text);

// Parses a distance: finite and above 0, in the units of the coordinates.
Result<double> parse_distance(std::string_view text);

// Parses periods: one to three numbers, separated by commas. CloudOptions::periodic says which numbers are periods.
Result<std::vector<double>> parse_periods(std::string_view text);

// Parses numbers of voxels along axes: one to three whole numbers from 1 on, separated by commas.
Result<std::vector<std::int64_t>> parse_grid(std::string_view text);

// Parses LAS class numbers, 0..255: "2,9".
Result<std::vector<int>> parse_classes(std::string_view text);
Result<std::vector<std::uint32_t>> parse_scans(std::string_view text);
// Parses types of particles, names and numbers: "gas,4"; see snapshot/particle_types.h.
Result<std::vector<std::uint32_t>> parse_particles(std::string_view text);
// Parses a flat cosmology: H0 and the density of matter, "70,0.3".
Result<Cosmology> parse_cosmology(std::string_view text);

// Parses names separated by commas; none may be empty.
Result<std::vector<std::string>> parse_names(std::string_view text);
// The same for columns of points; see check_columns().
Result<std::vector<std::string>> parse_columns(std::string_view text);

// Returns a parser that also accepts "auto" and then returns `automatic`.
template <class Parse>
auto or_auto(Parse parse, typename decltype(parse(std::string()))::value_type automatic) {
  return [parse, automatic](const std::string& text) -> decltype(parse(text)) {
    if (text == "auto") return automatic;
    return parse(text);
  };
}

}  // namespace tessera
