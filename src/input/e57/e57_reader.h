// E57 (ASTM E2807): the scans of terrestrial scanners, each with its pose.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Opens an E57 file. The points of all scans, in the order of the file, are one cloud: each scan is moved by its pose.
// Points whose coordinates the file calls invalid are left out. Spherical coordinates are converted. Attributes: all
// other numbers of a record, colours as red, green and blue; and scan, the number of the scan from 0. Checksums of all
// pages that are read are checked. Images are ignored.
Result<std::unique_ptr<PointReader>> open_e57(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera
