// What a user says of columns: the names of those of text and NumPy files, in order, whatever the files' headers say,
// "p,y,x,z"; or which columns of a FITS table are coordinates, "x=XPOS,y=YPOS,z=ZPOS".
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// The name of a column that is left out. Columns behind the last named column are left out, too.
inline constexpr const char* unnamed_column = "_";

// Checks names of columns. Error usage, with the end of a sentence, for names that make no points: x or y is missing, a
// name is there twice or empty, or there are too many names. An empty list is valid. If a name has a '=', all are
// entries KEY=COLUMN, with the keys x, y and perhaps z; or position, a column of three numbers; or ra, dec, and
// distance or redshift.
Status check_columns(std::span<const std::string> names);

// Whether these are entries KEY=COLUMN.
bool are_entries(std::span<const std::string> names);
// Returns key and column of each entry: of x, y, z, or position, or ra, dec and the distance or redshift, in this
// order. REQUIRES: are_entries(), and check_columns() accepts the entries.
std::vector<std::pair<std::string, std::string>> named_columns(std::span<const std::string> entries);

// What the names of columns mean.
struct ColumnNames {
  // the numbers of the columns x, y and perhaps z, from 0; their names may have either case
  std::vector<std::size_t> coordinates;
  std::vector<std::size_t> others;  // the numbers of the other named columns, ascending
  std::size_t end = 0;              // the number behind the last column of both lists
};
// Returns what the names mean. REQUIRES: check_columns() accepts the names, there are some, and they are no entries.
ColumnNames find_columns(std::span<const std::string> names);

// Returns "has 3 columns, but option columns names 4". Empty when `there` columns are enough.
std::string too_few_columns(std::size_t there, const ColumnNames& names);

}  // namespace tessera
