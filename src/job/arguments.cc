#include "src/job/arguments.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <sstream>
#include <system_error>

#include "src/input/column_names.h"
#include "src/input/snapshot/particle_types.h"
#include "src/job/job_options.h"

namespace tessera {
namespace {

Error refuse(std::string_view text, const std::string& reason) {
  return error(Errc::usage, "'" + std::string(text) + "' " + reason);
}

struct Decimal {
  std::uint64_t whole = 0;
  std::string_view fraction;  // digits after the point
  std::string_view suffix;
};

// Splits digits [ "." digits ] suffix.
std::optional<Decimal> split_decimal(std::string_view text) {
  const auto digits_end = [](std::string_view s) {
    const auto end = s.find_first_not_of("0123456789");
    return end == std::string_view::npos ? s.size() : end;
  };
  Decimal decimal;
  const auto whole = digits_end(text);
  if (whole == 0) return std::nullopt;
  if (std::from_chars(text.data(), text.data() + whole, decimal.whole).ec != std::errc{}) return std::nullopt;
  text.remove_prefix(whole);
  if (!text.empty() && text.front() == '.') {
    text.remove_prefix(1);
    const auto fraction = digits_end(text);
    if (fraction == 0) return std::nullopt;
    decimal.fraction = text.substr(0, fraction);
    text.remove_prefix(fraction);
  }
  decimal.suffix = text;
  return decimal;
}

std::vector<std::string_view> split_commas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

std::optional<double> finite_number(std::string_view text) {
  double number = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (ec != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace

Result<std::uint64_t> parse_count(std::string_view text) {
  const auto bad = [&](const char* reason = "is not a number like 500, 10k, 1.5M or 2G") {
    return refuse(text, reason);
  };
  const auto decimal = split_decimal(text);
  if (!decimal) return bad();
  std::size_t zeros = 0;
  if (decimal->suffix == "k" || decimal->suffix == "K") {
    zeros = 3;
  } else if (decimal->suffix == "M") {
    zeros = 6;
  } else if (decimal->suffix == "G") {
    zeros = 9;
  } else if (!decimal->suffix.empty()) {
    return bad();
  }
  std::uint64_t value = decimal->whole;
  for (std::size_t i = 0; i < std::max(zeros, decimal->fraction.size()); ++i) {
    const std::uint64_t digit = i < decimal->fraction.size() ? decimal->fraction[i] - '0' : 0;
    if (i >= zeros) {
      if (digit != 0) return bad("is not a whole number");
    } else if (__builtin_mul_overflow(value, std::uint64_t{10}, &value) ||
               __builtin_add_overflow(value, digit, &value)) {
      return bad("is too large");
    }
  }
  return value;
}

Result<std::uint64_t> parse_memory(std::string_view text) {
  const auto bad = [&](const char* reason = "is not a size like 800M, 4G or 1.5G") { return refuse(text, reason); };
  const auto decimal = split_decimal(text);
  if (!decimal || decimal->fraction.size() > 6 || decimal->suffix.size() > 1) return bad();
  int shift = 0;
  if (!decimal->suffix.empty()) {
    const auto at = std::string_view("KMGT").find(decimal->suffix == "k" ? 'K' : decimal->suffix.front());
    if (at == std::string_view::npos) return bad();
    shift = 10 * (static_cast<int>(at) + 1);
  } else if (!decimal->fraction.empty()) {
    return bad();
  }
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(decimal->whole, std::uint64_t{1} << shift, &bytes)) return bad("is too large");
  std::uint64_t millionths = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    millionths = millionths * 10 + (i < decimal->fraction.size() ? decimal->fraction[i] - '0' : 0);
  }
  // millionths < 2^20 and shift <= 40, so there is no overflow.
  if (__builtin_add_overflow(bytes, (millionths << shift) / 1'000'000, &bytes)) return bad("is too large");
  return bytes;
}

Result<std::int64_t> parse_integer(std::string_view text, std::int64_t lowest, std::int64_t highest) {
  std::int64_t value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ec != std::errc{} || end != text.data() + text.size() || value < lowest || value > highest) {
    return refuse(text, "is not a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest));
  }
  return value;
}

Result<bool> parse_switch(std::string_view text) {
  for (const auto* yes : {"true", "yes", "on", "1"}) {
    if (text == yes) return true;
  }
  for (const auto* no : {"false", "no", "off", "0"}) {
    if (text == no) return false;
  }
  return refuse(text, "is neither true nor false");
}

Result<Box> parse_crop(std::string_view text, int dimension) {
  std::vector<double> numbers;
  for (const auto part : split_commas(text)) {
    const auto number = finite_number(part);
    if (!number) return refuse(text, "is not a box: '" + std::string(part) + "' is not a number");
    numbers.push_back(*number);
  }
  auto box = crop_box(numbers, dimension);
  if (!box) return refuse(text, box.error().where);
  return box;
}

Result<double> parse_finite(std::string_view text) {
  const auto number = finite_number(text);
  if (!number) return refuse(text, "is not a number");
  return *number;
}

Result<Point> parse_point(std::string_view text, int dimension) {
  const std::string all(text);
  Point p;
  int axis = 0;
  for (std::size_t begin = 0; begin <= text.size(); ++axis) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    auto number = parse_finite(text.substr(begin, end - begin));
    if (!number || axis > 2) return error(Errc::usage, "'" + all + "' is not a point like 885100,629050");
    if (axis < dimension) p[axis] = number.value();
    begin = end + 1;
  }
  if (axis < dimension)
    return error(Errc::usage, "'" + all + "' has " + std::to_string(axis) + " coordinates, and the result is " +
                                  std::to_string(dimension) + "D");
  return without_negative_zero(p);
}

Result<double> parse_distance(std::string_view text) {
  const auto number = finite_number(text);
  if (!number || *number <= 0) return refuse(text, "is not a distance, a number above 0");
  return *number;
}

// Words such as "nan" and "inf" are numbers here. Cloud::open() refuses them.
Result<std::vector<std::int64_t>> parse_grid(std::string_view text) {
  constexpr std::int64_t most = 1 << 24;
  std::vector<std::int64_t> voxels;
  for (const auto part : split_commas(text)) {
    const auto number = parse_integer(part, 1, most);
    if (!number || voxels.size() == 3)
      return refuse(text, "is not a number of voxels along an axis, 1 to " + std::to_string(most) +
                              ", like 256, or one for each axis like 256,256,128");
    voxels.push_back(number.value());
  }
  return voxels;
}

Result<std::vector<double>> parse_periods(std::string_view text) {
  std::vector<double> periods;
  for (const auto part : split_commas(text)) {
    double number = 0;
    const auto [end, ec] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (ec != std::errc{} || end != part.data() + part.size() || periods.size() == 3)
      return refuse(text, "is not a period like 100, or one for each axis like 100,100,0");
    periods.push_back(number);
  }
  return periods;
}

Result<std::vector<int>> parse_classes(std::string_view text) {
  std::vector<int> classes;
  for (const auto part : split_commas(text)) {
    auto number = parse_integer(part, 0, 255);
    if (!number) return refuse(text, "is not a list of LAS classes (0 to 255) like 2,9");
    classes.push_back(static_cast<int>(number.value()));
  }
  return classes;
}

Result<std::vector<std::uint32_t>> parse_scans(std::string_view text) {
  std::vector<std::uint32_t> scans;
  for (const auto part : split_commas(text)) {
    auto number = parse_integer(part, 0, UINT32_MAX);
    if (!number) return refuse(text, "is not a list of numbers of scans, from 0, like 0,2");
    scans.push_back(static_cast<std::uint32_t>(number.value()));
  }
  return scans;
}

Result<std::vector<std::uint32_t>> parse_particles(std::string_view text) {
  BOOST_OUTCOME_TRY(names, parse_names(text));
  return snapshot::types_of_names(names);
}

Result<Cosmology> parse_cosmology(std::string_view text) {
  const auto parts = split_commas(text);
  if (parts.size() != 2) return refuse(text, "is not H0 in km/s/Mpc and the density of matter, like 70,0.3");
  const auto hubble = parse_finite(parts[0]), matter = parse_finite(parts[1]);
  if (!hubble || !matter) return refuse(text, "is not H0 in km/s/Mpc and the density of matter, like 70,0.3");
  const Cosmology cosmology{.hubble = hubble.value(), .matter = matter.value()};
  if (const auto why = why_no_cosmology(cosmology); !why.empty()) return error(Errc::usage, why);
  return cosmology;
}

Result<std::vector<std::string>> parse_names(std::string_view text) {
  std::vector<std::string> names;
  for (const auto part : split_commas(text)) {
    if (part.empty()) return refuse(text, "is not a list of names separated by commas");
    names.emplace_back(part);
  }
  return names;
}

Result<std::vector<std::string>> parse_columns(std::string_view text) {
  BOOST_OUTCOME_TRY(names, parse_names(text));
  BOOST_OUTCOME_TRYV(check_columns(names));
  return std::move(names);
}

Result<std::vector<Point>> parse_line(const std::string& text) {
  std::vector<Point> line;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t comma = word.find(',');
    const auto x = parse_finite(word.substr(0, comma));
    const auto y = parse_finite(comma == std::string::npos ? "" : word.substr(comma + 1));
    if (!x || !y) return error(Errc::usage, "'" + text + "' is neither points like '0,0 50,20' nor a GeoJSON file");
    line.push_back(without_negative_zero({x.value(), y.value(), 0}));
  }
  if (line.size() < 2) return error(Errc::usage, "'" + text + "' has fewer than two points");
  return line;
}

}  // namespace tessera
