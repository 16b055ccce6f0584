// The work of tessera query, after its options are read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/result/export/export.h"
#include "src/result/query/answers.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera::apps {

struct QueryRequest {
  std::filesystem::path folder;
  std::string argument;                  // the argument after the question
  std::string points;                    // --points
  std::vector<std::string> columns;      // the columns of that file, or of the file for interpolate
  std::string bbox, polygon;             // for cells
  std::optional<TileId> tile;            // for star, neighbours
  query::InterpolateOptions value = {};  // for interpolate
  AnswerOptions answers = {};
  ExportOptions cells = {};
  std::filesystem::path target;
  std::uint64_t memory_bytes = 0;
  query::AskOptions ask = {};
  OutputOptions output = {};
};

Status query_locate(QueryRequest& request);
Status query_star(QueryRequest& request);
Status query_neighbours(QueryRequest& request);
Status query_cells(QueryRequest& request);
Status query_interpolate(QueryRequest& request);

}  // namespace tessera::apps
