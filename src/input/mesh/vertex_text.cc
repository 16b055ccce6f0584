#include "src/input/mesh/vertex_text.h"

#include <algorithm>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/number.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/text/text_columns.h"

namespace tessera {

VertexTextReader::VertexTextReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema)
    : info_(std::move(info)), lines_(std::move(lines)), row_bytes_(row_bytes(schema)) {
  const auto offsets = row_offsets(schema);
  for (std::size_t i = 0; i < schema.size(); ++i)
    for (std::size_t a = 0; a < info_.attributes.size(); ++a)
      if (info_.attributes[a].name == schema[i].name)
        cells_.push_back({3 + a, offsets[i], column_copy(AttributeType::f64, false, schema[i].type)});
}

Status VertexTextReader::next(PointBatch& batch, std::size_t most) {
  batch.points.clear();
  batch.rows.clear();
  numbers_.clear();
  most = points_at_once(most, row_bytes_);
  while (batch.points.size() < most) {
    BOOST_OUTCOME_TRY(there, next_vertex(values_));
    if (!there) break;
    batch.points.push_back({values_[0], values_[1], values_[2]});
    numbers_.push_back(lines_.number());
    if (row_bytes_ == 0) continue;
    const std::size_t row = batch.rows.size();
    batch.rows.resize(row + row_bytes_);
    for (const auto& cell : cells_)
      cell.copy(reinterpret_cast<const std::byte*>(&values_[cell.value]), 0, batch.rows.data() + row + cell.row_offset,
                0, 1);
  }
  return success();
}

std::string VertexTextReader::place(std::size_t index) const {
  return "line " + std::to_string(index < numbers_.size() ? numbers_[index] : lines_.number());
}

Result<bool> next_words(LineReader& lines, std::vector<std::string_view>& words, char comment) {
  do {
    BOOST_OUTCOME_TRY(line, lines.next());
    if (!line) return false;
    const auto text = comment == '\0' ? *line : line->substr(0, line->find(comment));
    split_line(text, Delimiter::blanks, SIZE_MAX, words);
  } while (words.empty());
  return true;
}

std::vector<std::string> names_of_values(const std::vector<Attribute>& attributes) {
  std::vector<std::string> names{"x", "y", "z"};
  for (const auto& attribute : attributes) names.push_back(attribute.name);
  return names;
}

Status add_numbers(std::span<const std::string_view> words, std::span<const std::string> names, const LineReader& lines,
                   std::vector<double>& values) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = parse_number(words[i]);
    if (!value) return lines.bad_line(names[i] + " is " + in_quotes(words[i]) + ", not a number");
    values.push_back(*value);
  }
  return success();
}

}  // namespace tessera
