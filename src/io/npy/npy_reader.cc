#include "src/io/npy/npy_reader.h"

#include <array>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/io/bytes/fields.h"
#include "src/io/bytes/record_stream.h"

namespace tessera {
namespace {

constexpr std::uint32_t header_bytes_max = 65'536;

struct ArrayHeader {
  std::string type;  // "<f8"; empty if it is not a plain string
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
};

// Reads the header's Python literal, {'descr': '<f8', 'fortran_order': False, 'shape': (17, 3), }, keys in any order.
class LiteralParser {
 public:
  explicit LiteralParser(std::string_view text) : rest_(text) {}

  std::optional<ArrayHeader> parse() {
    ArrayHeader header;
    int seen = 0;
    if (!take("{")) return std::nullopt;
    while (!take("}")) {
      const auto key = quoted();
      if (!key || !take(":")) return std::nullopt;
      bool good = false;
      if (*key == "descr") good = parse_type(header);
      if (*key == "fortran_order") good = parse_order(header);
      if (*key == "shape") good = parse_shape(header);
      if (!good) return std::nullopt;
      ++seen;
      take(",");
    }
    return seen == 3 ? std::optional(header) : std::nullopt;
  }

 private:
  bool take(std::string_view token) {
    while (!rest_.empty() && (rest_.front() == ' ' || rest_.front() == '\n')) rest_.remove_prefix(1);
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }

  std::optional<std::string> quoted() {
    char quote = '\'';
    if (!take("'")) {
      if (!take("\"")) return std::nullopt;
      quote = '"';
    }
    const std::size_t end = rest_.find(quote);
    if (end == std::string_view::npos) return std::nullopt;
    std::string text(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    return text;
  }

  bool parse_type(ArrayHeader& header) {
    if (take("[")) {  // a structured type: a list of (name, type) pairs up to the bracket that closes it
      int depth = 1;
      while (depth > 0 && !rest_.empty()) {
        depth += rest_.front() == '[' ? 1 : rest_.front() == ']' ? -1 : 0;
        rest_.remove_prefix(1);
      }
      return depth == 0;
    }
    const auto type = quoted();
    if (type) header.type = *type;
    return type.has_value();
  }

  bool parse_order(ArrayHeader& header) {
    header.fortran_order = take("True");
    return header.fortran_order || take("False");
  }

  bool parse_shape(ArrayHeader& header) {
    if (!take("(")) return false;
    while (!take(")")) {
      take("");  // skips blanks
      std::uint64_t extent = 0;
      const auto [end, code] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), extent);
      if (code != std::errc() || header.shape.size() == 32) return false;
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      take("L");  // written by Python 2
      header.shape.push_back(extent);
      take(",");
    }
    return true;
  }

  std::string_view rest_;
};

class NpyReader : public PointReader {
 public:
  NpyReader(FileInfo info, RecordStream records, AttributeType type, bool swapped, std::size_t row_bytes)
      : info_(std::move(info)),
        records_(std::move(records)),
        bytes_(size_of(type)),
        copy_(column_copy(type, swapped, AttributeType::f64)),
        row_bytes_(row_bytes) {}

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    BOOST_OUTCOME_TRY(block, records_.next(most));
    const std::size_t n = block.size() / records_.record_bytes();
    batch.points.assign(n, Point{});
    batch.rows.assign(n * row_bytes_, std::byte{0});
    if (n == 0) return success();
    auto* to = reinterpret_cast<std::byte*>(batch.points.data());
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(info_.dimension); ++axis)
      copy_(block.data() + axis * bytes_, records_.record_bytes(), to + axis * sizeof(double), sizeof(Point), n);
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    records_.seek(index);
    return true;
  }

  std::string place(std::size_t index) const override {
    return "row " + std::to_string(records_.first_of_last_block() + index);
  }

 private:
  FileInfo info_;
  RecordStream records_;
  std::size_t bytes_;
  ColumnCopy copy_;
  std::size_t row_bytes_;
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_npy(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  const auto bad = [&](const std::string& what) {
    return error(Errc::bad_input, source->path().string() + ": " + what);
  };
  std::array<std::byte, 12> head{};
  if (source->size() < head.size()) return bad("ends within the NumPy header");
  BOOST_OUTCOME_TRYV(source->read(0, head));
  if (std::memcmp(head.data(), "\x93NUMPY", 6) != 0)
    return bad("is not a NumPy array: it does not begin with \\x93NUMPY");
  const unsigned version = load<std::uint8_t>(head.data() + 6);
  if (version < 1 || version > 3) return bad("NumPy format version " + std::to_string(version) + " is not known");
  const std::uint64_t text_at = version == 1 ? 10 : 12;
  const std::uint32_t text_bytes =
      version == 1 ? load<std::uint16_t>(head.data() + 8) : load<std::uint32_t>(head.data() + 8);
  if (text_bytes > header_bytes_max || text_bytes > source->size() - text_at)
    return bad("the NumPy header claims " + std::to_string(text_bytes) + " bytes");
  std::string text(text_bytes, '\0');
  BOOST_OUTCOME_TRYV(source->read(text_at, std::as_writable_bytes(std::span(text))));

  const auto header = LiteralParser(text).parse();
  if (!header) return bad("the NumPy header cannot be understood");
  std::string type = header->type;
  if (type != "<f8" && type != ">f8" && type != "<f4" && type != ">f4")
    return bad("holds " + (type.empty() ? "a structured type" : "type '" + printable(type) + "'") +
               "; arrays of f4 or f8 are read");
  if (header->shape.size() != 2 || (header->shape[1] != 2 && header->shape[1] != 3)) {
    std::string shape;
    for (const auto extent : header->shape) shape += (shape.empty() ? "" : ", ") + std::to_string(extent);
    return bad("has shape (" + shape + "); n x 2 or n x 3 is read");
  }
  if (header->fortran_order) return bad("is in Fortran order; save numpy.ascontiguousarray(a) instead");

  const auto real = type[2] == '4' ? AttributeType::f32 : AttributeType::f64;
  FileInfo info = info_of(*source, "npy");
  info.detail = "NumPy " + type + ", n x " + std::to_string(header->shape[1]);
  info.dimension = static_cast<int>(header->shape[1]);
  info.points = header->shape[0];
  RecordStream records(std::move(source), text_at + text_bytes, size_of(real) * header->shape[1], header->shape[0]);
  BOOST_OUTCOME_TRYV(records.check_size());
  return std::unique_ptr<PointReader>(
      new NpyReader(std::move(info), std::move(records), real, type[0] == '>', row_bytes(attributes)));
}

}  // namespace tessera
