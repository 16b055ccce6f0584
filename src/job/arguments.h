// Text from flags, environment and configuration files turned into values. All of it is untrusted: every function
// accepts the whole text or returns Errc::usage with the end of a sentence ("'12x' is not a number like 500, 10k,
// ...").
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

// How many: decimal suffixes k (10^3), M (10^6), G (10^9). "1.5M" is 1500000; "1.5" is refused, being no whole number.
Result<std::uint64_t> parse_count(std::string_view text);

// Bytes: binary suffixes K (2^10), M, G, T, as in `ulimit` and `docker --memory`. "1.5G" is 1610612736. Fractions of a
// byte are dropped; at most six digits may follow the point.
Result<std::uint64_t> parse_memory(std::string_view text);

// A whole number from lowest to highest, without suffix.
Result<std::int64_t> parse_integer(std::string_view text, std::int64_t lowest, std::int64_t highest);

// true/false, yes/no, on/off, 1/0.
Result<bool> parse_switch(std::string_view text);

// A closed box: xmin,ymin,xmax,ymax (any z) or xmin,ymin,zmin,xmax,ymax,zmax (3D only).
Result<Box> parse_crop(std::string_view text, int dimension);

// "X,Y" or "X,Y,Z", as many as there are dimensions; z in 2D does not count.
Result<Point> parse_point(std::string_view text, int dimension);

// A line of the plane, "X,Y X,Y ...": two points or more.
Result<std::vector<Point>> parse_line(const std::string& text);

// A finite number.
Result<double> parse_finite(std::string_view text);

// A distance: finite and above 0, in the units of the coordinates.
Result<double> parse_distance(std::string_view text);

// LAS class numbers, 0..255: "2,9".
Result<std::vector<int>> parse_classes(std::string_view text);

// Names separated by commas, none empty.
Result<std::vector<std::string>> parse_names(std::string_view text);
// The same, of columns of points; see check_columns().
Result<std::vector<std::string>> parse_columns(std::string_view text);

// A parser to which "auto" stands for a choice of the program.
template <class Parse>
auto or_auto(Parse parse, typename decltype(parse(std::string()))::value_type automatic) {
  return [parse, automatic](const std::string& text) -> decltype(parse(text)) {
    if (text == "auto") return automatic;
    return parse(text);
  };
}

}  // namespace tessera
