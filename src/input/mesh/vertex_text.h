// The common part of readers of meshes as text: a sequence of vertices whose attributes are doubles.
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

// A derived class reads the vertices one by one.
class VertexTextReader : public PointReader {
 public:
  const FileInfo& info() const final { return info_; }
  Status next(PointBatch& batch, std::size_t most) final;
  Result<bool> seek(std::uint64_t) final { return false; }
  std::string place(std::size_t index) const final;

 protected:
  VertexTextReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema);

  LineReader& lines() { return lines_; }
  // Replaces `values` by x, y, z and one number for each attribute of info(). Returns false at the end, and after that
  // always.
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
  std::vector<std::uint64_t> numbers_;  // the line of each point of the last batch
};

// Replaces `words` by the words of the next line that has some. The character `comment` begins a comment that ends with
// the line. Returns false at the end of the file.
Result<bool> next_words(LineReader& lines, std::vector<std::string_view>& words, char comment = '\0');

// The names x, y, z and those of `attributes`.
std::vector<std::string> names_of_values(const std::vector<Attribute>& attributes);

// Appends the numbers in `words` to `values`. An error names the line, and the name in `names` of the word that is not
// a number. REQUIRES: there are as many names as words.
Status add_numbers(std::span<const std::string_view> words, std::span<const std::string> names, const LineReader& lines,
                   std::vector<double>& values);

}  // namespace tessera
