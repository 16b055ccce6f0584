// tessera query: answers questions to a result folder.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/query_run.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/version_option.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

struct Asked {
  std::string folder, question, argument;
};

// A question of the command.
struct QuestionRow {
  const char* name;
  Status (*ask)(QueryRequest& request);
  std::vector<std::string> options;  // those that only some questions have
};

const std::vector<QuestionRow>& rows() {
  static const std::vector<QuestionRow> table{{"locate", query_locate, {"points"}},
                                              {"star", query_star, {"tile"}},
                                              {"neighbours", query_neighbours, {"tile"}},
                                              {"cells", query_cells, {"bbox", "polygon"}},
                                              {"interpolate", query_interpolate, {"value", "method", "weights"}}};
  return table;
}

// "locate, star and cells"
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

Result<const QuestionRow*> find_question(const std::string& name) {
  std::vector<std::string> names;
  for (const QuestionRow& row : rows()) {
    if (row.name == name) return &row;
    names.emplace_back(row.name);
  }
  return error(Errc::usage, "'" + name + "' is not a question; the questions are " + listed(names));
}

bool uses(const QuestionRow& row, const std::string& key) {
  return std::find(row.options.begin(), row.options.end(), key) != row.options.end();
}

// Error usage for an option that the question does not use. Otherwise the option would be ignored silently.
Status refuse_others(const Settings& settings, const QuestionRow& question) {
  for (const QuestionRow& row : rows()) {
    for (const std::string& key : row.options) {
      if (uses(question, key) || settings.source(key) != Settings::Source::flag) continue;
      std::vector<std::string> users;
      for (const QuestionRow& other : rows())
        if (uses(other, key)) users.push_back("'" + std::string(other.name) + "'");
      return error(Errc::usage, "--" + key + " belongs to " + listed(users) + ", not to '" + question.name + "'");
    }
  }
  return success();
}

Result<query::Method> parse_query_method(const std::string& text) {
  if (text == "linear") return query::Method::linear;
  if (text == "natural") return query::Method::natural;
  return error(Errc::usage, "'" + text + "' is not a method of interpolation; the methods are linear and natural");
}

Status run_query(Settings& settings, const Asked& asked) {
  if (asked.folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera query --help'");
  const std::string& question = asked.question;
  BOOST_OUTCOME_TRY(row, find_question(question));
  BOOST_OUTCOME_TRYV(refuse_others(settings, *row));
  if (question == "cells" && !asked.argument.empty())
    return error(Errc::usage, "'" + asked.argument + "' is one argument too many: 'cells' takes --bbox or --polygon");

  BOOST_OUTCOME_TRY(folder, at_version(settings, asked.folder));
  QueryRequest request{.folder = folder,
                       .argument = asked.argument,
                       .points = settings.text("points").value_or(""),
                       .columns = {},
                       .bbox = settings.text("bbox").value_or(""),
                       .polygon = settings.text("polygon").value_or(""),
                       .tile = {},
                       .target = settings.text("output").value_or("")};
  BOOST_OUTCOME_TRY(output, output_options(settings));
  request.output = output;
  if (output.verbose) log_everything();
  BOOST_OUTCOME_TRY(columns, settings.get("columns", parse_columns));
  if (columns && question != "interpolate" && (question != "locate" || request.points.empty()))
    return error(Errc::usage,
                 "--columns describes a file with points, as in 'locate --points FILE' or 'interpolate FILE'");
  request.columns = columns.value_or(std::vector<std::string>{});
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(tile,
                    settings.get("tile", [](const std::string& text) { return parse_integer(text, 0, 999'999); }));
  if (tile) request.tile = TileId{static_cast<std::uint32_t>(*tile)};
  BOOST_OUTCOME_TRY(method, settings.get("method", parse_query_method));
  BOOST_OUTCOME_TRY(weights, settings.on("weights"));
  request.value = {.value = settings.text("value").value_or(""),
                   .method = method.value_or(query::Method::linear),
                   .weights = weights};
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  request.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  request.ask.threads = threads;
  const std::string format = settings.text("format").value_or("");
  const bool many = question == "interpolate" || (question == "locate" && !request.points.empty());
  if (many) {
    BOOST_OUTCOME_TRY(answers, answer_format(format, request.target, output.json));
    request.answers = {.format = answers, .target = request.target, .overwrite = overwrite};
  } else if (question != "cells") {
    if (!request.target.empty())
      return error(Errc::usage, "a single answer goes to standard output; -o is for many answers");
    if (format == "json") request.output.json = true;
    if (format != "json" && settings.source("format") == Settings::Source::flag)
      return error(Errc::usage, "--format " + format + ": a single answer is text, or JSON with --format json");
  }
  request.cells = {.format = format, .cells_only = true, .overwrite = overwrite};

  const Interrupt interrupt;
  request.ask.stop = interrupt.token();
  return row->ask(request);
}

}  // namespace

Command add_query(CLI::App& root) {
  auto command = new_command(
      root, "query",
      "Asks a result folder: the cell of a point, the star of a vertex, the cells of an area, interpolated values",
      "  tessera query out/ locate 885100,629050,12                 (the cell, its vertices and neighbours)\n"
      "  tessera query out/ locate --points where.csv -o cells.npy  (for many points, in any input format)\n"
      "  tessera query out/ star 123456                             (cells and neighbours of a vertex, its Voronoi "
      "volume)\n"
      "  tessera query out/ neighbours 123456                       (only the ids of its neighbours)\n"
      "  tessera query out/ cells --bbox 0,0,50,50 -o part.vtu      (the cells that meet a box)\n"
      "  tessera query out/ cells --polygon area.geojson -o part.ply\n"
      "  tessera query ground/ interpolate points.csv --value z -o heights.csv");
  add_value(command, "points", "FILE", "locate: a file with many points, in any input format", 0, true);
  add_value(command, "columns", "NAMES",
            "locate, interpolate: the names of the columns of the file with points, in order: x, y, z, or _ for a "
            "column to leave out; for example _,y,x",
            0, true);
  add_value(command, "tile", "N", "star, neighbours: the tile that owns the vertex; without it, the tiles are searched",
            0, true);
  add_value(command, "bbox", "BOX",
            "cells: the box xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax; its border belongs to it", 0, true);
  add_value(command, "polygon", "FILE", "cells: the polygons of a GeoJSON file, in the coordinates of the result", 0,
            true);
  add_value(command, "value", "NAME",
            "interpolate: the attribute of the vertices to interpolate; z: the heights of a 2D result", 0, true);
  add_value(command, "method", "NAME",
            "interpolate: linear (default) in the cell, or natural: by Sibson's natural neighbours");
  add_choices(command, "method", "linear, natural");
  add_switch(command, "weights", "interpolate: also tell which vertices make a value, and with which weights");
  add_value(command, "output", "PATH", "the file to write; without it, answers go to standard output", 'o', true);
  add_value(command, "format", "NAME",
            "for many answers: csv, json (one a line) or npy; for a single answer: json; for cells: a format of "
            "'tessera export'; default: the format of the ending of --output");
  add_version_option(command);
  add_store_options(command);
  add_memory_option(command, "tiles");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_output_switches(command);
  auto asked = std::make_shared<Asked>();
  add_argument(command, "result", "FOLDER", asked->folder,
               "result folder, also s3://bucket/folder or https://host/folder");
  add_argument(command, "question", "QUESTION", asked->question, "locate, star, neighbours, cells or interpolate");
  add_choices(command, "question", "locate, star, neighbours, cells, interpolate");
  add_argument(
      command, "about", "ABOUT", asked->argument,
      "locate: a point as X,Y[,Z]; star, neighbours: the source index of a vertex; interpolate: a file with points");
  command.run = [settings = command.settings.get(), asked](const std::vector<std::string>&) {
    return run_query(*settings, *asked);
  };
  return command;
}

}  // namespace tessera::apps
