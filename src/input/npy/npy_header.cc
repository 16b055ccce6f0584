#include "src/input/npy/npy_header.h"

#include <array>
#include <charconv>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

constexpr std::uint32_t header_bytes_max = 65'536;
constexpr std::uint64_t npy_columns_max = 4096;
constexpr std::size_t row_bytes_max = std::size_t{1} << 20;

struct ArrayLiteral {
  std::string type;  // "<f8"; empty for a structured type
  // names and types; the type is empty if it is not a plain string
  std::vector<std::pair<std::string, std::string>> fields;
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
};

// Parses the header's Python literal, {'descr': '<f8', 'fortran_order': False, 'shape': (17, 3), }. Keys may come in
// any order.
class LiteralParser {
 public:
  explicit LiteralParser(std::string_view text) : rest_(text) {}

  std::optional<ArrayLiteral> parse() {
    ArrayLiteral literal;
    int seen = 0;
    if (!take("{")) return std::nullopt;
    while (!take("}")) {
      const auto key = quoted();
      if (!key || !take(":")) return std::nullopt;
      bool good = false;
      if (*key == "descr") good = parse_type(literal);
      if (*key == "fortran_order") good = parse_order(literal);
      if (*key == "shape") good = parse_shape(literal);
      if (!good) return std::nullopt;
      ++seen;
      take(",");
    }
    return seen == 3 ? std::optional(literal) : std::nullopt;
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

  bool parse_type(ArrayLiteral& literal) {
    if (!take("[")) {
      const auto type = quoted();
      if (type) literal.type = *type;
      return type.has_value();
    }
    while (!take("]")) {
      if (!parse_field(literal)) return false;
      take(",");
    }
    return true;
  }

  // Parses ('x', '<f8'), perhaps with the shape of an array in each row: ('colour', '|u1', (3,)).
  bool parse_field(ArrayLiteral& literal) {
    if (!take("(")) return false;
    auto name = quoted();
    if (!name || !take(",")) return false;
    std::string type;
    if (take("[")) {
      if (!skip_list()) return false;
    } else {
      auto plain = quoted();
      if (!plain) return false;
      type = std::move(*plain);
    }
    if (take(",")) {
      const std::size_t end = rest_.find(')');
      if (!take("(") || end == std::string_view::npos) return false;
      rest_.remove_prefix(rest_.find(')') + 1);
      type.clear();
    }
    literal.fields.emplace_back(std::move(*name), std::move(type));
    return take(")");
  }

  // Moves behind the bracket that closes the bracket that was taken.
  bool skip_list() {
    int depth = 1;
    while (depth > 0 && !rest_.empty()) {
      depth += rest_.front() == '[' ? 1 : rest_.front() == ']' ? -1 : 0;
      rest_.remove_prefix(1);
    }
    return depth == 0;
  }

  bool parse_order(ArrayLiteral& literal) {
    literal.fortran_order = take("True");
    return literal.fortran_order || take("False");
  }

  bool parse_shape(ArrayLiteral& literal) {
    if (!take("(")) return false;
    while (!take(")")) {
      take("");  // skips blanks
      std::uint64_t extent = 0;
      const auto [end, code] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), extent);
      if (code != std::errc() || literal.shape.size() == 32) return false;
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      take("L");  // written by Python 2
      literal.shape.push_back(extent);
      take(",");
    }
    return true;
  }

  std::string_view rest_;
};

std::optional<AttributeType> number_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, AttributeType>, 11> types{{{"b1", AttributeType::u8},
                                                                              {"u1", AttributeType::u8},
                                                                              {"i1", AttributeType::i8},
                                                                              {"u2", AttributeType::u16},
                                                                              {"i2", AttributeType::i16},
                                                                              {"u4", AttributeType::u32},
                                                                              {"i4", AttributeType::i32},
                                                                              {"u8", AttributeType::u64},
                                                                              {"i8", AttributeType::i64},
                                                                              {"f4", AttributeType::f32},
                                                                              {"f8", AttributeType::f64}}};
  for (const auto& [known, type] : types)
    if (known == name) return type;
  return std::nullopt;
}

// The number of bytes that "|V3" leaves unused. Nothing for other types.
std::optional<std::size_t> padding(std::string_view type) {
  if (!type.starts_with("|V")) return std::nullopt;
  std::uint32_t bytes = 0;
  const auto [end, code] = std::from_chars(type.data() + 2, type.data() + type.size(), bytes);
  return code == std::errc() && end == type.data() + type.size() ? std::optional<std::size_t>(bytes) : std::nullopt;
}

std::string shape_text(const ArrayLiteral& literal) {
  std::string text;
  for (const auto extent : literal.shape) text += (text.empty() ? "" : ", ") + std::to_string(extent);
  return "(" + text + ")";
}

// Sets the columns of an array with names. Returns what is wrong, or "".
std::string settle_fields(const ArrayLiteral& literal, NpyHeader& header) {
  if (literal.shape.size() != 1)
    return "has shape " + shape_text(literal) +
           "; an array with named columns must have one dimension, the number of points";
  if (literal.fields.size() > npy_columns_max) return "has more than " + std::to_string(npy_columns_max) + " columns";
  for (const auto& [name, type] : literal.fields) {
    const auto number = type.empty() ? std::nullopt : number_type(std::string_view(type).substr(1));
    const auto free = padding(type);
    if (!number && !(free && name.empty()))
      return "the column " + in_quotes(name) +
             (type.empty() ? " has several numbers in a row" : " has type '" + printable(type) + "'") +
             "; single integers, floats and doubles are read";
    if (number) header.columns.push_back({name, *number, type[0] == '>', header.row_bytes});
    header.row_bytes += number ? size_of(*number) : *free;
    if (header.row_bytes > row_bytes_max) return "has rows of more than " + std::to_string(row_bytes_max) + " bytes";
  }
  header.rows = literal.shape[0];
  header.named = true;
  header.detail = "NumPy, " + std::to_string(header.columns.size()) + " named columns";
  return "";
}

// Sets the columns of an array of one type. Returns what is wrong, or "".
std::string settle_plain(const ArrayLiteral& literal, NpyHeader& header) {
  const std::string& type = literal.type;
  if (type != "<f8" && type != ">f8" && type != "<f4" && type != ">f4")
    return "holds type '" + printable(type) + "'; arrays of f4 or f8, and of named columns, are read";
  if (literal.shape.size() != 2 || literal.shape[1] < 2 || literal.shape[1] > npy_columns_max)
    return "has shape " + shape_text(literal) + "; shapes from n x 2 to n x " + std::to_string(npy_columns_max) +
           " are read";
  if (literal.fortran_order) return "is in Fortran order; save numpy.ascontiguousarray(a) instead";
  const auto number = *number_type(std::string_view(type).substr(1));
  constexpr std::array<const char*, 3> axes{"x", "y", "z"};
  for (std::uint64_t i = 0; i < literal.shape[1]; ++i)
    header.columns.push_back({i < axes.size() ? axes[i] : "column_" + std::to_string(i + 1), number, type[0] == '>',
                              static_cast<std::size_t>(i) * size_of(number)});
  header.row_bytes = header.columns.size() * size_of(number);
  header.rows = literal.shape[0];
  header.detail = "NumPy " + type + ", n x " + std::to_string(literal.shape[1]);
  return "";
}

struct ReadLiteral {
  ArrayLiteral array;
  std::uint64_t body_at = 0;
};

Error bad_array(const ByteSource& source, const std::string& what) {
  return error(Errc::bad_input, source.path().string() + ": " + what);
}

Result<ReadLiteral> read_literal(const ByteSource& source) {
  std::array<std::byte, 12> head{};
  if (source.size() < head.size()) return bad_array(source, "ends within the NumPy header");
  BOOST_OUTCOME_TRYV(source.read(0, head));
  if (std::memcmp(head.data(), "\x93NUMPY", 6) != 0)
    return bad_array(source, "is not a NumPy array: it does not begin with \\x93NUMPY");
  const unsigned version = load<std::uint8_t>(head.data() + 6);
  if (version < 1 || version > 3)
    return bad_array(source, "NumPy format version " + std::to_string(version) + " is not known");
  const std::uint64_t text_at = version == 1 ? 10 : 12;
  const std::uint32_t text_bytes =
      version == 1 ? load<std::uint16_t>(head.data() + 8) : load<std::uint32_t>(head.data() + 8);
  if (text_bytes > header_bytes_max || text_bytes > source.size() - text_at)
    return bad_array(source, "the NumPy header claims " + std::to_string(text_bytes) + " bytes");
  std::string text(text_bytes, '\0');
  BOOST_OUTCOME_TRYV(source.read(text_at, std::as_writable_bytes(std::span(text))));
  auto literal = LiteralParser(text).parse();
  if (!literal) return bad_array(source, "the NumPy header cannot be understood");
  return ReadLiteral{std::move(*literal), text_at + text_bytes};
}

}  // namespace

Result<NpyHeader> read_npy_header(const ByteSource& source) {
  BOOST_OUTCOME_TRY(literal, read_literal(source));
  NpyHeader header;
  header.body_at = literal.body_at;
  const std::string wrong =
      literal.array.type.empty() ? settle_fields(literal.array, header) : settle_plain(literal.array, header);
  if (!wrong.empty()) return bad_array(source, wrong);
  return header;
}

Result<std::vector<std::uint64_t>> read_npy_integers(const ByteSource& source) {
  BOOST_OUTCOME_TRY(literal, read_literal(source));
  const ArrayLiteral& array = literal.array;
  if (array.type != "<u8" && array.type != "<i8" && array.type != "<u4" && array.type != "<i4")
    return bad_array(source, "holds type '" + printable(array.type) + "'; integers of 4 or 8 bytes are needed");
  if (array.shape.size() != 1)
    return bad_array(source, "has shape " + shape_text(array) + "; a list, of one dimension, is needed");
  const std::size_t width = array.type[2] == '8' ? 8 : 4;
  const std::uint64_t bytes = source.size() - literal.body_at;
  if (array.shape[0] != bytes / width || bytes % width != 0)
    return bad_array(source, "has " + std::to_string(bytes) + " bytes behind its header, which are not the " +
                                 std::to_string(array.shape[0]) + " integers that the header claims");
  std::vector<std::byte> body(bytes);
  BOOST_OUTCOME_TRYV(source.read(literal.body_at, body));
  std::vector<std::uint64_t> out;
  out.reserve(array.shape[0]);
  for (std::size_t at = 0; at < body.size(); at += width) {
    const std::byte* p = body.data() + at;
    const bool is_signed = array.type[1] == 'i';
    const std::int64_t value = width == 8  ? load<std::int64_t>(p)
                               : is_signed ? load<std::int32_t>(p)
                                           : std::int64_t{load<std::uint32_t>(p)};
    if (is_signed && value < 0)
      return bad_array(source, "the integer at place " + std::to_string(at / width) + " is " + std::to_string(value) +
                                   ", which is negative");
    out.push_back(static_cast<std::uint64_t>(value));
  }
  return out;
}

}  // namespace tessera
