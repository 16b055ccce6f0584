#include "src/job/report/summary.h"

#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/job/report/human.h"

namespace tessera {

std::string duplicates_text(std::uint64_t other_heights, DuplicatePolicy keep) {
  std::string text = " duplicates";
  if (other_heights > 0) text += ", " + grouped(other_heights) + " of them at other heights";
  if (other_heights > 0 || keep != DuplicatePolicy::first) text += " (the " + std::string(name_of(keep)) + " is kept)";
  return text;
}

std::string summary_text(const JobSummary& s) {
  const ExchangeFigures& e = s.exchange;
  std::string text;
  const auto line = [&](std::string name, const std::string& value) {
    name.resize(14, ' ');
    text += name + printable(value) + "\n";
  };
  const auto also = [](std::uint64_t n, const char* what) { return n == 0 ? std::string() : ", " + grouped(n) + what; };
  const auto duplicates = duplicates_text(s.other_heights.value_or(0), s.keep);
  line("points", grouped(s.points_read) + also(s.duplicates, duplicates.c_str()) +
                     also(s.invalid, " invalid, skipped") + also(s.filtered, " filtered out"));
  line("vertices", grouped(s.vertices));
  line(s.dimension == 3 ? "tetrahedra" : "triangles", grouped(s.cells));
  line("tiles", grouped(s.tiles) + (e.sleeps > 0 ? " (put to sleep " + counted(e.sleeps, "time") + ")" : ""));
  if (s.tiles > 1) line("messages", grouped(e.updates) + " between tiles, with " + counted(e.points.sent, "point"));
  if (e.nodes > 1 || e.nodes_lost > 0) {
    line("nodes",
         grouped(e.nodes) +
             (e.nodes_lost > 0
                  ? ", of which " + grouped(e.nodes_lost) + (e.nodes_lost == 1 ? " was lost: " : " were lost: ") +
                        counted(e.tiles_again, "tile") + (e.tiles_again == 1 ? " was" : " were") + " begun again"
                  : "") +
             "; " + human_bytes(e.bytes_between) + " between them");
  }
  std::string phases;
  for (const auto& [name, seconds] : s.seconds)
    phases += (phases.empty() ? "" : ", ") + plain_phase(name) + " " + human_seconds(seconds);
  line("time", human_seconds(s.total_s) + " (" + phases + ")");
  const auto budget = s.memory_budget_bytes == 0 ? "" : ", of " + human_bytes(s.memory_budget_bytes);
  line("memory", human_bytes(s.peak_memory_bytes) + " at most" + budget);
  line("result", s.out + " (" + human_bytes(s.result_bytes) + ")");
  if (!s.digest.empty()) line("digest", s.digest);
  for (const auto& warning : s.warnings) line("warning", warning);
  return text;
}

std::string summary_json(const JobSummary& s) {
  const ExchangeFigures& e = s.exchange;
  using Json = nlohmann::ordered_json;
  Json seconds = Json::object();
  for (const auto& [name, value] : s.seconds) seconds[name] = value;
  const Json json{{"event", "summary"},
                  {"out", s.out},
                  {"dimension", s.dimension},
                  {"points", s.points_read},
                  {"invalid", s.invalid},
                  {"filtered", s.filtered},
                  {"duplicates", s.duplicates},
                  {"duplicates_at_other_heights", s.other_heights ? Json(*s.other_heights) : Json()},
                  {"keep", name_of(s.keep)},
                  {"vertices", s.vertices},
                  {"cells", s.cells},
                  {"tiles", s.tiles},
                  {"messages", e.updates},
                  {"points_sent", e.points.sent},
                  {"points_received", e.points.received},
                  {"points_inserted", e.points.inserted},
                  {"points_kept", e.points.useful},
                  {"rounds", e.hops},
                  {"most_received", e.most_received},
                  {"waves", e.waves},
                  {"sleeps", e.sleeps},
                  {"nodes", e.nodes},
                  {"nodes_lost", e.nodes_lost},
                  {"tiles_again", e.tiles_again},
                  {"bytes_between", e.bytes_between},
                  {"credit_waits", e.credit_waits},
                  {"threads", s.threads},
                  {"memory_budget_bytes", s.memory_budget_bytes},
                  {"peak_memory_bytes", s.peak_memory_bytes},
                  {"result_bytes", s.result_bytes},
                  {"digest", s.digest},
                  {"seconds", seconds},
                  {"total_s", s.total_s},
                  {"warnings", s.warnings}};
  return json_text(json);
}

}  // namespace tessera
