#include "src/input/text/text_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/number.h"
#include "src/input/column_names.h"

namespace tessera {
namespace {

constexpr std::size_t columns_max = 4096;

bool is_blank(char c) { return c == ' ' || c == '\t'; }

std::string_view trimmed(std::string_view field) {
  while (!field.empty() && is_blank(field.front())) field.remove_prefix(1);
  while (!field.empty() && is_blank(field.back())) field.remove_suffix(1);
  return field;
}

std::string_view unquoted(std::string_view field) {
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
    return trimmed(field.substr(1, field.size() - 2));
  return field;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (auto& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// The bare name in lower case: "Easting [m]" and "easting_m" become "easting".
std::string bare(std::string_view name) {
  std::string text = lower(name);
  for (const std::string_view unit : {"[m]", "(m)", "_m", "[ft]", "(ft)", "_ft", "[deg]", "(deg)"}) {
    if (text.size() > unit.size() && text.ends_with(unit)) text.resize(text.size() - unit.size());
  }
  return std::string(trimmed(text));
}

// Sets the columns of x, y and z by their names. The first family of names with both x and y is used.
void coordinates_by_name(const std::vector<std::string_view>& names, TextColumns& columns) {
  using Names = std::array<std::string_view, 8>;
  struct Family {
    Names x, y;
    bool degrees;
  };
  constexpr std::array<Family, 3> families{Family{{"x"}, {"y"}, false},
                                           Family{{"easting", "e", "east"}, {"northing", "n", "north"}, false},
                                           Family{{"lon", "longitude", "lng", "long"}, {"lat", "latitude"}, true}};
  constexpr Names heights{"z", "elevation", "height", "up", "elev", "altitude", "alt", "h"};
  const auto find = [&](const Names& wanted) -> std::optional<std::size_t> {
    for (const auto name : wanted) {
      if (name.empty()) break;
      for (std::size_t i = 0; i < names.size(); ++i)
        if (bare(names[i]) == name) return i;
    }
    return std::nullopt;
  };
  for (const auto& family : families) {
    const auto x = find(family.x), y = find(family.y), z = find(heights);
    if (!x || !y) continue;
    columns.coordinates = {*x, *y};
    if (z) columns.coordinates.push_back(*z);
    columns.degrees = family.degrees;
    columns.found_by = CoordinateColumns::By::header;
    return;
  }
}

}  // namespace

Delimiter delimiter_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return Delimiter::semicolon;
  if (line.find(',') != std::string_view::npos) return Delimiter::comma;
  if (line.find('\t') == std::string_view::npos) return Delimiter::blanks;
  std::vector<std::string_view> fields;
  split_line(line, Delimiter::tab, columns_max, fields);
  const bool inner_blanks = std::any_of(
      fields.begin(), fields.end(), [](std::string_view field) { return field.find(' ') != std::string_view::npos; });
  return inner_blanks ? Delimiter::blanks : Delimiter::tab;
}

void split_line(std::string_view line, Delimiter delimiter, std::size_t most, std::vector<std::string_view>& fields) {
  fields.clear();
  if (delimiter == Delimiter::blanks) {
    const char* at = line.data();
    const char* const end = at + line.size();
    while (fields.size() < most) {
      while (at != end && is_blank(*at)) ++at;
      if (at == end) break;
      const char* const begin = at;
      while (at != end && !is_blank(*at)) ++at;
      fields.push_back(unquoted({begin, static_cast<std::size_t>(at - begin)}));
    }
    return;
  }
  const char mark = static_cast<char>(delimiter);
  std::size_t begin = 0;
  while (fields.size() < most) {
    std::size_t from = begin;
    while (from < line.size() && is_blank(line[from]) && line[from] != mark) ++from;
    // A quoted field ends at its closing quote, whatever is in between. A quote without a closing one is an ordinary
    // character.
    if (from < line.size() && line[from] == '"') {
      const std::size_t closing = line.find('"', from + 1);
      from = closing == std::string_view::npos ? begin : closing;
    } else {
      from = begin;
    }
    const std::size_t end = std::min(line.find(mark, from), line.size());
    fields.push_back(unquoted(trimmed(line.substr(begin, end - begin))));
    if (end == line.size()) break;
    begin = end + 1;
  }
}

bool is_header(std::string_view line, std::span<const std::string> names) {
  const auto named = names.empty() ? std::vector<std::size_t>{0, 1} : find_columns(names).coordinates;
  std::vector<std::string_view> fields;
  split_line(line, delimiter_of(line), std::max(named[0], named[1]) + 1, fields);
  // A field that begins like a number is a wrong number ("1,5" between semicolons), not a name.
  return std::any_of(named.begin(), named.begin() + 2, [&](std::size_t column) {
    const auto field = column < fields.size() ? fields[column] : std::string_view();
    return !field.empty() && std::string_view("0123456789+-.").find(field[0]) == std::string_view::npos &&
           !parse_number(field);
  });
}

bool counts_up(std::span<const std::string> lines, Delimiter delimiter) {
  constexpr std::size_t least = 3;
  std::vector<std::string_view> fields;
  std::optional<std::int64_t> last;
  std::string first_of_second;
  bool varies = false;
  for (const std::string& line : lines) {
    split_line(line, delimiter, 2, fields);
    if (fields.size() < 2) return false;
    std::int64_t number = 0;
    const char* const end = fields[0].data() + fields[0].size();
    const auto [at, failed] = std::from_chars(fields[0].data(), end, number);
    if (failed != std::errc() || at != end) return false;
    if (last && (*last == std::numeric_limits<std::int64_t>::max() || number != *last + 1)) return false;
    if (!last) first_of_second = fields[1];
    varies = varies || fields[1] != first_of_second;
    last = number;
  }
  return varies && lines.size() >= least;
}

namespace {

// Sets the columns by the names of the user.
std::string columns_by_option(std::span<const std::string> names, const std::vector<std::string_view>& values,
                              TextColumns& columns) {
  const ColumnNames named = find_columns(names);
  if (auto wrong = too_few_columns(values.size(), named); !wrong.empty()) return wrong;
  columns.coordinates = named.coordinates;
  columns.found_by = CoordinateColumns::By::option;
  AttributeNames unique;
  for (const std::size_t i : named.others)
    if (values[i].empty() || parse_number(values[i]))
      columns.extras.push_back({{unique.make(names[i]), AttributeType::f64}, i});
  return "";
}

}  // namespace

std::string settle_columns(std::string_view header, std::string_view numbers, std::span<const std::string> given,
                           TextColumns& columns) {
  columns.has_header = !header.empty();
  columns.delimiter = delimiter_of(numbers);
  std::vector<std::string_view> names, values;
  // A header may have another delimiter than the numbers: "x, y, z" above "1 2 3".
  if (columns.has_header) split_line(header, delimiter_of(header), columns_max + 1, names);
  split_line(numbers, columns.delimiter, columns_max + 1, values);
  if (values.size() > columns_max || names.size() > columns_max)
    return "has more than " + std::to_string(columns_max) + " columns";
  if (!given.empty()) return columns_by_option(given, values, columns);

  coordinates_by_name(names, columns);
  if (columns.coordinates.empty()) {
    const auto is_number = [&](std::size_t i) { return i < values.size() && parse_number(values[i]).has_value(); };
    columns.coordinates = {0, 1};
    if (is_number(2)) columns.coordinates.push_back(2);
  }
  for (const auto column : columns.coordinates)
    if (column >= values.size())
      return "has " + std::to_string(values.size()) + " column" + (values.size() == 1 ? "" : "s") +
             (columns.has_header ? ", fewer than the header names" : "; a point needs at least 2");

  AttributeNames unique;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& c = columns.coordinates;
    if (std::find(c.begin(), c.end(), i) != c.end()) continue;
    if (!values[i].empty() && !parse_number(values[i])) continue;
    const std::string raw = i < names.size() ? std::string(names[i]) : "column_" + std::to_string(i + 1);
    columns.extras.push_back({{unique.make(raw), AttributeType::f64}, i});
  }
  return "";
}

}  // namespace tessera
