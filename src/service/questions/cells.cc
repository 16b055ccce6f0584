// The question cells: the cells that meet a box or polygons, in a file.
#include <string>

#include "src/base/files/names.h"
#include "src/result/export/export.h"
#include "src/service/beneath.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {

Result<QuestionAnswer> answer_cells(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRY(area, asked.area());
  BOOST_OUTCOME_TRY(most, asked.limits_of_cells());
  // The name of the file does not matter, but a name without an ending would mean a folder.
  const std::string format = asked.word("f", asked.dimension == 2 ? "geojson" : "ply");
  if (format == "npy")
    return error(Errc::usage,
                 "f: the format npy is a folder of arrays, and an answer is a single file: ask for another format, or "
                 "run the process export");
  const ExportOptions options{.format = format, .cells_only = true};
  const auto target = answer_file(asked.folder, "." + format);
  BOOST_OUTCOME_TRYV(find_export_target(target, options));
  BOOST_OUTCOME_TRY(set, asked.reader.stored.cells(area, most, asked.ask));
  if (set.tiles.empty()) return error(Errc::bad_input, "no cell meets the box or polygon");
  BOOST_OUTCOME_TRY(exported, export_cells(path_of(asked.reader.held.folder), asked.reader.stored.manifest(), set.mesh,
                                           set.tiles, target, options, asked.ask.stop));
  return asked.file(exported.path, set.final);
}

}  // namespace tessera::service
