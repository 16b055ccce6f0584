// Points as text: XYZ, CSV, TSV, TXT. One point a line; columns parted by commas, semicolons, tabs or blanks.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Lines that are blank or begin with '#' or "//" are skipped. If the first other line is not numbers, it is a header:
// x, y and z are then found by name (x y z, or lon lat, easting northing, ...; any case) or, if it names none of them,
// are the first three columns, as they are without a header; the hints' columns go before both. With two numeric
// columns the dimension is 2. The other numeric columns are attributes (f64), named by the header or "column_4"; an
// empty cell is NaN. A part, of 1 MiB, has the lines that begin in it.
Result<std::unique_ptr<PointReader>> open_text(std::unique_ptr<ByteSource> source,
                                               const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera
