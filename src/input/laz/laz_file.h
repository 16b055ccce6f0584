// Opens the records of a LAZ or COPC file from its header.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/las/las_header.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/reader.h"

namespace tessera::laz {

// The fields of records that rows of these attributes need.
WantedFields wanted_fields(const LasHeader& header, const std::vector<Attribute>& attributes);

struct LazRecords {
  std::unique_ptr<RecordSource> records;
  std::uint64_t points = 0;       // how many `records` gives; fewer than in the file when hints leave out COPC nodes
  std::uint64_t seek_points = 0;  // see FileInfo
};

// Opens the records. Hints apply to COPC only; other files are read whole. Error bad_input for a missing or
// wrong LASzip record, chunk table or COPC hierarchy. REQUIRES: `header` is that of `source`, and compressed.
Result<LazRecords> open_laz_records(std::unique_ptr<ByteSource> source, const LasHeader& header, WantedFields plan,
                                    const ReadHints& hints);

}  // namespace tessera::laz
