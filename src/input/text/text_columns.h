// The columns of a text file: how a line is split into fields, and what each field is.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/attribute.h"
#include "src/input/reader.h"

namespace tessera {

enum class Delimiter : char { comma = ',', semicolon = ';', tab = '\t', blanks = ' ' };

// Returns the delimiter of a line: a semicolon if there is one, else a comma. Else a tab, if no field has blanks inside
// (otherwise a tab counts as a blank). Else runs of blanks.
Delimiter delimiter_of(std::string_view line);

// Replaces `fields` by the first fields of the line, at most `most`, without blanks and quotes around them. A quoted
// field may contain the delimiter.
void split_line(std::string_view line, Delimiter delimiter, std::size_t most, std::vector<std::string_view>& fields);

// What the columns of a file are.
struct TextColumns {
  Delimiter delimiter = Delimiter::blanks;
  bool has_header = false;
  std::vector<std::size_t> coordinates;  // the 2 or 3 columns of x, y and perhaps z
  CoordinateColumns::By found_by = CoordinateColumns::By::place;
  bool degrees = false;  // the header calls x and y longitude and latitude
  struct Extra {
    Attribute attribute;
    std::size_t column;
  };
  std::vector<Extra> extras;  // numeric columns that are not coordinates
};

// Decides what the columns are, by the first line of a file. If that is a header, `numbers` is the first line of
// numbers; otherwise `header` is empty. `names` are names for the columns, whatever the header says, or empty. Returns
// what is wrong, or "".
std::string settle_columns(std::string_view header, std::string_view numbers, std::span<const std::string> names,
                           TextColumns& columns);

// Whether a line names columns: the field of x or of y, by `names` or else the first two fields, is a word and not a
// number.
bool is_header(std::string_view line, std::span<const std::string> names);

// Whether the first fields of these lines look like numbers of points. They go up by one from line to line, and the
// second fields are not all equal, as they would be in a row of a raster.
bool counts_up(std::span<const std::string> lines, Delimiter delimiter);

}  // namespace tessera
