// The columns of a binary table of a FITS file, and which of them are coordinates.
// Source: FITS Standard, version 4.0 (2018), section 7.3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/fits/fits_header.h"

namespace tessera::fits {

// A column of numbers: in each row, `count` big-endian numbers that follow each other. What a number means is
// zero + scale * stored, if the column is scaled, and nothing if `null` is stored.
struct NumberColumn {
  std::string name, unit;
  std::size_t offset = 0, count = 1;  // in bytes in the row; numbers a row
  AttributeType stored = AttributeType::f64;
  // Integers whose zero is half of their range, with the other sign than `stored`: FITS has no types for them.
  bool other_sign = false;
  bool logical = false;  // 'T' is true
  std::optional<double> scale = {};
  double zero = 0;
  std::optional<std::int64_t> null = {};
  // The type of the attribute: double where it is scaled, and where integers of up to 32 bits have a null, which
  // becomes NaN. A null of 64 bits becomes 0.
  AttributeType type() const;
};

struct Table {
  std::string title;  // "HDU 1 'GALAXIES'"
  std::uint64_t rows = 0, data_at = 0;
  std::size_t row_bytes = 0;
  std::vector<NumberColumn> columns = {};
  // The columns that are not numbers: texts, bits, complex numbers, arrays of variable or too great length, with what
  // they are: "NAME (text)".
  std::vector<std::string> left_out = {};
};

// The table of an HDU. Errors: bad_input, naming `path`, for a header that contradicts itself, and for compressed
// tables.
Result<Table> table_of(const Hdu& hdu, const std::string& path);

// A number of each row.
struct Element {
  std::size_t column = 0, element = 0;
};

// Which numbers are coordinates.
struct Places {
  enum class Of : std::uint8_t { xyz, distance, redshift };
  Of of = Of::xyz;
  std::vector<Element> elements;  // x, y and perhaps z; or right ascension, declination, and distance or redshift
};

// Finds the coordinates: by `named`, entries like "x=COLUMN" (see column_names.h), or by the names of the columns.
// `redshifts`: of a redshift and a distance the redshift counts. Errors name `path`: bad_input for a table without
// coordinates, usage for columns that are not there.
Result<Places> places_of(const Table& table, const std::vector<std::string>& named, bool redshifts,
                         const std::string& path);

}  // namespace tessera::fits
