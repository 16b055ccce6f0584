// What the readers of meshes in text have in common: vertices, one after the other, whose attributes are doubles.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/reader.h"

namespace tessera {

class VertexTextReader : public PointReader {
 public:
  const FileInfo& info() const final { return info_; }
  Status next(PointBatch& batch, std::size_t most) final;
  Result<bool> seek(std::uint64_t) final { return false; }
  std::string place(std::size_t index) const final;

 protected:
  VertexTextReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema);

  LineReader& lines() { return lines_; }
  // Replaces `values`: x, y, z, and a number for each attribute of info(). False at the end, for ever after.
  virtual Result<bool> next_vertex(std::vector<double>& values) = 0;

 private:
  struct Cell {
    std::size_t value, row_offset;
    ColumnCopy copy;
  };

  FileInfo info_;
  LineReader lines_;
  std::size_t row_bytes_;
  std::vector<Cell> cells_;
  std::vector<double> values_;
  std::vector<std::uint64_t> numbers_;  // the lines of the last batch's points
};

// x, y, z, and the names of `attributes`.
std::vector<std::string> names_of_values(const std::vector<Attribute>& attributes);

// Appends the numbers that `words` are; the error names the line and, of `names`, the one whose word is no number.
// REQUIRES: as many names as words.
Status add_numbers(std::span<const std::string_view> words, std::span<const std::string> names, const LineReader& lines,
                   std::vector<double>& values);

}  // namespace tessera
