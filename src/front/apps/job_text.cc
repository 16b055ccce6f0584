#include "src/front/apps/job_text.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/printable.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

using Row = std::vector<std::string>;

// Returns a table. Columns are as wide as their widest entry, and two spaces apart.
std::string table(std::vector<Row> rows) {
  for (auto& row : rows)
    for (auto& cell : row) cell = printable(cell);
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += row[i];
      if (i + 1 < row.size()) line.append(widths[i] - row[i].size() + 2, ' ');
    }
    while (line.ends_with(' ')) line.pop_back();
    text += line + "\n";
  }
  return text;
}

std::string percent(const proto::StatusInfo& job) { return std::to_string(job.progress()) + " %"; }

}  // namespace

bool has_ended(const proto::StatusInfo& job) { return job.status() != "accepted" && job.status() != "running"; }

std::string jobs_text(const std::vector<proto::StatusInfo>& jobs) {
  if (jobs.empty()) return "there are no jobs\n";
  std::vector<Row> rows{{"JOB", "STATUS", "DONE", "PHASE", "PROCESS", "RESULT", "CREATED"}};
  for (const auto& job : jobs) {
    rows.push_back({job.job_id(), job.status(), percent(job), has_ended(job) ? "" : plain_phase(job.phase()),
                    job.process_id(), job.triangulation(), job.created()});
  }
  return table(rows);
}

std::string results_text(const std::vector<proto::TriangulationInfo>& results) {
  if (results.empty()) return "there are no results\n";
  std::vector<Row> rows{{"RESULT", "DIM", "VERTICES", "CELLS", "TILES", "SIZE", "CREATED"}};
  for (const auto& result : results) {
    rows.push_back({result.name(), std::to_string(result.dimension()), grouped(result.vertices()),
                    grouped(result.cells()), grouped(result.tiles()), human_bytes(result.bytes()), result.created()});
  }
  return table(rows);
}

std::string inputs_text(const std::vector<proto::InputInfo>& inputs, const std::string& folder) {
  if (inputs.empty())
    return folder.empty() ? "there are no point files and no folders to choose from\n"
                          : "there are no point files and no folders in " + printable(folder) + "\n";
  std::vector<Row> rows{{"INPUT", "SIZE", "POINTS", "SYSTEM"}};
  std::string notes;
  for (const auto& input : inputs) {
    if (input.folder()) {
      rows.push_back({input.name() + "/", "", "", ""});
      continue;
    }
    rows.push_back({input.name(), human_bytes(input.bytes()), input.has_points() ? grouped(input.points()) : "-",
                    input.crs().empty() ? "-" : input.crs()});
    if (!input.note().empty()) notes += printable(input.note()) + "\n";
  }
  return table(rows) + notes;
}

std::string nodes_text(const std::vector<proto::NodeInfo>& nodes) {
  if (nodes.empty()) return "there are no nodes\n";
  std::vector<Row> rows{
      {"NODE", "ADDRESS", "STATE", "THREADS", "MEMORY", "USED", "SCRATCH", "TILES", "SINCE", "HEARD"}};
  for (const auto& node : nodes) {
    rows.push_back({node.name(), node.address(), node.state() + (node.coordinator() ? ", coordinator" : ""),
                    grouped(node.threads()), human_bytes(node.memory_bytes()), human_bytes(node.memory_used_bytes()),
                    node.address().empty() ? "-" : human_bytes(node.scratch_free_bytes()) + " free",
                    grouped(node.tiles()), human_seconds(static_cast<double>(node.seconds())),
                    human_seconds(static_cast<double>(node.silent_ms()) / 1000) + " ago"});
  }
  std::string text = table(rows);
  for (const auto& node : nodes) {
    if (!node.certificate_warning().empty())
      text += printable(node.name() + ": its certificate " + node.certificate_warning()) + "\n";
    if (!node.last_words().empty())
      text += printable(node.name() + ": the process before this one " + node.last_words()) + "\n";
  }
  return text;
}

std::string local_nodes_text(const std::vector<LocalNodeState>& nodes) {
  std::vector<Row> rows{{"NODE", "PROCESS", "STATE", "THREADS", "MEMORY", "USED", "LOG"}};
  for (const auto& [info, process, log] : nodes) {
    Row row{info.name(), process == 0 ? "ended" : std::to_string(process), "", "", "", "", log};
    if (process != 0) row[2] = info.state().empty() ? "no member" : info.state();
    if (process != 0 && !info.state().empty()) {
      row[3] = grouped(info.threads());
      row[4] = human_bytes(info.memory_bytes());
      row[5] = human_bytes(info.memory_used_bytes());
    }
    rows.push_back(std::move(row));
  }
  return table(rows);
}

std::string job_text(const proto::StatusInfo& job) {
  std::string text;
  const auto line = [&](std::string name, const std::string& value) {
    if (value.empty()) return;
    name.resize(14, ' ');
    text += name + printable(value) + "\n";
  };
  line("job", job.job_id());
  line("process", job.process_id());
  line("status", job.status() + ", " + percent(job) +
                     (has_ended(job) || job.phase().empty() ? "" : ", " + plain_phase(job.phase())) +
                     (has_ended(job) && job.resumable() ? ", can be resumed" : ""));
  line("message", job.message());
  if (job.has_problem()) line("problem", job.problem().detail());
  line("result", job.triangulation());
  if (job.tiles().total() > 0) {
    line("tiles", grouped(job.tiles().triangulated()) + " of " + grouped(job.tiles().total()) + " triangulated, " +
                      grouped(job.tiles().stored()) + " stored");
  }
  if (job.points() > 0) line("points", grouped(job.points()));
  if (job.memory_bytes() > 0) line("memory", human_bytes(job.memory_bytes()));
  if (job.nodes_lost() > 0) line("nodes lost", grouped(job.nodes_lost()));
  line("submitter", job.submitter());
  line("created", job.created());
  line("started", job.started() + (job.starts() > 1 ? " (start number " + std::to_string(job.starts()) + ")" : ""));
  line("finished", job.finished());
  return text;
}

nlohmann::ordered_json job_json(const proto::StatusInfo& job) {
  nlohmann::ordered_json json{{"event", "job"},
                              {"id", job.job_id()},
                              {"process", job.process_id()},
                              {"status", job.status()},
                              {"progress", job.progress()},
                              {"phase", job.phase()},
                              {"message", job.message()},
                              {"result", job.triangulation()},
                              {"points", job.points()},
                              {"tiles_total", job.tiles().total()},
                              {"tiles_triangulated", job.tiles().triangulated()},
                              {"tiles_stored", job.tiles().stored()},
                              {"memory_bytes", job.memory_bytes()},
                              {"nodes_lost", job.nodes_lost()},
                              {"resumable", job.resumable()},
                              {"starts", job.starts()},
                              {"submitter", job.submitter()},
                              {"created", job.created()},
                              {"started", job.started()},
                              {"finished", job.finished()}};
  if (job.has_problem()) json["problem"] = {{"detail", job.problem().detail()}, {"cause", job.problem().cause()}};
  return json;
}

nlohmann::ordered_json result_json(const proto::TriangulationInfo& result) {
  return {{"event", "result"},
          {"name", result.name()},
          {"dimension", result.dimension()},
          {"vertices", result.vertices()},
          {"cells", result.cells()},
          {"tiles", result.tiles()},
          {"bytes", result.bytes()},
          {"digest", result.digest()},
          {"crs", result.crs()},
          {"bounds", std::vector<double>(result.bounds().begin(), result.bounds().end())},
          {"created", result.created()}};
}

nlohmann::ordered_json input_json(const proto::InputInfo& input) {
  nlohmann::ordered_json json{{"event", "input"}, {"name", input.name()}, {"folder", input.folder()}};
  json["modified"] = input.modified();
  if (input.folder()) return json;
  json["bytes"] = input.bytes();
  json["format"] = input.format();
  if (input.has_points()) json["points"] = input.points();
  if (input.bounds_size() > 0) json["bounds"] = std::vector<double>(input.bounds().begin(), input.bounds().end());
  if (!input.crs().empty()) json["crs"] = input.crs();
  if (!input.note().empty()) json["note"] = input.note();
  return json;
}

nlohmann::ordered_json node_json(const proto::NodeInfo& node) {
  return {{"event", "node"},
          {"name", node.name()},
          {"id", node.id()},
          {"address", node.address()},
          {"threads", node.threads()},
          {"memory_bytes", node.memory_bytes()},
          {"memory_used_bytes", node.memory_used_bytes()},
          {"scratch_free_bytes", node.scratch_free_bytes()},
          {"certificate_until", node.certificate_until()},
          {"certificate_warning", node.certificate_warning()},
          {"tiles", node.tiles()},
          {"state", node.state()},
          {"seconds", node.seconds()},
          {"silent_ms", node.silent_ms()},
          {"coordinator", node.coordinator()},
          {"last_words", node.last_words()}};
}

nlohmann::ordered_json local_node_json(const LocalNodeState& node) {
  auto json = node_json(node.info);
  json["pid"] = node.process;
  json["log"] = node.log;
  return json;
}

}  // namespace tessera::apps
