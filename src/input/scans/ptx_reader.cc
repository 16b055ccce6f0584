#include "src/input/scans/ptx_reader.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/bytes/number.h"
#include "src/input/mesh/vertex_text.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

constexpr std::size_t header_lines = 10;

using Words = std::vector<std::string_view>;

// The header of a scan: the size of its grid, and the matrix that moves its points. Points are rows: p' = (p, 1) M.
struct ScanHeader {
  std::uint64_t pulses = 0;
  std::array<std::array<double, 4>, 4> matrix{};

  Point move(const Point& p) const {
    Point moved;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      moved[axis] = p.x * matrix[0][a] + p.y * matrix[1][a] + p.z * matrix[2][a] + matrix[3][a];
    }
    return moved;
  }
};

Result<std::uint64_t> grid_size(const Words& words, const char* what, const LineReader& lines) {
  std::uint64_t size = 0;
  const auto word = words[0];
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), size);
  if (words.size() != 1 || code != std::errc() || end != word.data() + word.size() || size > UINT32_MAX)
    return lines.bad_line(std::string("a scan of a PTX file begins here, and this line is not its number of ") + what);
  return size;
}

Status numbers_of(const Words& words, std::size_t count, const char* what, const LineReader& lines, double* numbers) {
  if (words.size() != count)
    return lines.bad_line(std::string(what) + " is a line of " + std::to_string(count) +
                          " numbers, but this line has " + std::to_string(words.size()));
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = parse_number(words[i]);
    if (!number || !std::isfinite(*number))
      return lines.bad_line(std::string(what) + " has " + in_quotes(words[i]) + ", which is not a finite number");
    numbers[i] = *number;
  }
  return success();
}

// Reads the ten lines before the points of a scan. Returns nothing at the end of the file.
Result<std::optional<ScanHeader>> next_header(LineReader& lines, Words& words) {
  ScanHeader header;
  std::uint64_t columns = 0;
  std::array<double, 3> of_scanner{};
  for (std::size_t line = 0; line < header_lines; ++line) {
    BOOST_OUTCOME_TRY(there, next_words(lines, words));
    if (!there && line == 0) return std::optional<ScanHeader>();
    if (!there) return lines.bad_line("the file ends within the header of a scan");
    if (line == 0) {
      BOOST_OUTCOME_TRY(size, grid_size(words, "columns", lines));
      columns = size;
    } else if (line == 1) {
      BOOST_OUTCOME_TRY(size, grid_size(words, "rows", lines));
      header.pulses = columns * size;
    } else if (line < 6) {
      BOOST_OUTCOME_TRYV(numbers_of(words, 3, line == 2 ? "the scanner's position" : "a direction of the scanner",
                                    lines, of_scanner.data()));
    } else {
      BOOST_OUTCOME_TRYV(numbers_of(words, 4, "a row of the scan's matrix", lines, header.matrix[line - 6].data()));
    }
  }
  for (std::size_t row = 0; row < 4; ++row)
    if (header.matrix[row][3] != (row == 3 ? 1.0 : 0.0))
      return lines.bad_line("the matrix of the scan is not a motion: its last column is not 0 0 0 1");
  return std::optional(header);
}

class PtxReader : public VertexTextReader {
 public:
  PtxReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema)
      : VertexTextReader(std::move(info), std::move(lines), schema),
        names_(names_of_values(this->info().attributes)),
        colours_(this->info().attributes.size() > 5) {}

 private:
  Result<bool> next_vertex(std::vector<double>& values) override {
    while (true) {
      if (at_end_) return false;
      if (left_ == 0) {
        BOOST_OUTCOME_TRY(header, next_header(lines(), words_));
        at_end_ = !header;
        if (!header) continue;
        header_ = *header;
        left_ = header_.pulses;
        ++scan_;
        continue;
      }
      BOOST_OUTCOME_TRY(echo, next_pulse(values));
      if (echo) return true;
    }
  }

  // Reads a pulse. Returns false if it has no echo.
  Result<bool> next_pulse(std::vector<double>& values) {
    BOOST_OUTCOME_TRY(there, next_words(lines(), words_));
    if (!there)
      return lines().bad_line("the file ends " + std::to_string(left_) + " points before the end of scan " +
                              std::to_string(scan_));
    if (words_.size() != 4 && words_.size() != 7)
      return lines().bad_line("a point of a PTX file is a line of 4 or 7 numbers, but this line has " +
                              std::to_string(words_.size()));
    --left_;
    values.clear();
    const std::size_t wanted = colours_ ? 7 : 4, known = std::min(wanted, words_.size());
    BOOST_OUTCOME_TRYV(add_numbers(std::span(words_).first(known), std::span(names_).first(known), lines(), values));
    if (values[0] == 0 && values[1] == 0 && values[2] == 0) return false;
    values.resize(wanted, std::numeric_limits<double>::quiet_NaN());
    const Point p = header_.move({values[0], values[1], values[2]});
    for (int axis = 0; axis < 3; ++axis) values[static_cast<std::size_t>(axis)] = p[axis];
    values.push_back(static_cast<double>(scan_));
    const auto& scanner = header_.matrix[3];  // the scanner is the origin of its scan
    values.insert(values.end(), scanner.begin(), scanner.begin() + 3);
    return true;
  }

  std::vector<std::string> names_;
  bool colours_;
  bool at_end_ = false;
  ScanHeader header_;
  std::uint64_t left_ = 0;
  std::int64_t scan_ = -1;
  Words words_;
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_ptx(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  BOOST_OUTCOME_TRYV(check_is_text(*source));
  FileInfo info = info_of(*source, "ptx");
  LineReader lines(std::move(source));
  Words words;
  BOOST_OUTCOME_TRY(header, next_header(lines, words));
  if (!header) return error(Errc::bad_input, info.path.string() + ": holds no scan, only blank lines");
  BOOST_OUTCOME_TRY(there, next_words(lines, words));
  const bool colours = there && words.size() == 7;
  lines.rewind();
  info.detail = colours ? "PTX, text, with colours" : "PTX, text";
  info.attributes.push_back({"intensity", AttributeType::f32});
  if (colours)
    for (const char* name : {"red", "green", "blue"}) info.attributes.push_back({name, AttributeType::u8});
  info.attributes.push_back({"scan", AttributeType::u32});
  for (const auto name : scanner_position) info.attributes.push_back({std::string(name), AttributeType::f64});
  return std::unique_ptr<PointReader>(new PtxReader(std::move(info), std::move(lines), attributes));
}

}  // namespace tessera
