// What a user calls the columns of text and NumPy files, whatever their headers say: "p,y,x,z".
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// A column of this name is left out, as are those behind the last that is named.
inline constexpr const char* unnamed_column = "_";

// Error usage, with the end of a sentence, for names that make no points: x or y is missing, one is there twice or
// empty, there are too many. Nothing is wrong with no names at all.
Status check_columns(std::span<const std::string> names);

struct ColumnNames {
  std::vector<std::size_t> coordinates;  // the columns x, y and perhaps z, in any case of letters
  std::vector<std::size_t> others;       // that have a name, ascending
  std::size_t end = 0;                   // behind the last of both
};
// REQUIRES: check_columns() finds nothing wrong with the names, and there are some.
ColumnNames find_columns(std::span<const std::string> names);

// "has 3 columns, and option columns names 4"; empty when so many columns are enough.
std::string too_few_columns(std::size_t there, const ColumnNames& names);

}  // namespace tessera
