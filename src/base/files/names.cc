#include "src/base/files/names.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include "src/base/files/checksum.h"
#include "src/base/files/data_names.h"
#include "src/base/files/handed_file.h"
#include "src/base/files/pass_names.h"
#include "src/base/random_token.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr const char* temporary_ending = ".tmp";
constexpr const char* done_ending = ".done";
constexpr const char* tile_ending = ".vtu";
constexpr const char* points_tile_ending = ".pts";
constexpr const char* version_ending = ".json";
constexpr const char* copy_ending = ".copy.json";
constexpr const char* of_node = "node-";
constexpr const char* settled_ending = ".bin";
constexpr const char* of_stage = ".stage";
constexpr const char* new_run = ".run.new";
constexpr const char* unfinished = ".unfinished-";
constexpr const char* removed = ".removed-";
constexpr const char* staging_prefix = ".desk-";
constexpr const char* authority = "ca";
constexpr const char* certificate_ending = ".pem";
constexpr const char* key_ending = ".key";

// A name that no other process has. Numbers of processes alone are used again, and by every container.
std::string token_of_process() {
  static const std::string token = random_token();
  return "-" + std::to_string(::getpid()) + "-" + token;
}

fs::path numbered(const fs::path& folder, std::uint32_t number, const char* ending) {
  char name[32];
  std::snprintf(name, sizeof name, "%06u%s", number, ending);
  return folder / name;
}

fs::path numbered(const fs::path& folder, TileId tile, const char* ending) {
  return numbered(folder, tile.value, ending);
}

fs::path numbered(const fs::path& folder, NodeId node, const char* ending) {
  return folder / (of_node + numbered("", node.value, ending).string());
}

fs::path numbered(const fs::path& folder, ShuffleFileId bundle) {
  return folder / (numbered("", bundle.attempt, "-").string() + numbered("", bundle.number, ".bin").string());
}

std::optional<std::uint32_t> number_in(std::string_view text) {
  std::uint32_t number = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (wrong != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string without_temporary_ending(const fs::path& file) {
  std::string name = file.filename().string();
  if (const auto at = name.find(temporary_ending); at != std::string::npos) name.resize(at);
  return name;
}

const char* folder_name(ScratchKind kind) {
  switch (kind) {
    case ScratchKind::state:
      return "state";
    case ScratchKind::finals:
      return "finals";
    case ScratchKind::mail:
      return "mail";
    case ScratchKind::duplicates:
      return "duplicates";
    case ScratchKind::settled:
      return "settled";
    case ScratchKind::kept:
      return "kept";
    case ScratchKind::routing:
    case ScratchKind::split:
      break;
  }
  return "";
}

// Whether the name is `stem`.bin, or `stem`-SUM.bin with a checksum.
bool is_named_by_sum(const fs::path& file, const std::string& stem) {
  const auto name = file.filename().string();
  if (name == stem + ".bin") return true;
  constexpr std::size_t digits = 16;
  const std::size_t first = stem.size() + 1;
  if (name.size() != first + digits + 4 || !name.starts_with(stem + "-") || !name.ends_with(".bin")) return false;
  return name.find_first_not_of("0123456789abcdef", first) == first + digits;
}

}  // namespace

fs::path manifest_file(const fs::path& out) { return out / "manifest.json"; }
fs::path master_file(const fs::path& out) { return out / "triangulation.pvtu"; }
fs::path tiles_folder(const fs::path& out) { return out / "tiles"; }
fs::path tile_file(const fs::path& out, TileId tile, std::uint32_t version, TileKind kind) {
  std::string ending = kind == TileKind::cells ? tile_ending : points_tile_ending;
  if (version > 1) ending = "-" + std::to_string(version) + ending;
  return numbered(tiles_folder(out), tile, ending.c_str());
}
std::optional<TileKind> kind_of_tile_file(const fs::path& file) {
  const auto ending = file.extension();
  if (ending == tile_ending) return TileKind::cells;
  if (ending == points_tile_ending) return TileKind::points;
  return std::nullopt;
}
std::optional<std::uint32_t> version_of_tile_file(const fs::path& file) {
  const std::string name = file.filename().string();
  const auto kind = kind_of_tile_file(file);
  const auto dash = name.find('-');
  if (!kind || dash == std::string::npos) return std::nullopt;
  const auto tile = number_in(std::string_view(name).substr(0, dash));
  const auto version = number_in(std::string_view(name).substr(dash + 1, name.rfind('.') - dash - 1));
  if (!tile || !version || *version < 2) return std::nullopt;
  // A name counts only if tile_file() makes exactly this name.
  if (tile_file("", TileId{*tile}, *version, *kind).filename() != name) return std::nullopt;
  return version;
}
fs::path versions_folder(const fs::path& out) { return out / ".versions"; }
fs::path version_file(const fs::path& out, std::uint32_t version) {
  return numbered(versions_folder(out), version, version_ending);
}
fs::path version_copy(const fs::path& out, std::uint32_t version) {
  return numbered(versions_folder(out), version, copy_ending);
}
std::optional<std::uint32_t> version_of_file(const fs::path& file) {
  const std::string name = file.filename().string();
  const auto version = number_in(std::string_view(name).substr(0, name.find('.')));
  if (!version || (version_file("", *version).filename() != name && version_copy("", *version).filename() != name))
    return std::nullopt;
  return version;
}
std::optional<NamedVersion> named_version(const fs::path& path) {
  const auto folder = path.parent_path();
  const auto version = version_of_file(path);
  if (!version || *version == 0 || folder.filename() != versions_folder("").filename()) return std::nullopt;
  const auto out = folder.parent_path();
  return NamedVersion{out.empty() ? fs::path(".") : out, *version};
}
fs::path version_log_file(const fs::path& out) { return versions_folder(out) / "log.json"; }
fs::path pass_folder(const fs::path& out) { return versions_folder(out) / "pass"; }
fs::path pass_values_file(const fs::path& scratch, TileId tile) { return numbered(scratch / "values", tile, ".bin"); }
fs::path pass_sent_file(const fs::path& scratch, TileId tile) { return numbered(scratch / "sent", tile, ".bin"); }
fs::path done_file(const fs::path& out, NodeId node) { return numbered(tiles_folder(out), node, done_ending); }
fs::path early_file(const fs::path& out, TileId tile, NodeId node) {
  fs::path name = temporary_name(tile_file(out, tile));
  name += "-early-" + std::to_string(node.value);
  return name;
}
fs::path duplicates_file(const fs::path& out) { return out / "duplicates.bin"; }
fs::path duplicates_file(const fs::path& out, std::uint64_t xxh3) {
  return out / ("duplicates-" + checksum_text(xxh3) + ".bin");
}
bool is_duplicates_name(const fs::path& file) { return is_named_by_sum(file, "duplicates"); }
fs::path duplicate_rows_file(const fs::path& out) { return out / "duplicate-rows.bin"; }
fs::path duplicate_rows_file(const fs::path& out, std::uint64_t xxh3) {
  return out / ("duplicate-rows-" + checksum_text(xxh3) + ".bin");
}
bool is_duplicate_rows_name(const fs::path& file) { return is_named_by_sum(file, "duplicate-rows"); }
fs::path report_file(const fs::path& out) { return out / "report.html"; }
fs::path lock_folder(const fs::path& out) { return out / ".lock"; }
fs::path new_lock_folder(const fs::path& out, const std::string& owner) {
  fs::path name = temporary_name(lock_folder(out));
  name += "-" + owner;
  return name;
}
fs::path run_folder(const fs::path& out) { return out / ".run"; }
fs::path new_run_folder(const fs::path& out) { return out / (new_run + token_of_process()); }

fs::path outcome_file(const fs::path& run) { return run / "outcome.json"; }
fs::path plan_file(const fs::path& run) { return run / "plan.json"; }
fs::path points_folder(const fs::path& run) { return run / "points"; }
fs::path attributes_folder(const fs::path& run) { return run / "attributes"; }
fs::path segments_file(const fs::path& run) { return run / "segments.bin"; }
fs::path points_file(const fs::path& run, ShuffleFileId bundle) { return numbered(points_folder(run), bundle); }
fs::path attributes_file(const fs::path& run, ShuffleFileId bundle) { return numbered(attributes_folder(run), bundle); }
fs::path routing_file(const fs::path& run) { return run / "routing.bin"; }
fs::path routed_splits_folder(const fs::path& run) { return run / "stretches"; }
fs::path routed_split_file(const fs::path& run, std::uint32_t attempt) {
  return numbered(routed_splits_folder(run), attempt, ".bin");
}

fs::path stage_folder(const fs::path& run, std::uint32_t stage) {
  return stage == 0 ? run : numbered(run, stage, of_stage);
}
fs::path scratch_folder(const fs::path& run, ScratchKind kind) { return run / folder_name(kind); }
fs::path scratch_file(const fs::path& run, ScratchKind kind, TileId tile) {
  return numbered(scratch_folder(run, kind), tile, ".bin");
}
fs::path settled_file(const fs::path& run, NodeId node) {
  return numbered(scratch_folder(run, ScratchKind::settled), node, settled_ending);
}
fs::path handed_file(const fs::path& run, TileId tile) { return numbered(run / "handed", tile, ".bin"); }
fs::path settled_marker(const fs::path& run) { return run / "settled.done"; }
fs::path terms_folder(const fs::path& run) { return run / "terms"; }

fs::path data_reserve_file(const fs::path& data) { return data / "reserve"; }
fs::path data_format_file(const fs::path& data) { return data / "format"; }
fs::path share_scratch_folder(const fs::path& scratch, std::uint64_t number) {
  return scratch / ("part-" + std::to_string(number));
}
fs::path outbox_scratch_file(const fs::path& share, NodeId node) {
  return share / ("node-" + std::to_string(node.value));
}
bool is_share_scratch_name(const fs::path& file) { return file.filename().string().starts_with("part-"); }
fs::path last_words_file(const fs::path& scratch) { return scratch / "life"; }
fs::path data_identity_file(const fs::path& data) { return data / "id"; }
fs::path node_scratch_folder(const fs::path& data, const std::string& node) { return data / "scratch" / node; }
fs::path jobs_folder(const fs::path& data) { return data / "jobs"; }
fs::path job_folder(const fs::path& data, const std::string& id) { return jobs_folder(data) / id; }
fs::path job_record_file(const fs::path& job) { return job / "job.json"; }
fs::path job_log_file(const fs::path& job) { return job / "log.txt"; }
fs::path job_outcome_file(const fs::path& job) { return job / "outcome.json"; }
fs::path forgotten_jobs_file(const fs::path& data) { return data / "forgotten.txt"; }
fs::path event_numbers_file(const fs::path& data) { return data / "events.json"; }
fs::path results_folder(const fs::path& data) { return data / "results"; }
fs::path exports_folder(const fs::path& out) { return out / "exports"; }
fs::path tileset_of_result(const fs::path& out) { return exports_folder(out) / "3dtiles"; }
fs::path dem_of_result(const fs::path& out) { return exports_folder(out) / "dem.tif"; }
fs::path contours_of_result(const fs::path& out) { return exports_folder(out) / "contours.gpkg"; }
fs::path surface_of_result(const fs::path& out) { return exports_folder(out) / "surface.ply"; }
fs::path uploads_folder(const fs::path& data) { return data / "uploads"; }
fs::path answers_folder(const fs::path& data) { return data / "answers"; }
fs::path answer_file(const fs::path& folder, const std::string& ending) { return folder / ("answer" + ending); }
fs::path asked_points_file(const fs::path& folder, const std::string& ending) { return folder / ("points" + ending); }

fs::path tokens_file(const fs::path& data) { return data / "tokens"; }
fs::path sessions_file(const fs::path& data) { return data / "sessions"; }
fs::path part_file(const fs::path& final_name) {
  return final_name.parent_path() / ("." + final_name.filename().string() + ".part");
}
fs::path owner_file(const fs::path& of) { return of.parent_path() / ("." + of.filename().string() + ".owner"); }
fs::path unfinished_folder(const fs::path& folder, const std::string& job) { return folder / (unfinished + job); }
fs::path staging_folder_path(const fs::path& folder, std::uint64_t term) {
  return folder / (staging_prefix + std::to_string(term));
}
std::optional<std::uint64_t> term_of_staging_folder(const fs::path& file) {
  const std::string name = file.filename().string(), begin = staging_prefix;
  std::uint64_t term = 0;
  const char* const last = name.data() + name.size();
  if (!name.starts_with(begin)) return std::nullopt;
  const auto [end, wrong] = std::from_chars(name.data() + begin.size(), last, term);
  if (wrong != std::errc{} || end != last) return std::nullopt;
  return term;
}
fs::path removed_folder(const fs::path& folder, const std::string& token) { return folder / (removed + token); }

fs::path tileset_file(const fs::path& tileset) { return tileset / "tileset.json"; }
fs::path tileset_nodes_folder(const fs::path& tileset) { return tileset / "nodes"; }
fs::path tileset_node_file(const fs::path& tileset, std::uint32_t node) {
  return numbered(tileset_nodes_folder(tileset), node, ".glb");
}

fs::path authority_file(const fs::path& certs) { return node_certificate_file(certs, authority); }
fs::path authority_key_file(const fs::path& certs) { return node_key_file(certs, authority); }
fs::path node_certificate_file(const fs::path& certs, const std::string& node) {
  return certs / (node + certificate_ending);
}
fs::path node_key_file(const fs::path& certs, const std::string& node) { return certs / (node + key_ending); }

fs::path local_cluster_file(const fs::path& folder) { return folder / "cluster.json"; }
fs::path local_token_file(const fs::path& folder) { return folder / "token"; }
fs::path local_certificates_folder(const fs::path& folder) { return folder / "certs"; }
fs::path local_data_folder(const fs::path& folder) { return folder / "data"; }
fs::path local_logs_folder(const fs::path& folder) { return folder / "logs"; }
fs::path local_log_file(const fs::path& folder, const std::string& node) {
  return local_logs_folder(folder) / (node + ".log");
}

fs::path temporary_name(const fs::path& final_name) {
  fs::path name = final_name;
  name += temporary_ending;
  return name;
}

fs::path temporary_name_of_process(const fs::path& final_name) {
  fs::path name = temporary_name(final_name);
  name += token_of_process();
  return name;
}

bool is_result_name(const fs::path& file) {
  const auto name = without_temporary_ending(file);
  return name == manifest_file("") || name == master_file("") || is_duplicates_name(name) ||
         is_duplicate_rows_name(name) || name == report_file("") ||
         name == "triangulation.vtkhdf";  // the master file of format 1
}

bool is_tile_name(const fs::path& file) {
  const auto name = file.filename().string();
  if (name.starts_with(of_node) && is_done_name(file)) return true;
  return name.size() > 7 && std::all_of(name.begin(), name.begin() + 6, [](char c) { return c >= '0' && c <= '9'; });
}

bool is_settled_name(const fs::path& file) {
  return file.filename().string().starts_with(of_node) && file.extension() == settled_ending;
}

bool is_run_name(const fs::path& file) {
  const auto name = without_temporary_ending(file);
  return name == plan_file("") || name == points_folder("") || name == attributes_folder("") ||
         name == segments_file("") || name == routing_file("") || name == routed_splits_folder("") ||
         name == settled_marker("") || name == terms_folder("") || name == handed_file("", {}).parent_path() ||
         fs::path(name).extension() == of_stage ||
         std::any_of(std::begin(scratch_kinds), std::end(scratch_kinds),
                     [&](ScratchKind kind) { return name == scratch_folder("", kind); });
}

bool is_done_name(const fs::path& file) { return file.extension() == done_ending; }
bool is_temporary_name(const fs::path& file) { return file.extension().string().starts_with(temporary_ending); }

bool is_lock_name(const fs::path& file) {
  const auto name = file.filename().string();
  return name == lock_folder("") || name.starts_with(new_lock_folder("", "").string());
}

bool is_new_run_name(const fs::path& file) { return file.filename().string().starts_with(new_run); }

bool is_job_name(const fs::path& file) {
  const auto name = without_temporary_ending(file);
  return name == job_record_file("") || name == job_log_file("") || name == job_outcome_file("");
}

std::optional<std::string> token_of_removed(const fs::path& file) {
  const std::string name = file.filename().string(), begin = removed;
  if (!name.starts_with(begin)) return std::nullopt;
  return name.substr(begin.size());
}

std::string node_of_certificate(const fs::path& file) {
  if (file.extension() != certificate_ending || file.stem() == authority) return "";
  return file.stem().string();
}

std::string job_of_unfinished(const fs::path& file) {
  const std::string name = file.filename().string(), begin = unfinished;
  return name.starts_with(begin) ? name.substr(begin.size()) : "";
}

}  // namespace tessera
