#include "src/input/laz/copc_units.h"

#include <algorithm>
#include <string>
#include <utility>

#include "src/input/bytes/far_source.h"
#include "src/input/las/las_header.h"
#include "src/input/laz/chunk_table.h"
#include "src/input/laz/chunks_ahead.h"
#include "src/input/laz/copc.h"
#include "src/input/laz/laz_file.h"

namespace tessera::laz {

Result<std::vector<FilePart>> read_copc_units(const ByteSource& source, double resolution) {
  const std::string path = source.path().string();
  BOOST_OUTCOME_TRY(header, read_las_header(source));
  BOOST_OUTCOME_TRY(layout, read_laz_layout(path, header.laszip, header.point_format, header.record_bytes));
  if (!layout.chunked())
    return error(Errc::bad_input, path + ", LASzip record: the file is COPC, but the record describes no chunks");
  BOOST_OUTCOME_TRY(chunks, read_chunk_table(source, layout, header.points_at, header.points, header.record_bytes));
  BOOST_OUTCOME_TRY(nodes, read_copc_nodes(source, header, {.resolution = resolution}));
  std::sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
  BOOST_OUTCOME_TRY(chosen, chunks_of_nodes(path, chunks, nodes));
  const auto filled =
      static_cast<std::size_t>(std::count_if(chunks.begin(), chunks.end(), [](const auto& c) { return c.points > 0; }));
  if (resolution == 0 && chosen.size() != filled)
    return error(Errc::bad_input, path + ", COPC hierarchy: the hierarchy leaves out " +
                                      std::to_string(filled - chosen.size()) + " of the " + std::to_string(filled) +
                                      " chunks with points");
  std::vector<FilePart> units;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    units.push_back(
        {chosen[i].first, chosen[i].points, chosen[i].begin, chosen[i].end - chosen[i].begin, nodes[i].bounds});
  return units;
}

Status bring_copc_units(const ByteSource& source, const std::vector<Attribute>& attributes,
                        std::span<const FilePart> units) {
  if (near_bytes_max(source) == 0) return success();
  BOOST_OUTCOME_TRY(header, read_las_header(source));
  BOOST_OUTCOME_TRY(layout,
                    read_laz_layout(source.path().string(), header.laszip, header.point_format, header.record_bytes));
  const auto plan = wanted_fields(header, attributes);
  std::vector<Chunk> chunks;
  for (const auto& unit : units) chunks.push_back({unit.begin, unit.begin + unit.bytes, unit.first, unit.points});
  auto left = std::span<const Chunk>(chunks);
  while (!left.empty()) {  // the heads of a thousand chunks at once, then their layers
    const auto n = std::min<std::size_t>(left.size(), 1024);
    BOOST_OUTCOME_TRYV(bring_chunks(source, layout, plan, left.first(n)));
    left = left.subspan(n);
  }
  return success();
}

}  // namespace tessera::laz
