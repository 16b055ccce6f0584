#include "src/input/pcd/pcd_header.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/bytes/number_type.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

constexpr std::size_t lines_max = 1000;
constexpr std::size_t numbers_max = 4096;  // of a point

std::optional<std::uint64_t> whole_number(std::string_view word) {
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  return code == std::errc() && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

std::optional<AttributeType> type_of(std::string_view letter, std::uint64_t bytes) {
  if (letter == "F") return number_type(NumberKind::floating, bytes);
  if (letter == "I") return number_type(NumberKind::with_sign, bytes);
  if (letter == "U") return number_type(NumberKind::without_sign, bytes);
  return std::nullopt;
}

// Takes the lines of a header one by one.
class HeaderLines {
 public:
  // Takes a line. Returns what is wrong with it, or "".
  std::string take(std::span<const std::string_view> words) {
    const std::string_view key = words[0];
    const auto rest = words.subspan(1);
    if (!seen_.insert(std::string(key)).second) return in_quotes(key) + " is there twice";
    if (key == "VERSION" || key == "VIEWPOINT") return "";
    if (key == "FIELDS" || key == "COLUMNS") return take_names(rest);
    if (key == "SIZE") return take_numbers(rest, sizes_);
    if (key == "TYPE") return take_types(rest);
    if (key == "COUNT") return take_numbers(rest, counts_);
    if (key == "WIDTH") return take_number(rest, width_);
    if (key == "HEIGHT") return take_number(rest, height_);
    if (key == "POINTS") return take_number(rest, points_);
    if (key == "DATA") return take_data(rest);
    return in_quotes(key) + " is not a line of a PCD header";
  }
  bool at_end() const { return seen_.contains("DATA"); }

  // The header, or what is wrong with its lines together.
  std::string settle(PcdHeader& header) const {
    if (names_.empty()) return "the header has no line FIELDS";
    if (sizes_.size() != names_.size() || types_.size() != names_.size())
      return "the header names " + std::to_string(names_.size()) + " fields, but " + std::to_string(sizes_.size()) +
             " sizes and " + std::to_string(types_.size()) + " types";
    if (!counts_.empty() && counts_.size() != names_.size())
      return "the header names " + std::to_string(names_.size()) + " fields, but " + std::to_string(counts_.size()) +
             " counts";
    std::uint64_t numbers = 0;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto type = type_of(types_[i], sizes_[i]);
      const std::uint64_t count = counts_.empty() ? 1 : counts_[i];
      if (!type)
        return "field " + in_quotes(names_[i]) + " has type " + in_quotes(types_[i]) + " and size " +
               std::to_string(sizes_[i]) + "; types are I and U with 1, 2, 4 or 8 bytes, and F with 4 or 8";
      if (count > numbers_max || (numbers += count) > numbers_max)
        return "a point has more than " + std::to_string(numbers_max) + " numbers";
      header.fields.push_back({names_[i], *type, static_cast<std::size_t>(count)});
    }
    if (!points_ && !width_) return "the header does not say how many points there are";
    if (width_ && height_ && *height_ != 0 && *width_ > UINT64_MAX / *height_) return "WIDTH times HEIGHT is too large";
    const std::optional<std::uint64_t> grid = width_ ? std::optional(*width_ * height_.value_or(1)) : std::nullopt;
    if (points_ && grid && *points_ != *grid)
      return "POINTS is " + std::to_string(*points_) + ", but WIDTH times HEIGHT is " + std::to_string(*grid);
    header.points = points_ ? *points_ : *grid;
    header.data = data_;
    return "";
  }

 private:
  std::string take_names(std::span<const std::string_view> words) {
    if (words.size() > numbers_max) return "a point has more than " + std::to_string(numbers_max) + " fields";
    for (const auto word : words) names_.emplace_back(word);
    return "";
  }
  std::string take_types(std::span<const std::string_view> words) {
    for (const auto word : words) types_.emplace_back(word);
    return "";
  }
  static std::string take_numbers(std::span<const std::string_view> words, std::vector<std::uint64_t>& numbers) {
    for (const auto word : words) {
      const auto number = whole_number(word);
      if (!number) return in_quotes(word) + " is not a whole number";
      numbers.push_back(*number);
    }
    return "";
  }
  static std::string take_number(std::span<const std::string_view> words, std::optional<std::uint64_t>& number) {
    number = words.size() == 1 ? whole_number(words[0]) : std::nullopt;
    return number ? "" : "one whole number is expected";
  }
  std::string take_data(std::span<const std::string_view> words) {
    if (words.size() == 1 && words[0] == "ascii")
      data_ = PcdData::ascii;
    else if (words.size() == 1 && words[0] == "binary")
      data_ = PcdData::binary;
    else if (words.size() == 1 && words[0] == "binary_compressed")
      data_ = PcdData::binary_compressed;
    else
      return "DATA is ascii, binary or binary_compressed";
    return "";
  }

  std::set<std::string> seen_;
  std::vector<std::string> names_, types_;
  std::vector<std::uint64_t> sizes_, counts_;
  std::optional<std::uint64_t> width_, height_, points_;
  PcdData data_ = PcdData::ascii;
};

}  // namespace

std::size_t PcdHeader::point_bytes() const {
  std::size_t bytes = 0;
  for (const auto& field : fields) bytes += field.bytes();
  return bytes;
}

Result<PcdHeader> read_pcd_header(const ByteSource& source) {
  LineReader lines(share(std::shared_ptr<const ByteSource>(&source, [](const ByteSource*) {})));
  HeaderLines header_lines;
  std::vector<std::string_view> words;
  while (!header_lines.at_end()) {
    BOOST_OUTCOME_TRY(line, lines.next());
    if (!line) return error(Errc::bad_input, source.path().string() + ": ends within the PCD header");
    if (lines.number() > lines_max)
      return lines.bad_line("the PCD header has more than " + std::to_string(lines_max) + " lines");
    split_line(line->substr(0, line->find('#')), Delimiter::blanks, SIZE_MAX, words);
    if (words.empty()) continue;
    if (const auto wrong = header_lines.take(words); !wrong.empty()) return lines.bad_line(wrong);
  }
  PcdHeader header;
  if (const auto wrong = header_lines.settle(header); !wrong.empty())
    return error(Errc::bad_input, source.path().string() + ": " + wrong);
  header.lines = lines.number();
  header.body_at = lines.next_at();
  // A point takes at least a byte, or a thousandth of one if it is compressed. Refusing here avoids that code reserves
  // memory for 2^60 points.
  if (header.points / 1000 > source.size())
    return error(Errc::bad_input, source.path().string() + ": the header promises " + std::to_string(header.points) +
                                      " points, more than the file can hold");
  return header;
}

}  // namespace tessera
