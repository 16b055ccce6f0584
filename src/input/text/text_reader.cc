#include "src/input/text/text_reader.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/bytes/number.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

constexpr std::uint64_t part_bytes = std::uint64_t{1} << 20;

bool has_content(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return false;
  line.remove_prefix(first);
  return line.front() != '#' && !line.starts_with("//");
}

// The next line that is neither blank nor a comment.
Result<std::optional<std::string_view>> next_content(LineReader& lines) {
  while (true) {
    BOOST_OUTCOME_TRY(line, lines.next());
    if (!line || has_content(*line)) return line;
  }
}

class TextReader : public PointReader {
 public:
  // Reads the lines that begin before `end`, except the line at `header_at`.
  TextReader(FileInfo info, LineReader lines, std::uint64_t header_at, std::uint64_t end, TextColumns columns,
             const std::vector<Attribute>& schema)
      : info_(std::move(info)),
        lines_(std::move(lines)),
        header_at_(header_at),
        end_(end),
        columns_(std::move(columns)),
        row_bytes_(row_bytes(schema)) {
    for (const auto c : columns_.coordinates) fields_used_ = std::max(fields_used_, c + 1);
    const auto offsets = row_offsets(schema);
    for (std::size_t i = 0; i < schema.size(); ++i) {
      for (const auto& extra : columns_.extras) {
        if (extra.attribute.name != schema[i].name) continue;
        cells_.push_back({extra.column, offsets[i], column_copy(AttributeType::f64, false, schema[i].type)});
        fields_used_ = std::max(fields_used_, extra.column + 1);
      }
    }
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    batch.points.clear();
    batch.rows.clear();
    numbers_.clear();
    most = points_at_once(most, row_bytes_);
    while (batch.points.size() < most) {
      BOOST_OUTCOME_TRY(line, next_content(lines_));
      if (!line) break;
      if (lines_.line_at() >= end_) {
        BOOST_OUTCOME_TRYV(lines_.source().check_unchanged());
        break;
      }
      if (columns_.has_header && lines_.line_at() == header_at_) continue;
      BOOST_OUTCOME_TRYV(add(*line, batch));
    }
    return success();
  }

  Result<bool> seek(std::uint64_t) override { return false; }

  std::string place(std::size_t index) const override {
    return "line " + std::to_string(index < numbers_.size() ? numbers_[index] : lines_.number());
  }

 private:
  struct Cell {
    std::size_t column, row_offset;
    ColumnCopy copy;
  };

  Status add(std::string_view line, PointBatch& batch) {
    split_line(line, columns_.delimiter, fields_used_, fields_);
    Point p;
    for (std::size_t axis = 0; axis < columns_.coordinates.size(); ++axis) {
      const std::size_t column = columns_.coordinates[axis];
      const auto name = [&] { return std::string(1, "xyz"[axis]); };
      if (column >= fields_.size())
        return lines_.bad_line(name() + " is missing: there are " + std::to_string(fields_.size()) + " columns");
      const auto value = parse_number(fields_[column]);
      if (!value) return lines_.bad_line(name() + " is " + in_quotes(fields_[column]) + ", not a number");
      p[static_cast<int>(axis)] = *value;
    }
    batch.points.push_back(p);
    numbers_.push_back(lines_.number());
    if (row_bytes_ == 0) return success();
    const std::size_t row = batch.rows.size();
    batch.rows.resize(row + row_bytes_);
    for (const auto& cell : cells_) {
      double value = std::numeric_limits<double>::quiet_NaN();
      if (cell.column < fields_.size() && !fields_[cell.column].empty()) {
        const auto number = parse_number(fields_[cell.column]);
        if (!number)
          return lines_.bad_line("column " + std::to_string(cell.column + 1) + " is " +
                                 in_quotes(fields_[cell.column]) + ", not a number");
        value = *number;
      }
      cell.copy(reinterpret_cast<const std::byte*>(&value), 0, batch.rows.data() + row + cell.row_offset, 0, 1);
    }
    return success();
  }

  FileInfo info_;
  LineReader lines_;
  std::uint64_t header_at_, end_;
  TextColumns columns_;
  std::size_t row_bytes_;
  std::size_t fields_used_ = 0;
  std::vector<Cell> cells_;
  std::vector<std::string_view> fields_;
  std::vector<std::uint64_t> numbers_;  // the line of each point of the last batch
};

// Whether a line of numbers and the lines after it count up; see counts_up().
Result<bool> looks_counted(LineReader& lines, std::string first, Delimiter delimiter) {
  constexpr std::size_t looked_at = 32, begin_bytes = 256;
  std::vector<std::string> some{std::move(first)};
  while (some.size() < looked_at) {
    BOOST_OUTCOME_TRY(line, next_content(lines));
    if (!line) break;
    some.emplace_back(line->substr(0, begin_bytes));
  }
  return counts_up(some, delimiter);
}

// The number of lines that end before `end`.
Result<std::uint64_t> count_lines(const ByteSource& source, std::uint64_t end) {
  std::vector<std::byte> block(std::size_t{1} << 18);
  std::uint64_t count = 0;
  for (std::uint64_t at = 0; at < end;) {
    const auto part = std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), end - at)));
    BOOST_OUTCOME_TRYV(source.read(at, part));
    count += static_cast<std::uint64_t>(std::count(part.begin(), part.end(), std::byte{'\n'}));
    at += part.size();
  }
  return count;
}

}  // namespace

Result<std::unique_ptr<PointReader>> open_text(std::unique_ptr<ByteSource> source,
                                               const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRYV(check_is_text(*source));
  FileInfo info = info_of(*source, "xyz");
  info.parts = (source->size() + part_bytes - 1) / part_bytes;

  LineReader lines(std::move(source));
  BOOST_OUTCOME_TRY(first, next_content(lines));
  if (!first) return error(Errc::bad_input, info.path.string() + ": holds no points, only blank lines and comments");
  const std::uint64_t header_at = lines.line_at();
  std::string header;
  std::string numbers(*first);
  if (is_header(*first, hints.columns)) {
    header = std::move(numbers);
    BOOST_OUTCOME_TRY(second, next_content(lines));
    if (!second) return lines.bad_line("the file ends after its header, or the line before is not numbers");
    numbers = std::string(*second);
  }
  TextColumns columns;
  const std::string wrong = settle_columns(header, numbers, hints.columns, columns);
  if (!wrong.empty()) return lines.bad_line(wrong);
  if (!hints.part && columns.found_by == CoordinateColumns::By::place && columns.coordinates.size() == 3) {
    BOOST_OUTCOME_TRY(counting, looks_counted(lines, std::move(numbers), columns.delimiter));
    info.counts_up = counting;
  }
  lines.rewind();
  const std::uint64_t end = hints.part ? (*hints.part + 1) * part_bytes : UINT64_MAX;
  if (hints.part.value_or(0) > 0) {
    // The line that began before the part is skipped. It ends in the part or just before it.
    const std::uint64_t before = *hints.part * part_bytes - 1;
    lines = LineReader(lines.take_source(), before);
    if (hints.count_lines) {
      BOOST_OUTCOME_TRY(count, count_lines(lines.source(), before));
      lines.count_from(count);
    }
    BOOST_OUTCOME_TRYV(lines.next());
  }

  info.dimension = static_cast<int>(columns.coordinates.size());
  info.degrees = columns.degrees;
  const char* parted = columns.delimiter == Delimiter::comma       ? "commas"
                       : columns.delimiter == Delimiter::semicolon ? "semicolons"
                       : columns.delimiter == Delimiter::tab       ? "tabs"
                                                                   : "blanks";
  info.columns = CoordinateColumns{{}, columns.found_by};
  for (const auto column : columns.coordinates) info.columns->numbers.push_back(column + 1);
  info.detail = std::string("text, columns parted by ") + parted + (columns.has_header ? ", with header" : "");
  for (const auto& extra : columns.extras) info.attributes.push_back(extra.attribute);
  return std::unique_ptr<PointReader>(
      new TextReader(std::move(info), std::move(lines), header_at, end, std::move(columns), attributes));
}

}  // namespace tessera
