// PTX (Leica Cyclone): scans of a terrestrial scanner as text, each with the position and the directions of the
// scanner. Source: Leica Geosystems, "PTX file format" (HDS documents); Library of Congress, fdd000656 describes its
// use.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Opens a PTX file. The points of each scan are moved by its matrix into the coordinate system that all scans share.
// Pulses without an echo, 0 0 0, are no points. Attributes: intensity from 0 to 1; red, green and blue if the first
// scan has them; scan, the number of the scan from 0.
Result<std::unique_ptr<PointReader>> open_ptx(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera
