// The columns of a text file: how a line is cut into fields, and which fields are what.
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

// The delimiter that `line` uses: a semicolon if there is one, else a comma, else a tab if no field has blanks inside
// (then a tab is just another blank), else runs of blanks.
Delimiter delimiter_of(std::string_view line);

// Fields without the blanks and quotes around them. Quoted fields may hold the delimiter. Replaces `fields`, at most
// `most` of them; the rest of the line is not looked at.
void split_line(std::string_view line, Delimiter delimiter, std::size_t most, std::vector<std::string_view>& fields);

struct TextColumns {
  Delimiter delimiter = Delimiter::blanks;
  bool has_header = false;
  std::vector<std::size_t> coordinates;  // 2 or 3 columns: x, y and perhaps z
  CoordinateColumns::By found_by = CoordinateColumns::By::place;
  bool degrees = false;  // the header calls x and y longitude and latitude
  struct Extra {
    Attribute attribute;
    std::size_t column;
  };
  std::vector<Extra> extras;  // columns of numbers that are no coordinates
};

// Settles the columns from a file's first line and, if that is a header, its first line of numbers (else `header` is
// empty). `names`: of the columns, whatever the header says; may be empty. Returns what is wrong, or "" if nothing is.
std::string settle_columns(std::string_view header, std::string_view numbers, std::span<const std::string> names,
                           TextColumns& columns);

// True if the field of x or of y, by `names` or the first two, is a word and no number: the line names columns.
bool is_header(std::string_view line, std::span<const std::string> names);

// Whether the first fields of these lines are numbers of points: they go up by one from line to line, and the second
// ones are not the same all along, as they are in a row of a raster.
bool counts_up(std::span<const std::string> lines, Delimiter delimiter);

}  // namespace tessera
