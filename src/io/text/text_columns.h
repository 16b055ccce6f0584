// The columns of a text file: how a line is cut into fields, and which fields are what.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/attribute.h"

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
  bool degrees = false;                  // the header calls x and y longitude and latitude
  struct Extra {
    Attribute attribute;
    std::size_t column;
  };
  std::vector<Extra> extras;  // numeric columns that are no coordinates
};

// Settles the columns from a file's first line and, if that is a header, its first line of numbers (else `header` is
// empty). Returns what is wrong, or "" if nothing is.
std::string settle_columns(std::string_view header, std::string_view numbers, TextColumns& columns);

// True if one of the first two fields is a word and no number: the line names columns.
bool is_header(std::string_view line);

}  // namespace tessera
