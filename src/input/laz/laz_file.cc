#include "src/input/laz/laz_file.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "src/input/laz/chunk_table.h"
#include "src/input/laz/copc.h"
#include "src/input/laz/laz_stream.h"

namespace tessera::laz {

WantedFields wanted_fields(const LasHeader& header, const std::vector<Attribute>& attributes) {
  WantedFields plan{.record_bytes = header.record_bytes, .wanted = std::vector<bool>(header.record_bytes)};
  for (const auto& attribute : attributes)
    for (const auto& field : header.fields) {
      if (field.attribute.name != attribute.name) continue;
      for (std::size_t i = 0; i < size_of(field.stored); ++i) plan.wanted[field.offset + i] = true;
    }
  return plan;
}

Result<LazRecords> open_laz_records(std::unique_ptr<ByteSource> source, const LasHeader& header, WantedFields plan,
                                    const ReadHints& hints) {
  const std::string path = source->path().string();
  if (header.laszip.empty())
    return error(Errc::bad_input, path + ": is LAZ, but has no LASzip record that says how it is compressed");
  BOOST_OUTCOME_TRY(layout, read_laz_layout(path, header.laszip, header.point_format, header.record_bytes));
  if (layout.compressor == Compressor::none) {
    auto stream = std::make_unique<RecordStream>(std::move(source), header.points_at, plan.record_bytes, header.points);
    BOOST_OUTCOME_TRYV(stream->check_size());
    return LazRecords{.records = std::move(stream), .points = header.points};
  }
  BOOST_OUTCOME_TRY(chunks, read_chunk_table(*source, layout, header.points_at, header.points, plan.record_bytes));
  if (!header.copc.empty() && (hints.crop || hints.resolution > 0)) {
    BOOST_OUTCOME_TRY(nodes, read_copc_nodes(*source, header, hints));
    BOOST_OUTCOME_TRY(chosen, chunks_of_nodes(path, chunks, nodes));
    chunks = std::move(chosen);
  }
  std::erase_if(chunks, [](const Chunk& chunk) { return chunk.points == 0; });
  std::uint64_t points = 0;
  for (const auto& chunk : chunks) points += chunk.points;
  const std::uint64_t seek_points = chunks.empty() ? 0 : points / chunks.size() / 2;
  auto stream = std::make_unique<LazStream>(std::move(source), std::move(layout), std::move(plan), std::move(chunks),
                                            std::max(1u, hints.threads));
  return LazRecords{std::move(stream), points, seek_points};
}

}  // namespace tessera::laz
