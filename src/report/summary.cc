#include "src/report/summary.h"

#include <nlohmann/json.hpp>

#include "src/report/human.h"

namespace tessera {

std::string summary_text(const JobSummary& s) {
  std::string text;
  const auto line = [&](std::string name, const std::string& value) {
    name.resize(14, ' ');
    text += name + value + "\n";
  };
  const auto also = [](std::uint64_t n, const char* what) { return n == 0 ? std::string() : ", " + grouped(n) + what; };
  line("points", grouped(s.points_read) + also(s.duplicates, " duplicates") + also(s.invalid, " invalid, skipped") +
                     also(s.filtered, " filtered out"));
  line("vertices", grouped(s.vertices));
  line(s.dimension == 3 ? "tetrahedra" : "triangles", grouped(s.cells));
  line("tiles", grouped(s.tiles) + (s.sleeps > 0 ? " (put to sleep " + grouped(s.sleeps) + " times)" : ""));
  line("messages", grouped(s.messages) + " with " + grouped(s.points_sent) + " points, " + grouped(s.rounds) +
                       " rounds equivalent");
  std::string phases;
  for (const auto& [name, seconds] : s.seconds)
    phases += (phases.empty() ? "" : ", ") + name + " " + human_seconds(seconds);
  line("time", human_seconds(s.total_s) + " (" + phases + ")");
  line("memory", human_bytes(s.peak_memory_bytes) + " at most, of " + human_bytes(s.memory_budget_bytes));
  line("result", s.out + " (" + human_bytes(s.result_bytes) + ")");
  return text;
}

std::string summary_json(const JobSummary& s) {
  nlohmann::ordered_json seconds = nlohmann::ordered_json::object();
  for (const auto& [name, value] : s.seconds) seconds[name] = value;
  const nlohmann::ordered_json json{{"event", "summary"},
                                    {"out", s.out},
                                    {"dimension", s.dimension},
                                    {"points", s.points_read},
                                    {"invalid", s.invalid},
                                    {"filtered", s.filtered},
                                    {"duplicates", s.duplicates},
                                    {"vertices", s.vertices},
                                    {"cells", s.cells},
                                    {"tiles", s.tiles},
                                    {"messages", s.messages},
                                    {"points_sent", s.points_sent},
                                    {"points_received", s.points_received},
                                    {"points_inserted", s.points_inserted},
                                    {"points_kept", s.points_kept},
                                    {"rounds", s.rounds},
                                    {"waves", s.waves},
                                    {"sleeps", s.sleeps},
                                    {"threads", s.threads},
                                    {"memory_budget_bytes", s.memory_budget_bytes},
                                    {"peak_memory_bytes", s.peak_memory_bytes},
                                    {"result_bytes", s.result_bytes},
                                    {"seconds", seconds},
                                    {"total_s", s.total_s}};
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tessera
