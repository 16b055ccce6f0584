// The question contours: the contour lines of a 2D result.
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/job/arguments.h"
#include "src/result/terrain/contours.h"
#include "src/service/beneath.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {

Result<QuestionAnswer> answer_contours(const OpenQuestion& asked) {
  ContourOptions options{.memory_bytes = asked.memory_bytes(), .threads = asked.ask.threads};
  BOOST_OUTCOME_TRY(interval, asked.read("interval", [](const std::string& text) { return parse_distance(text); }));
  options.interval = interval;
  if (asked.question.options.contains("base")) {
    BOOST_OUTCOME_TRY(base, asked.read("base", [](const std::string& text) { return parse_finite(text); }));
    options.base = base;
  }
  for (const auto& [key, to] : {std::pair("smooth", &options.smooth), std::pair("min-length", &options.min_length)}) {
    if (!asked.question.options.contains(key)) continue;
    BOOST_OUTCOME_TRY(length, asked.read(key, [](const std::string& text) { return parse_distance(text); }));
    *to = length;
  }
  if (asked.question.options.contains("index-every")) {
    BOOST_OUTCOME_TRY(every, asked.read("index-every", [](const std::string& text) {
      return parse_integer(text, 1, index_every_max);
    }));
    options.index_every = every;
  }
  BOOST_OUTCOME_TRYV(asked.read_surface(options));
  options.vertices_max = asked.limits.line_vertices;
  options.samples_max = asked.limits.pixels;
  const std::string format = asked.word("f", "geojson");
  if (format != "geojson" && format != "gpkg")
    return error(Errc::usage, "f: '" + format + "' is not a format of lines; the formats are geojson and gpkg");
  BOOST_OUTCOME_TRY(made, write_contours(path_of(asked.reader.held.folder), answer_file(asked.folder, "." + format),
                                         options, asked.ask.stop));
  return asked.file(made.path,
                    asked.reader.stored.knows(source_box(options).value_or(asked.reader.stored.manifest().bounds)));
}

}  // namespace tessera::service
