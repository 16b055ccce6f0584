// The names that a user gives to the columns of text and NumPy files, whatever the files' headers say: "p,y,x,z".
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// The name of a column that is left out. Columns behind the last named column are left out, too.
inline constexpr const char* unnamed_column = "_";

// Checks names of columns. Error usage, with the end of a sentence, for names that make no points: x or y is missing, a
// name is there twice or empty, or there are too many names. An empty list is valid.
Status check_columns(std::span<const std::string> names);

// What the names of columns mean.
struct ColumnNames {
  // the numbers of the columns x, y and perhaps z, from 0; their names may have either case
  std::vector<std::size_t> coordinates;
  std::vector<std::size_t> others;  // the numbers of the other named columns, ascending
  std::size_t end = 0;              // the number behind the last column of both lists
};
// Returns what the names mean. REQUIRES: check_columns() accepts the names, and there are some.
ColumnNames find_columns(std::span<const std::string> names);

// Returns "has 3 columns, but option columns names 4". Empty when `there` columns are enough.
std::string too_few_columns(std::size_t there, const ColumnNames& names);

}  // namespace tessera
