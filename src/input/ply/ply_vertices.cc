#include "src/input/ply/ply_vertices.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/bytes/number.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

// Binary vertices without lists: the records of the file.
class FixedVertices : public PlyVertices {
 public:
  FixedVertices(RecordStream records, const PlyElement& vertex, bool swapped) : records_(std::move(records)) {
    for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
      scalars_.push_back({i, record_bytes_, vertex.properties[i].type, swapped});
      record_bytes_ += size_of(vertex.properties[i].type);
    }
  }
  Result<std::span<const std::byte>> next(std::size_t most) override { return records_.next(most); }
  bool seek(std::uint64_t index) override {
    records_.seek(index);
    return true;
  }
  std::string place(std::size_t index) const override {
    return "record " + std::to_string(records_.first_of_last_block() + index);
  }

 private:
  RecordStream records_;
};

// Reads forward through a binary body, block by block.
class ByteCursor {
 public:
  ByteCursor(std::unique_ptr<ByteSource> source, std::uint64_t at) : source_(std::move(source)), at_(at) {}

  const ByteSource& source() const { return *source_; }
  std::uint64_t position() const { return at_; }
  std::uint64_t left() const { return source_->size() - at_; }
  std::unique_ptr<ByteSource> release() { return std::move(source_); }

  // Skips `count` items of `bytes` bytes each. Returns false if the file is shorter.
  bool skip(std::uint64_t count, std::size_t bytes) {
    if (bytes != 0 && count > left() / bytes) return false;
    at_ += count * bytes;
    return true;
  }
  // Returns a pointer to the next `n` <= 8 bytes and skips them. REQUIRES: left() >= n.
  Result<const std::byte*> take(std::size_t n) {
    if (at_ < block_at_ || at_ + n > block_at_ + block_.size()) {
      block_at_ = at_;
      block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(left(), 1 << 18)));
      BOOST_OUTCOME_TRYV(source_->read(at_, block_));
    }
    const std::byte* there = block_.data() + (at_ - block_at_);
    at_ += n;
    return there;
  }

 private:
  std::unique_ptr<ByteSource> source_;
  std::uint64_t at_;
  std::uint64_t block_at_ = 0;
  std::vector<std::byte> block_;
};

// Walks over binary elements: scalars are kept or skipped, lists are skipped.
class ElementWalk {
 public:
  ElementWalk(const PlyElement& element, bool swapped) : element_(element), swapped_(swapped) {}

  // Walks over one element and appends its scalars to `kept` unless `kept` is null. Returns false if the file ends
  // within the element.
  Result<bool> step(ByteCursor& cursor, std::byte* kept) const {
    for (const auto& property : element_.properties) {
      const std::size_t bytes = size_of(property.type);
      if (property.count) {
        const std::size_t count_bytes = size_of(*property.count);
        if (cursor.left() < count_bytes) return false;
        BOOST_OUTCOME_TRY(at, cursor.take(count_bytes));
        // The length is read as a signed number, so that a negative length is noticed. An unsigned one would become 0.
        std::int64_t count = 0;
        column_copy(*property.count, swapped_, AttributeType::i64)(at, 0, reinterpret_cast<std::byte*>(&count), 0, 1);
        if (count < 0 || !cursor.skip(static_cast<std::uint64_t>(count), bytes)) return false;
        continue;
      }
      if (cursor.left() < bytes) return false;
      BOOST_OUTCOME_TRY(at, cursor.take(bytes));
      if (kept != nullptr) {
        std::memcpy(kept, at, bytes);
        kept += bytes;
      }
    }
    return true;
  }

 private:
  const PlyElement& element_;
  bool swapped_;
};

// Binary vertices with lists: their scalars are copied to records.
class ListVertices : public PlyVertices {
 public:
  ListVertices(ByteCursor cursor, PlyElement vertex, bool swapped)
      : cursor_(std::move(cursor)), vertex_(std::move(vertex)), swapped_(swapped) {
    for (std::size_t i = 0; i < vertex_.properties.size(); ++i) {
      if (vertex_.properties[i].count) continue;
      scalars_.push_back({i, record_bytes_, vertex_.properties[i].type, swapped});
      record_bytes_ += size_of(vertex_.properties[i].type);
    }
  }

  Result<std::span<const std::byte>> next(std::size_t most) override {
    first_ = position_;
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(
        vertex_.count - position_, std::min({most, batch_points_max, block_bytes_max / record_bytes_ + 1})));
    if (n == 0) {
      BOOST_OUTCOME_TRYV(cursor_.source().check_unchanged());
    }
    // The block is not larger than the file permits, whatever the header says.
    block_.resize(record_bytes_ * static_cast<std::size_t>(std::min<std::uint64_t>(n, cursor_.left() + 1)));
    const ElementWalk walk(vertex_, swapped_);
    for (std::size_t i = 0; i < n; ++i, ++position_) {
      const bool fits = (i + 1) * record_bytes_ <= block_.size();
      BOOST_OUTCOME_TRY(whole, fits ? walk.step(cursor_, block_.data() + i * record_bytes_) : Result<bool>(false));
      if (!whole)
        return error(Errc::bad_input, cursor_.source().path().string() + ", record " + std::to_string(position_) +
                                          ": the file ends within it, or a list in it has an impossible length; " +
                                          std::to_string(vertex_.count) + " vertices are promised");
    }
    return std::span<const std::byte>(block_);
  }
  bool seek(std::uint64_t) override { return false; }
  std::string place(std::size_t index) const override { return "record " + std::to_string(first_ + index); }

 private:
  ByteCursor cursor_;
  PlyElement vertex_;
  bool swapped_;
  std::uint64_t position_ = 0, first_ = 0;
  std::vector<std::byte> block_;
};

// ASCII vertices, one a line: their scalars as doubles.
class TextVertices : public PlyVertices {
 public:
  TextVertices(LineReader lines, PlyElement vertex) : lines_(std::move(lines)), vertex_(std::move(vertex)) {
    for (std::size_t i = 0; i < vertex_.properties.size(); ++i) {
      if (vertex_.properties[i].count) continue;
      scalars_.push_back({i, record_bytes_, AttributeType::f64, false});
      record_bytes_ += sizeof(double);
    }
  }

  Result<std::span<const std::byte>> next(std::size_t most) override {
    block_.clear();
    numbers_.clear();
    most = std::min({most, batch_points_max, block_bytes_max / record_bytes_ + 1});
    if (position_ == vertex_.count) {
      BOOST_OUTCOME_TRYV(lines_.source().check_unchanged());
    }
    for (; numbers_.size() < most && position_ < vertex_.count; ++position_) {
      BOOST_OUTCOME_TRY(line, next_line(lines_));
      if (!line)
        return lines_.bad_line("the file ends after " + std::to_string(position_) + " of " +
                               std::to_string(vertex_.count) + " vertices");
      split_line(*line, Delimiter::blanks, SIZE_MAX, words_);
      BOOST_OUTCOME_TRYV(add_words());
      numbers_.push_back(lines_.number());
    }
    return std::as_bytes(std::span<const double>(block_));
  }
  bool seek(std::uint64_t) override { return false; }
  std::string place(std::size_t index) const override {
    return "line " + std::to_string(index < numbers_.size() ? numbers_[index] : lines_.number());
  }

  static Result<std::optional<std::string_view>> next_line(LineReader& lines) {
    while (true) {
      BOOST_OUTCOME_TRY(line, lines.next());
      if (!line || line->find_first_not_of(" \t") != std::string_view::npos) return line;
    }
  }

 private:
  Status add_words() {
    std::size_t word = 0;
    for (const auto& property : vertex_.properties) {
      if (word >= words_.size())
        return lines_.bad_line("property '" + printable(property.name.substr(0, 40)) + "' is missing");
      const auto value = parse_number(words_[word]);
      if (!value)
        return lines_.bad_line("property '" + printable(property.name.substr(0, 40)) + "' is '" +
                               printable(words_[word].substr(0, 40)) + "', not a number");
      ++word;
      if (!property.count) {
        block_.push_back(*value);
      } else if (*value >= 0 && *value <= static_cast<double>(words_.size() - word)) {
        word += static_cast<std::size_t>(*value);
      } else {
        return lines_.bad_line("a list has an impossible length");
      }
    }
    return success();
  }

  LineReader lines_;
  PlyElement vertex_;
  std::uint64_t position_ = 0;
  std::vector<double> block_;
  std::vector<std::string_view> words_;
  std::vector<std::uint64_t> numbers_;
};

Error ends_within(const ByteSource& source, const PlyElement& element) {
  return error(Errc::bad_input, source.path().string() + ": the file ends within the " + std::to_string(element.count) +
                                    " elements '" + printable(element.name.substr(0, 40)) + "'");
}

Result<std::unique_ptr<PlyVertices>> open_text_vertices(std::unique_ptr<ByteSource> source, const PlyHeader& header) {
  LineReader lines(std::move(source), header.body_at);
  lines.count_from(header.lines);
  for (std::size_t e = 0; e < header.vertex; ++e) {
    const auto& element = header.elements[e];
    if (element.properties.empty()) continue;  // such an element takes no line
    for (std::uint64_t i = 0; i < element.count; ++i) {
      BOOST_OUTCOME_TRY(line, TextVertices::next_line(lines));
      if (!line) return ends_within(lines.source(), element);
    }
  }
  return std::unique_ptr<PlyVertices>(new TextVertices(std::move(lines), header.elements[header.vertex]));
}

}  // namespace

Result<std::unique_ptr<PlyVertices>> open_ply_vertices(std::unique_ptr<ByteSource> source, const PlyHeader& header) {
  const auto& vertex = header.elements[header.vertex];
  // A vertex takes at least a byte. Refusing here avoids that code reserves memory for 2^60 vertices.
  if (vertex.count > source->size()) return ends_within(*source, vertex);
  if (header.format == PlyFormat::ascii) return open_text_vertices(std::move(source), header);

  const bool swapped = header.format == PlyFormat::binary_big_endian;
  ByteCursor cursor(std::move(source), header.body_at);
  for (std::size_t e = 0; e < header.vertex; ++e) {
    const auto& element = header.elements[e];
    if (const auto bytes = element.fixed_bytes()) {
      if (!cursor.skip(element.count, *bytes)) return ends_within(cursor.source(), element);
      continue;
    }
    const ElementWalk walk(element, swapped);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      BOOST_OUTCOME_TRY(whole, walk.step(cursor, nullptr));
      if (!whole) return ends_within(cursor.source(), element);
    }
  }
  if (const auto bytes = vertex.fixed_bytes()) {
    const auto at = cursor.position();
    RecordStream records(cursor.release(), at, *bytes, vertex.count);
    BOOST_OUTCOME_TRYV(records.check_size());
    return std::unique_ptr<PlyVertices>(new FixedVertices(std::move(records), vertex, swapped));
  }
  return std::unique_ptr<PlyVertices>(new ListVertices(std::move(cursor), vertex, swapped));
}

}  // namespace tessera
