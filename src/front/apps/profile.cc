// tessera profile: writes the heights of a 2D result along a line.
#include "src/result/terrain/profile.h"
#include "src/base/json/json_text.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/say.h"
#include "src/front/apps/terrain_commands.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"
#include "src/result/query/geojson.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera::apps {
namespace {

// Reads "x,y x,y ...", or a GeoJSON file with one line.
Result<query::GeoJsonShapes> read_line(const std::string& text) {
  if (text.ends_with(".geojson") || text.ends_with(".json")) {
    BOOST_OUTCOME_TRY(lines, query::read_geojson(text, query::GeoJson::lines));
    if (lines.lists.size() > 1)
      return error(Errc::bad_input, text + ": has " + std::to_string(lines.lists.size()) + " lines, not one");
    return std::move(lines);
  }
  auto line = parse_line(text);
  if (!line) return error(Errc::usage, "--line: " + line.error().where);
  return query::GeoJsonShapes{.lists = {std::move(line).value()}, .place = {}};
}

Status write(const std::string& csv, const std::string& target, bool overwrite) {
  if (target.empty()) {
    if (std::fwrite(csv.data(), 1, csv.size(), stdout) == csv.size() && std::fflush(stdout) == 0) return success();
    return error(Errc::io, "standard output: cannot be written");
  }
  BOOST_OUTCOME_TRY(there, is_there(target));
  if (there && !overwrite) return error(Errc::usage, target + ": exists already; --overwrite replaces it");
  return write_whole(target, csv);
}

// Prints a summary. Without a target file the table is on stdout, so nothing else is printed there.
void tell(std::span<const ProfilePoint> points, std::span<const Point> line, const std::string& target,
          const OutputOptions& output) {
  const ProfileGaps gaps = gaps_of(points, line);
  if (output.json && !target.empty()) {
    const nlohmann::ordered_json object{
        {"event", "profile"},    {"output", target},    {"points", points.size()}, {"parts", points.back().part + 1},
        {"before", gaps.before}, {"after", gaps.after}, {"gaps", gaps.count},      {"between", gaps.between}};
    std::printf("%s\n", json_text(object).c_str());
    return;
  }
  if (output.quiet || output.json) return;
  if (!target.empty())
    say("%s: %s points, %s\n", target.c_str(), grouped(points.size()).c_str(),
        gaps.count == 0 ? "in one part" : ("in " + grouped(gaps.count + 1) + " parts").c_str());
  if (const std::string note = gaps_note(gaps); !note.empty()) say_beside("note: %s\n", note.c_str());
}

Status run_profile(Settings& settings, const OneStep& made_of) {
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera profile --help'");
  const auto text = settings.text("line");
  if (!text) return error(Errc::usage, "no line is given; add --line '0,0 50,20' or --line FILE.geojson");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  BOOST_OUTCOME_TRY(given, read_line(*text));
  ProfileOptions options;
  BOOST_OUTCOME_TRY(max_edge, settings.get("max-edge", [](const std::string& given) { return parse_distance(given); }));
  options.max_edge = max_edge;
  BOOST_OUTCOME_TRY(radius, settings.get("max-radius", [](const std::string& given) { return parse_distance(given); }));
  options.max_radius = radius;
  options.value = settings.text("value").value_or("z");
  BOOST_OUTCOME_TRY(digits, settings.get("digits", parse_digits));
  options.digits = digits.value_or(options.digits);
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  // One half of the memory is for tiles, the other half for the points that are found in them.
  options.memory_bytes = memory / 2;

  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    const Interrupt interrupt;
    options.stop = interrupt.token();
    BOOST_OUTCOME_TRY(result, query::StoredTriangulation::open(folder, {.memory_bytes = options.memory_bytes}));
    if (!given.place.name.empty()) {
      BOOST_OUTCOME_TRYV(given.place.check_in(result.manifest().crs, result.manifest().bounds));
    }
    BOOST_OUTCOME_TRY(points, profile(result, folder, given.lists[0], options));
    const std::string target = settings.text("output").value_or("");
    BOOST_OUTCOME_TRYV(write(to_csv(points, options), target, overwrite));
    tell(points, given.lists[0], target, output);
    return success();
  });
}

}  // namespace

Command add_profile(CLI::App& root) {
  auto command = new_command(
      root, "profile", "Writes the heights of a 2D result along a line",
      "  tessera profile ground/ --line '885000,629000 885100,629080 885120,629080' -o profile.csv\n"
      "  tessera profile ground/ --line road.geojson --max-edge 5      (to standard output, without cells that bridge "
      "gaps)\n\n"
      "There is a row for each place where the line bends or crosses an edge: distance,x,y,z,part. Straight lines\n"
      "join the places of one part. There is no surface between two parts: these gaps, and ends of the line outside\n"
      "the surface, are told on standard error.");
  add_value(command, "line", "LINE",
            "x,y x,y ... in quotes, or a GeoJSON file with one line, in the result's coordinates", 0, true);
  add_value(command, "max-edge", "LENGTH", "leave out cells with a longer edge in the plane; default: no limit");
  add_value(command, "max-radius", "LENGTH",
            "leave out cells with a larger circumradius in the plane; default: no limit");
  add_value(command, "value", "NAME", "the attribute of the vertices to draw; default: z, the heights", 0, true);
  add_value(command, "digits", "N",
            "decimals of all numbers: 0 to 17, or all, so that the same doubles are read back; default: the precision "
            "of the data");
  add_value(command, "output", "PATH", "the file to write, as CSV; without it, standard output", 'o', true);
  add_threads_option(command);
  add_memory_option(command, "tiles");
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_output_switches(command);
  auto sources = add_sources(command, 2);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_profile(*settings, {.sources = *sources,
                                   .dimension = 2,
                                   .beside = settings->text("output").value_or(""),
                                   .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
