#include "src/front/apps/outcome.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

using Json = nlohmann::ordered_json;

bool read(const Json& object, const char* key, std::uint64_t& value) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned()) return false;
  value = found->get<std::uint64_t>();
  return true;
}

bool read(const Json& object, const char* key, std::string& value) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string()) return false;
  value = found->get<std::string>();
  return true;
}

bool is_event(const Json& object, const char* event) {
  std::string told;
  return read(object, "event", told) && told == event;
}

std::string count(const Json& object, const char* key) {
  std::uint64_t value = 0;
  return read(object, key, value) ? grouped(value) : "?";
}

// The number with its noun.
std::string counted_of(const Json& object, const char* key, const char* one) {
  std::uint64_t value = 0;
  return read(object, key, value) ? counted(value, one) : std::string("? ") + one + "s";
}

bool is_one(const Json& object, const char* key) {
  std::uint64_t value = 0;
  return read(object, key, value) && value == 1;
}

}  // namespace

void print_verified(const std::string& result, const VerifyReport& report, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(report, result).c_str());
  } else if (!output.quiet) {
    for (const auto& line : report.passed) say("ok  %s\n", line.c_str());
    say("%s is the Delaunay triangulation of its %s vertices: %s cells, %s facets, %s of them on the hull\n",
        result.c_str(), grouped(report.vertices).c_str(), grouped(report.cells).c_str(), grouped(report.facets).c_str(),
        grouped(report.hull_facets).c_str());
  }
}

std::string limits_text(const Settings& settings) {
  std::string text;
  if (const auto edge = settings.text("max-edge")) text = "longer edges than " + *edge;
  if (const auto radius = settings.text("max-radius"))
    text += (text.empty() ? "" : " or ") + ("larger circumradii than " + *radius);
  return text;
}

void print_exported(const Exported& exported, const std::string& limits, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(exported, exported.path.string()).c_str());
  } else if (!output.quiet) {
    if (exported.cells == 0) {  // a table of points
      say("%s: %s points, %s\n", exported.path.c_str(), grouped(exported.vertices).c_str(),
          human_bytes(exported.bytes).c_str());
    } else {
      say("%s: %s vertices, %s cells, %s\n", exported.path.c_str(), grouped(exported.vertices).c_str(),
          grouped(exported.cells).c_str(), human_bytes(exported.bytes).c_str());
    }
    if (!limits.empty()) say("%s cells with %s are left out\n", grouped(exported.left_out).c_str(), limits.c_str());
    if (const auto& corner = exported.corner)
      say("coordinates count from %.0f %.0f %.0f\n", corner->x, corner->y, corner->z);
    if (!exported.note.empty()) say_beside("note: %s\n", exported.note.c_str());
  }
}

void print_heights(const std::string& folder, const std::vector<HeightsFile>& files, std::optional<bool> outside,
                   const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(files).c_str());
    return;
  }
  if (output.quiet) return;
  const HeightsCopy all = all_copies(files);
  say("%s: %s points of %s %s have the dimension %s\n", folder.c_str(), grouped(all.points).c_str(),
      grouped(files.size()).c_str(), files.size() == 1 ? "file" : "files", height_dimension);
  if (all.outside == 0) return;
  const char* height = !outside   ? ""
                       : *outside ? "; their height is that of --outside"
                                  : "; their height is NaN (--outside VALUE writes a number instead)";
  say("%s points are outside of the hull of the ground points%s\n", grouped(all.outside).c_str(), height);
}

void print_measured(const Measured& measured, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(measured).c_str());
    return;
  }
  if (output.quiet) return;
  const std::string unit = measured.unit.empty() ? "" : " " + measured.unit;
  const char* const folder = measured.folder.c_str();
  std::string columns;
  for (const auto& column : measured.columns)
    columns += (columns.empty() ? "" : ", ") + column.name + (column.of_cells ? " of cells" : " of vertices");
  if (measured.made) {
    say("%s: version %u has the columns %s\n", folder, measured.version, columns.c_str());
  } else {
    say("%s: has the columns %s already; nothing was changed\n", folder, columns.c_str());
  }
  if (measured.total) say("%s of all cells: %.17g%s\n", measured.total_of.c_str(), *measured.total, unit.c_str());
  if (!measured.note.empty()) say("%s\n", measured.note.c_str());
}

std::optional<VerifyReport> verified_of(const Json& outcome) {
  VerifyReport report;
  const auto passed = outcome.find("passed");
  if (!read(outcome, "cells", report.cells) || !read(outcome, "facets", report.facets) ||
      !read(outcome, "hull_facets", report.hull_facets) || !read(outcome, "vertices", report.vertices) ||
      passed == outcome.end() || !passed->is_array())
    return std::nullopt;
  for (const auto& line : *passed) {
    if (!line.is_string()) return std::nullopt;
    report.passed.push_back(line.get<std::string>());
  }
  return report;
}

std::optional<Exported> exported_of(const Json& outcome) {
  Exported exported;
  std::string output;
  if (!read(outcome, "output", output) || !read(outcome, "vertices", exported.vertices) ||
      !read(outcome, "cells", exported.cells) || !read(outcome, "left_out", exported.left_out) ||
      !read(outcome, "files", exported.files) || !read(outcome, "bytes", exported.bytes) ||
      !read(outcome, "note", exported.note))
    return std::nullopt;
  exported.path = output;
  if (const auto corner = outcome.find("corner"); corner != outcome.end()) {
    if (!corner->is_array() || corner->size() != 3) return std::nullopt;
    exported.corner.emplace();
    for (int axis = 0; axis < 3; ++axis) {
      const Json& number = (*corner)[static_cast<std::size_t>(axis)];
      if (!number.is_number()) return std::nullopt;
      (*exported.corner)[axis] = number.get<double>();
    }
  }
  return exported;
}

std::optional<std::vector<HeightsFile>> heights_of(const Json& outcome) {
  const auto list = outcome.find("files");
  if (!is_event(outcome, "heights") || list == outcome.end() || !list->is_array()) return std::nullopt;
  std::vector<HeightsFile> files;
  for (const auto& entry : *list) {
    HeightsFile file;
    std::string from, to;
    if (!entry.is_object() || !read(entry, "input", from) || !read(entry, "output", to) ||
        !read(entry, "points", file.copy.points) || !read(entry, "outside", file.copy.outside))
      return std::nullopt;
    file.from = from;
    file.to = to;
    files.push_back(std::move(file));
  }
  return files;
}

bool is_updated(const Json& outcome) { return is_event(outcome, "updated") || is_event(outcome, "would_update"); }

void print_updated(const Json& told, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", json_text(told).c_str());
    return;
  }
  if (output.quiet) return;
  const bool dry = is_event(told, "would_update");
  if (!dry && told.value("unchanged", false)) {
    say("nothing has changed: there are no points to add, and none of %s is to be removed; the newest version is still "
        "%s\n",
        told.value("output", std::string()).c_str(), count(told, "version").c_str());
    return;
  }
  if (told.value("made_earlier", false))
    say("an earlier run of this command has made the result already; what was left of that run is removed\n");
  const auto were = [&](const char* key) { return dry ? "would be" : is_one(told, key) ? "was" : "were"; };
  if (told.contains("removed")) {
    const std::string equal =
        told.contains("duplicates") ? " (" + count(told, "duplicates") + " of them equal to other points)" : "";
    say("%s %s removed, %s added%s\n", counted_of(told, "removed", "point").c_str(), were("removed"),
        count(told, "added").c_str(), equal.c_str());
  }
  std::string way;
  if (read(told, "way", way) && way == "anew") {
    say("most tiles have new or removed points, so all tiles %s triangulated anew, which costs less\n",
        dry ? "would be" : "were");
  } else if (told.value("estimated", false)) {
    say("about %s would be triangulated again, at most: those with new or removed points, and those beside them\n",
        counted_of(told, "tiles_awake", "tile").c_str());
  } else if (!way.empty()) {
    say("%s %s triangulated again, and %s of them %s\n", counted_of(told, "tiles_awake", "tile").c_str(),
        were("tiles_awake"), count(told, "tiles_changed").c_str(),
        dry                             ? "would change"
        : is_one(told, "tiles_changed") ? "has changed"
                                        : "have changed");
  }
  if (dry) {
    std::uint64_t bytes = 0;
    const auto seconds = told.find("seconds");
    if (read(told, "bytes", bytes) && seconds != told.end() && seconds->is_number())
      say("about %s would be written, in about %s\n", human_bytes(bytes).c_str(),
          human_seconds(seconds->get<double>()).c_str());
    return;
  }
  std::uint64_t split = 0;
  if (read(told, "tiles_split", split) && split > 0)
    say("%s had grown too large and %s split\n", counted(split, "tile").c_str(), split == 1 ? "was" : "were");
  std::string name;
  if (read(told, "output", name))
    say("%s, version %s: %s vertices, %s cells in %s\n", name.c_str(), count(told, "version").c_str(),
        count(told, "vertices").c_str(), count(told, "cells").c_str(), counted_of(told, "tiles", "tile").c_str());
}

std::optional<Measured> measured_of(const Json& outcome) {
  Measured measured;
  std::string folder;
  std::uint64_t version = 0;
  const auto made = outcome.find("made"), columns = outcome.find("columns"),
             of_cells = outcome.find("columns_of_cells");
  const auto total = outcome.find("total");
  if (!is_event(outcome, "measured") || !read(outcome, "output", folder) || !read(outcome, "version", version) ||
      made == outcome.end() || !made->is_boolean() || columns == outcome.end() || !columns->is_array() ||
      of_cells == outcome.end() || !of_cells->is_array() || total == outcome.end() ||
      !read(outcome, "total_of", measured.total_of) || !read(outcome, "unit", measured.unit) ||
      !read(outcome, "infinite", measured.infinite) || !read(outcome, "note", measured.note))
    return std::nullopt;
  measured.folder = folder;
  measured.version = static_cast<std::uint32_t>(version);
  measured.made = made->get<bool>();
  for (const auto& name : *columns) {
    if (!name.is_string()) return std::nullopt;
    const bool cells = std::find(of_cells->begin(), of_cells->end(), name) != of_cells->end();
    measured.columns.push_back({name.get<std::string>(), cells});
  }
  if (total->is_number()) measured.total = total->get<double>();
  return measured;
}

}  // namespace tessera::apps
