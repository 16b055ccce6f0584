// Points as text: XYZ, CSV, TSV, TXT. Each line is a point. Commas, semicolons, tabs or blanks separate the columns.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Opens a text file. Blank lines, and lines that begin with '#' or "//", are skipped. If the first other line has words
// instead of numbers, it is a header. A header gives x, y and z by name (x y z, or lon lat, easting northing, ..., in
// any case). Without a header, or if it names none of them, x, y and z are the first three columns. The columns of
// `hints` take precedence over both. With two numeric columns the dimension is 2. Other numeric columns are attributes
// (f64), named by the header or "column_4". An empty field is NaN. A part is 1 MiB, and has the lines that begin in it.
Result<std::unique_ptr<PointReader>> open_text(std::unique_ptr<ByteSource> source,
                                               const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera
