#include "src/result/store/manifest.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/periodic_box.h"
#include "src/result/store/manifest_json.h"
#include "src/result/store/period.h"
#include "src/result/store/tile_layout.h"
#include "src/result/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

namespace store {

namespace {

// The keys of checksums are the names of their files.
const std::string master_key = master_file("").string();

// Digests of another definition have another key, and are ignored: "digest" was a hash of sorted ids.
constexpr const char* digest_key = "digest2";

ordered_json triple(const Point& p) { return {number(p.x), number(p.y), number(p.z)}; }
Point to_point(const json& value) { return {to_double(value.at(0)), to_double(value.at(1)), to_double(value.at(2))}; }

template <class B>
ordered_json corners(const B& box) {
  return {{"lo", triple(box.lo)}, {"hi", triple(box.hi)}};
}
template <class B>
B to_corners(const json& value) {
  B box;
  box.lo = to_point(value.at("lo"));
  box.hi = to_point(value.at("hi"));
  return box;
}

std::array<double, 3> to_period(const json& value, int dimension) {
  std::array<double, 3> period{};
  bool any = false;
  for (std::size_t axis = 0; axis < period.size(); ++axis) {
    const double length = period[axis] = value.at(axis).get<double>();
    if (length == 0) continue;
    if (axis >= static_cast<std::size_t>(dimension) || !is_period(length))
      throw json::other_error::create(501, "a period is none", &value);
    any = true;
  }
  if (!any) throw json::other_error::create(501, "all periods are 0", &value);
  return period;
}

DuplicatePolicy to_kept_point(const json& value) {
  const auto text = value.get<std::string>();
  const auto keep = kept_point_of(text);
  if (!keep) throw json::other_error::create(501, "'" + text + "' is not a way to choose among equal points", &value);
  return *keep;
}

std::optional<Digest> to_digest(const json& value) {
  if (!value.contains(digest_key)) return std::nullopt;
  const auto text = value.at(digest_key).get<std::string>();
  const auto digest = parse_digest(text);
  if (!digest) throw json::other_error::create(501, "'" + text + "' is not a digest", &value);
  return digest;
}

ordered_json entry_to_json(const TileEntry& entry) {
  ordered_json value{{"tile", entry.tile.value},         {"points", entry.points},
                     {"own_points", entry.own_points},   {"cells", entry.cells},
                     {"main_cells", entry.main_cells},   {"bytes", entry.bytes},
                     {"xxh3", checksum_text(entry.xxh3)}};
  if (entry.kind == TileKind::points) value["kind"] = "points";
  if (entry.version > 1) value["file"] = tile_file("", entry).generic_string();
  if (entry.digest) value[digest_key] = digest_text(*entry.digest);
  if (entry.heights) value["heights"] = {number(entry.heights->lo), number(entry.heights->hi)};
  return value;
}

TileEntry to_entry(const json& value) {
  TileEntry entry;
  const std::uint64_t tile = to_count(value.at("tile"));
  if (tile > std::numeric_limits<std::uint32_t>::max())
    throw json::other_error::create(501, "tile " + std::to_string(tile) + " does not exist", &value);
  entry.tile = TileId{static_cast<std::uint32_t>(tile)};
  entry.points = to_count(value.at("points"));
  entry.own_points = to_count(value.at("own_points"));
  entry.cells = to_count(value.at("cells"));
  entry.main_cells = to_count(value.at("main_cells"));
  entry.bytes = to_count(value.at("bytes"));
  entry.xxh3 = to_sum(value.at("xxh3"));
  entry.digest = to_digest(value);
  if (value.contains("kind")) {
    if (value.at("kind") != "points")
      throw json::other_error::create(501, json_text(value.at("kind")) + " is not a kind of tile", &value);
    entry.kind = TileKind::points;
  }
  if (value.contains("file")) {
    const auto file = value.at("file").get<std::string>();
    const auto version = version_of_tile_file(file);
    entry.version = version.value_or(1);
    if (!version || tile_file("", entry).generic_string() != file)
      throw json::other_error::create(501, "'" + file + "' is not a file of tile " + to_string(entry.tile), &value);
  }
  if (value.contains("heights")) {
    const auto& heights = value.at("heights");
    entry.heights = HeightRange{to_double(heights.at(0)), to_double(heights.at(1))};
  }
  return entry;
}

Manifest::Input to_input(const json& value) {
  Manifest::Input input{value.at("path").get<std::string>(), to_count(value.at("bytes")),
                        value.at("modified_ns").get<std::int64_t>()};
  if (!value.contains("points")) return input;
  input.ids = {to_count(value.at("first_id")), to_count(value.at("points"))};
  if (input.ids->first + input.ids->count < input.ids->first)
    throw json::other_error::create(501, "an input has an impossible number of points", &value);
  return input;
}

ordered_json input_to_json(const Manifest::Input& input) {
  ordered_json value{{"path", input.path}, {"bytes", input.bytes}, {"modified_ns", input.modified_ns}};
  if (input.ids) {
    value["first_id"] = input.ids->first;
    value["points"] = input.ids->count;
  }
  return value;
}

// The members that make a partition. Code that walks the splits must check that they are a tree.
std::string partition_text(const json& value, const Manifest& manifest) {
  if (!value.contains("splits")) throw json::other_error::create(501, "the partition has no splits", &value);
  if (to_count(value.at("dimension")) != static_cast<std::uint64_t>(manifest.dimension) ||
      to_count(value.at("tiles")) != manifest.boxes.size() || !value.at("splits").is_array())
    throw json::other_error::create(501, "the partition does not fit the result", &value);
  const auto member = [&](const char* name) { return std::pair(std::string(name), value.at(name)); };
  json partition(std::map{member("kind"), member("dimension"), member("tiles"), member("splits")});
  if (value.contains("split_above")) partition["split_above"] = to_count(value.at("split_above"));
  if (value.contains("period") != is_periodic(manifest))
    throw json::other_error::create(501, "only results of format " + std::to_string(periodic_format) + " have a period",
                                    &value);
  if (value.contains("period")) partition["period"] = to_period(value.at("period"), manifest.dimension);
  return json_text(partition);
}

// In format 5 the name of the file has the checksum of the file.
void read_duplicates_sums(const json& sums, Manifest& manifest) {
  for (const auto& [name, sum] : sums.items()) {
    const bool rows = is_duplicate_rows_name(name);
    if (!rows && !is_duplicates_name(name)) continue;
    (rows ? manifest.duplicate_rows_xxh3 : manifest.duplicates_xxh3) = to_sum(sum);
    if ((rows ? duplicate_rows_of("", manifest) : duplicates_of("", manifest)).string() != name)
      throw json::other_error::create(501, "'" + name + "' is not the name of the duplicates", &sums);
  }
}

Manifest to_manifest(const json& value) {
  Manifest manifest;
  manifest.format_version = static_cast<int>(to_count(value.at("format_version")));
  manifest.software_version = value.at("software_version").get<std::string>();
  manifest.command = value.at("command").get<std::vector<std::string>>();
  for (const auto& input : value.at("inputs")) manifest.inputs.push_back(to_input(input));
  manifest.dimension = static_cast<int>(to_count(value.at("dimension")));
  if (manifest.dimension != 2 && manifest.dimension != 3)
    throw json::other_error::create(501, "the dimension is neither 2 nor 3", &value);
  manifest.crs = value.at("crs").get<std::string>();
  if (value.contains("unit")) manifest.unit = value.at("unit").get<std::string>();
  manifest.partition_kind = value.at("partition").at("kind").get<std::string>();
  for (const auto& box : value.at("partition").at("boxes")) manifest.boxes.push_back(to_corners<Box>(box));
  manifest.partition = partition_text(value.at("partition"), manifest);
  manifest.bounds = to_corners<Bounds>(value.at("bounds"));
  if (value.contains("region")) {
    const auto& region = value.at("region");
    manifest.region = {to_corners<Box>(region), region.at("complete").get<bool>()};
  }
  manifest.neighbors = value.at("neighbors").get<bool>();
  for (const auto& attribute : value.at("attributes")) {
    manifest.schema.push_back({to_name(attribute), to_type(attribute)});
    if (attribute.contains("unit")) manifest.schema.back().unit = attribute.at("unit").get<std::string>();
  }
  read_versions(value, manifest);
  for (const auto& entry : value.at("tiles")) {
    manifest.tiles.push_back(to_entry(entry));
    if (manifest.tiles.back().version > manifest.version)
      throw json::other_error::create(501, "a tile's file is of a later version than the result", &value);
  }
  for (std::size_t i = 1; i < manifest.tiles.size(); ++i)
    if (manifest.tiles[i - 1].tile >= manifest.tiles[i].tile)
      throw json::other_error::create(501, "the tiles are not in ascending order", &value);
  const auto& counts = value.at("counts");
  manifest.points_read = to_count(counts.at("points_read"));
  manifest.invalid = to_count(counts.at("invalid"));
  manifest.filtered = to_count(counts.at("filtered"));
  manifest.duplicates = to_count(counts.at("duplicates"));
  manifest.vertices = to_count(counts.at("vertices"));
  manifest.cells = to_count(counts.at("cells"));
  if (counts.contains("other_heights")) manifest.other_heights = to_count(counts.at("other_heights"));
  if (value.contains("keep")) manifest.keep = to_kept_point(value.at("keep"));
  manifest.digest = to_digest(value);
  manifest.master_xxh3 = to_sum(value.at("checksums").at(master_key));
  read_duplicates_sums(value.at("checksums"), manifest);
  manifest.seconds = value.at("seconds").get<std::map<std::string, double>>();
  manifest.figures = value.at("figures").get<std::map<std::string, double>>();
  return manifest;
}

}  // namespace

std::string manifest_to_text(const Manifest& manifest) {
  ordered_json value;
  value["format"] = "tessera";
  value["format_version"] = manifest.format_version;
  write_versions(manifest, value);
  value["software_version"] = manifest.software_version;
  value["command"] = manifest.command;
  value["inputs"] = json::array();
  for (const auto& input : manifest.inputs) value["inputs"].push_back(input_to_json(input));
  value["dimension"] = manifest.dimension;
  value["crs"] = manifest.crs;
  if (!manifest.unit.empty()) value["unit"] = manifest.unit;
  value["bounds"] = corners(manifest.bounds);
  if (manifest.region) {
    value["region"] = corners(manifest.region->box);
    value["region"]["complete"] = manifest.region->complete;
  }
  value["neighbors"] = manifest.neighbors;
  value["attributes"] = json::array();
  for (const auto& attribute : manifest.schema) {
    value["attributes"].push_back({{"name", attribute.name}, {"type", name_of(attribute.type)}});
    if (!attribute.unit.empty()) value["attributes"].back()["unit"] = attribute.unit;
  }
  value["counts"] = {{"points_read", manifest.points_read}, {"invalid", manifest.invalid},
                     {"filtered", manifest.filtered},       {"duplicates", manifest.duplicates},
                     {"vertices", manifest.vertices},       {"cells", manifest.cells}};
  if (manifest.other_heights) value["counts"]["other_heights"] = *manifest.other_heights;
  if (manifest.keep != DuplicatePolicy::first) value["keep"] = name_of(manifest.keep);
  if (manifest.digest) value[digest_key] = digest_text(*manifest.digest);
  value["checksums"][master_key] = checksum_text(manifest.master_xxh3);
  if (manifest.duplicates_xxh3 != 0)
    value["checksums"][duplicates_of("", manifest).string()] = checksum_text(manifest.duplicates_xxh3);
  if (manifest.duplicate_rows_xxh3 != 0)
    value["checksums"][duplicate_rows_of("", manifest).string()] = checksum_text(manifest.duplicate_rows_xxh3);
  value["seconds"] = json(manifest.seconds);
  value["figures"] = json(manifest.figures);
  // A path may be any bytes; bytes that are not UTF-8 become U+FFFD instead of an exception.
  const auto text = [](const ordered_json& part, int indent) { return json_text(part, indent); };
  // Each box and each tile gets a line of its own, even when there are thousands.
  const auto lines = [&](const auto& list, const std::string& indent, const auto& to_json) {
    std::string result = "[";
    for (const auto& element : list)
      result += (result.size() == 1 ? "\n  " : ",\n  ") + indent + text(to_json(element), -1);
    return result + "\n" + indent + "]";
  };
  std::string result = text(value, 2);
  result.erase(result.rfind('\n'));  // the closing brace: two members follow
  result += ",\n  \"partition\": {\n    \"kind\": " + text(manifest.partition_kind, -1);
  if (!manifest.partition.empty()) {
    const json partition = parse_json(manifest.partition);
    result += ",\n    \"dimension\": " + json_text(partition.at("dimension")) +
              ",\n    \"tiles\": " + json_text(partition.at("tiles"));
    if (partition.contains("split_above"))
      result += ",\n    \"split_above\": " + json_text(partition.at("split_above"));
    if (partition.contains("period")) result += ",\n    \"period\": " + json_text(partition.at("period"));
    result += ",\n    \"splits\": ";
    result += lines(partition.at("splits"), "    ", [](const ordered_json& split) { return split; });
  }
  result += ",\n    \"boxes\": ";
  result += lines(manifest.boxes, "    ", [](const Box& box) { return corners(box); }) + "\n  },\n  \"tiles\": ";
  result += lines(manifest.tiles, "  ", [](const TileEntry& entry) { return entry_to_json(entry); }) + "\n}\n";
  return result;
}

}  // namespace store

Period period_of(const Manifest& manifest) {
  Period period;
  if (!is_periodic(manifest)) return period;
  const json partition = parse_json(manifest.partition);
  for (std::size_t axis = 0; axis < period.length.size(); ++axis)
    period.length[axis] = partition.at("period").at(axis).get<double>();
  return period;
}

std::optional<HeightRange> heights_of(const Manifest& manifest) {
  std::optional<HeightRange> all;
  for (const TileEntry& tile : manifest.tiles) {
    if (!tile.heights) continue;
    if (!all) all = tile.heights;
    all = HeightRange{std::min(all->lo, tile.heights->lo), std::max(all->hi, tile.heights->hi)};
  }
  return all;
}

Error no_manifest(const fs::path& out) {
  return error(Errc::io, out.string() + ": holds no manifest.json, so it is not a result, or it is an unfinished run");
}

Result<Manifest> read_manifest(const fs::path& out) {
  const auto path = manifest_file(out);
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return no_manifest(out);
  BOOST_OUTCOME_TRY(bytes, read_whole(path));
  return parse_manifest(path, bytes);
}

Result<Manifest> parse_manifest(const fs::path& path, std::span<const std::byte> bytes) {
  const auto corrupt = [&](const std::string& reason) { return error(Errc::corrupt, path.string() + ": " + reason); };
  const char* text = reinterpret_cast<const char*>(bytes.data());
  const json value = parse_json({text, bytes.size()});
  if (value.is_discarded() || !value.is_object() || value.value("format", json()) != json("tessera"))
    return corrupt("is damaged, or not a manifest of tessera");
  const json version = value.value("format_version", json());
  if (!version.is_number_unsigned()) return corrupt("has no format version");
  if (version.get<std::uint64_t>() > periodic_format)
    return corrupt("is of format version " + json_text(version) + ", but this program knows version " +
                   std::to_string(periodic_format) + " and older: use a newer tessera");
  if (version.get<std::uint64_t>() < oldest_format)
    return corrupt(
        "is of format version " + json_text(version) +
        ", which this program no longer reads: use the tessera that wrote it (software_version in this file) to "
        "export it, or triangulate again; the file names inputs and command");
  try {
    return store::to_manifest(value);
  } catch (const json::exception& wrong) {  // a missing key or a wrong type
    return corrupt(std::string("is damaged: ") + wrong.what());
  }
}

}  // namespace tessera
