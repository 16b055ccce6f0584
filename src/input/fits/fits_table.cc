#include "src/input/fits/fits_table.h"

#include <charconv>
#include <utility>

#include "src/base/printable.h"

namespace tessera::fits {
namespace {

constexpr std::size_t numbers_max = 64;                           // of a column in a row, as attributes
constexpr std::uint64_t row_bytes_max = std::uint64_t{16} << 20;  // a row is read at once

// "3D" is three doubles. What stands behind the letter is for programs that show the table.
struct Form {
  std::uint64_t repeat = 1;
  char letter = ' ';
};

std::optional<Form> form_of(const std::string& text) {
  Form form;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), form.repeat);
  if (problem == std::errc::result_out_of_range || end == text.data() + text.size()) return std::nullopt;
  form.letter = *end;
  return form;
}

// The bytes of a letter of TFORM; 0 for bits and letters that FITS does not know.
std::uint64_t bytes_of(char letter) {
  switch (letter) {
    case 'L':
    case 'B':
    case 'A':
      return 1;
    case 'I':
      return 2;
    case 'J':
    case 'E':
      return 4;
    case 'K':
    case 'D':
    case 'C':
    case 'P':
      return 8;
    case 'M':
    case 'Q':
      return 16;
    default:
      return 0;
  }
}

// The type of a column of numbers; nothing for other columns.
std::optional<AttributeType> stored_type(char letter) {
  using enum AttributeType;
  switch (letter) {
    case 'L':
    case 'B':
      return u8;
    case 'I':
      return i16;
    case 'J':
      return i32;
    case 'K':
      return i64;
    case 'E':
      return f32;
    case 'D':
      return f64;
    default:
      return std::nullopt;
  }
}

const char* what_is(char letter) {
  switch (letter) {
    case 'A':
      return "text";
    case 'X':
      return "bits";
    case 'C':
    case 'M':
      return "complex numbers";
    case 'P':
    case 'Q':
      return "arrays of variable length";
    default:
      return "more than 64 numbers a row";
  }
}

// The TZERO of integers that FITS has no type for: unsigned ones of more than 8 bits, and signed ones of 8 bits.
std::optional<double> zero_of_other_sign(char letter) {
  switch (letter) {
    case 'B':
      return -128;
    case 'I':
      return 32'768;
    case 'J':
      return 2'147'483'648;
    case 'K':
      return 9'223'372'036'854'775'808.0;
    default:
      return std::nullopt;
  }
}

// Reads the cards of the columns.
class ColumnCards {
 public:
  ColumnCards(const Hdu& hdu, const std::string& path) : hdu_(hdu), path_(path) {}

  Error bad(const std::string& what) const {
    return error(Errc::bad_input,
                 path_ + ", byte " + std::to_string(hdu_.header_at) + ": " + hdu_.title() + " " + what);
  }

  Status add(std::int64_t number, Table& table) {
    const std::string n = std::to_string(number);
    const auto text = hdu_.cards.text("TFORM" + n);
    const auto form = text ? form_of(*text) : std::nullopt;
    const bool known = form && (form->letter == 'X' || bytes_of(form->letter) > 0);
    if (!known) return bad("has a column " + n + " whose TFORM is not known");
    std::uint64_t bytes = 0;
    if (form->letter == 'X') {
      bytes = form->repeat / 8 + (form->repeat % 8 > 0 ? 1 : 0);
    } else if (__builtin_mul_overflow(form->repeat, bytes_of(form->letter), &bytes)) {
      bytes = UINT64_MAX;
    }
    if (bytes > table.row_bytes - offset_) return bad("has columns that take more bytes than a row has, by its NAXIS1");
    NumberColumn column{.name = hdu_.cards.text("TTYPE" + n).value_or(""),
                        .unit = printable(hdu_.cards.text("TUNIT" + n).value_or("")),
                        .offset = offset_,
                        .count = static_cast<std::size_t>(form->repeat)};
    if (column.name.empty()) column.name = "column_" + n;
    offset_ += static_cast<std::size_t>(bytes);
    const auto type = stored_type(form->letter);
    if (bytes == 0) return success();
    if (!type || form->repeat > numbers_max) {
      table.left_out.push_back(printable(column.name) + " (" + what_is(form->letter) + ")");
      return success();
    }
    column.stored = *type;
    BOOST_OUTCOME_TRYV(add_meaning(n, form->letter, column));
    table.columns.push_back(std::move(column));
    return success();
  }

  std::size_t bytes() const { return offset_; }

 private:
  Status add_meaning(const std::string& n, char letter, NumberColumn& column) const {
    column.logical = letter == 'L';
    if (column.logical) return success();
    const auto number_of = [&](const std::string& key, double otherwise) {
      return hdu_.cards.has(key) ? hdu_.cards.real(key) : std::optional(otherwise);
    };
    const auto scale = number_of("TSCAL" + n, 1), zero = number_of("TZERO" + n, 0);
    if (!scale || !zero) return bad("has a column " + n + " whose TSCAL or TZERO is not a number");
    column.other_sign = *scale == 1 && zero_of_other_sign(letter) == *zero;
    if ((*scale != 1 || *zero != 0) && !column.other_sign) {
      column.scale = *scale;
      column.zero = *zero;
    }
    const std::string null = "TNULL" + n;
    if (letter == 'E' || letter == 'D' || !hdu_.cards.has(null)) return success();
    column.null = hdu_.cards.integer(null);
    if (!column.null) return bad("has a column " + n + " whose TNULL is not an integer");
    return success();
  }

  const Hdu& hdu_;
  const std::string& path_;
  std::size_t offset_ = 0;
};

}  // namespace

AttributeType NumberColumn::type() const {
  using enum AttributeType;
  if (scale || (null && stored != i64)) return f64;
  if (!other_sign) return stored;
  return stored == u8 ? i8 : stored == i16 ? u16 : stored == i32 ? u32 : u64;
}

Result<Table> table_of(const Hdu& hdu, const std::string& path) {
  ColumnCards cards(hdu, path);
  const auto number = [&](const char* key) { return hdu.cards.integer(key).value_or(-1); };
  if (hdu.cards.is_true("ZTABLE"))
    return cards.bad("is a compressed table, which is not read; unpack the file with funpack");
  if (number("BITPIX") != 8 || number("NAXIS") != 2 || number("GCOUNT") != 1)
    return cards.bad("is no table: its BITPIX is not 8, its NAXIS not 2, or its GCOUNT not 1");
  const std::int64_t columns = number("TFIELDS");
  constexpr std::int64_t columns_max = 999;
  if (columns < 0 || columns > columns_max) return cards.bad("has no TFIELDS from 0 to 999");
  Table table{.title = hdu.title(),
              .rows = static_cast<std::uint64_t>(number("NAXIS2")),
              .data_at = hdu.data_at,
              .row_bytes = static_cast<std::size_t>(number("NAXIS1"))};
  if (table.row_bytes > row_bytes_max)
    return cards.bad("has rows of " + std::to_string(table.row_bytes) + " bytes; at most " +
                     std::to_string(row_bytes_max) + " are read");
  if (table.rows == 0 || table.row_bytes == 0) return cards.bad("has no rows");
  for (std::int64_t i = 1; i <= columns; ++i) {
    BOOST_OUTCOME_TRYV(cards.add(i, table));
  }
  if (cards.bytes() != table.row_bytes)
    return cards.bad("has columns of " + std::to_string(cards.bytes()) + " bytes, but rows of " +
                     std::to_string(table.row_bytes) + ", by its NAXIS1");
  return table;
}

}  // namespace tessera::fits
