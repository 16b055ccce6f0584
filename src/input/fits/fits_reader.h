// Tables of points in FITS, as surveys and simulations share them.
//
// Tessera reads FITS by itself, not by CFITSIO: names of files are programs to that library. A name may filter rows by
// expressions, open other files, run templates, and fetch addresses, and its checks of strangers' headers are not
// those that the rest of the input has. What is read here is one table of numbers, whose rows lie one after the other.
#pragma once

#include <memory>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera::fits {

// Reads the first binary table, or the one that hints.hdu names. Coordinates are x, y and perhaps z, or places on the
// sky with a distance, or with a redshift and hints.cosmology, which become Cartesian (sky.h, cosmology.h). All columns
// of numbers are attributes, except x, y and z; those of several numbers become name_1, name_2, ... Errors: those of
// Hdus, table_of() and places_of(); usage for an HDU that is not there, and for redshifts without a cosmology.
Result<std::unique_ptr<PointReader>> open_fits(std::unique_ptr<ByteSource> source,
                                               const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera::fits
