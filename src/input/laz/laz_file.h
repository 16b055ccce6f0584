// From the header of a LAZ or COPC file to its records.
#pragma once

#include <cstdint>
#include <memory>

#include "src/base/result.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/las/las_header.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/reader.h"

namespace tessera::laz {

struct LazRecords {
  std::unique_ptr<RecordSource> records;
  std::uint64_t points = 0;  // that `records` gives: fewer than the file has if the hints let COPC nodes be left out
  std::uint64_t seek_points = 0;  // see FileInfo
};

// REQUIRES: header is that of `source`, and compressed. Errors bad_input: point formats with waveforms, no or a wrong
// LASzip record, chunk table or COPC hierarchy. A file that is not COPC is read whole.
Result<LazRecords> open_laz_records(std::unique_ptr<ByteSource> source, const LasHeader& header, RecordPlan plan,
                                    const ReadHints& hints);

}  // namespace tessera::laz
