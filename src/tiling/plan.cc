#include "src/tiling/plan.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/disk_file.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/tiling/json_read.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int format_version = 4;
constexpr std::uint64_t plan_bytes_max = std::uint64_t{1} << 30;  // 1000 bytes for each of 2^20 tiles
constexpr std::array<const char*, 10> type_names{"u8", "i8", "u16", "i16", "u32", "i32", "u64", "i64", "f32", "f64"};

json to_json(const Point& p) { return json::array({p.x, p.y, p.z}); }

json to_json(const Bounds& b) {
  if (b.empty()) return nullptr;
  return json::array({to_json(b.lo), to_json(b.hi)});
}

bool read_bounds(const json& from, Bounds& b) {
  b = {};
  if (from.is_null()) return true;
  if (!from.is_array() || from.size() != 2 || !read_point(from[0], b.lo) || !read_point(from[1], b.hi)) return false;
  return b.lo.x <= b.hi.x && b.lo.y <= b.hi.y && b.lo.z <= b.hi.z;
}

bool read_sum(const json& from, std::uint64_t& value) {
  std::string text;
  if (!read_string(from, text) || text.size() != 16) return false;
  const auto end = text.data() + text.size();
  return std::from_chars(text.data(), end, value, 16).ptr == end && text == checksum_text(value);
}

// The file begins with {"xxh3":"0123456789abcdef",
constexpr std::string_view seal_begin = "{\"xxh3\":\"";
constexpr std::string_view seal_end = "\",\n";
constexpr std::size_t seal_bytes = seal_begin.size() + 16 + seal_end.size();

std::uint64_t seal_of(std::string_view text) { return checksum(std::as_bytes(std::span(text.substr(seal_bytes)))); }

Result<std::uint64_t> check_seal(const std::filesystem::path& path, std::string_view text) {
  if (!text.starts_with(seal_begin) || text.size() < seal_bytes ||
      text.substr(seal_bytes - seal_end.size(), seal_end.size()) != seal_end)
    return damaged_run(path, "is damaged, or of an older version: it does not begin with its checksum");
  const std::uint64_t sum = seal_of(text);
  if (text.substr(seal_begin.size(), 16) != checksum_text(sum))
    return damaged_run(path, "is damaged: its checksum is " + checksum_text(sum) + ", but the file says " +
                                 in_quotes(text.substr(seal_begin.size(), 16)));
  return sum;
}

// Reads plan.json field by field. The first field that is wrong makes the error.
class PlanReader {
 public:
  PlanReader(std::filesystem::path path, const json& root) : path_(std::move(path)), root_(root) {}

  Result<RoutedCloud> read(const std::filesystem::path& folder) {
    BOOST_OUTCOME_TRYV(read_header());
    run_.folder = folder;
    BOOST_OUTCOME_TRYV(read_tiles());
    BOOST_OUTCOME_TRYV(read_bundles());
    BOOST_OUTCOME_TRYV(read_seeds());
    BOOST_OUTCOME_TRYV(read_source());
    return std::move(run_);
  }
  std::uint64_t segments_sum() const { return segments_sum_; }

 private:
  Error bad(const std::string& what) const { return damaged_run(path_, what); }

  // Returns null when the member is missing; no reading function accepts null for a value that it needs.
  const json& at(const json& object, const char* key) const {
    static const json none;
    if (!object.is_object()) return none;
    const auto found = object.find(key);
    return found == object.end() ? none : *found;
  }

  Status read_header() {
    if (!root_.is_object()) return bad("is not a JSON object");
    std::int64_t version = 0;
    if (!read_integer(at(root_, "version"), 1, INT64_MAX, version)) return bad("has no version");
    if (version != format_version) {
      return bad("has version " + std::to_string(version) + "; this program reads version " +
                 std::to_string(format_version));
    }
    return success();
  }

  Status read_tiles() {
    auto partition = Partition::from_json(json_text(at(root_, "partition")));
    if (!partition) return bad(partition.error().where);
    run_.partition = std::move(partition).value();
    run_.dimension = run_.partition.dimension();
    const json& counts = at(root_, "counts");
    if (!read_unsigned(at(counts, "read"), run_.counts.read) ||
        !read_unsigned(at(counts, "invalid"), run_.counts.invalid) ||
        !read_unsigned(at(counts, "filtered"), run_.counts.filtered)) {
      return bad("counts are not three numbers");
    }
    if (run_.partition.period().any() &&
        (!read_unsigned(at(counts, "moved"), run_.counts.moved) || run_.counts.moved > run_.counts.read ||
         !read_finite(at(counts, "snapped"), run_.counts.snapped) || run_.counts.snapped < 0)) {
      return bad("counts do not say how points were moved into the periodic box");
    }
    const json& tiles = at(root_, "tiles");
    if (!tiles.is_array() || tiles.size() != run_.partition.tiles()) return bad("does not list every tile once");
    std::uint64_t sum = 0;
    for (const json& tile : tiles) {
      std::uint64_t points = 0;
      Bounds bounds;
      const std::string name = "tile " + std::to_string(run_.tile_points.size());
      if (!read_unsigned(at(tile, "points"), points) || points > run_.counts.read - sum) {
        return bad(name + " has an impossible number of points");
      }
      if (!read_bounds(at(tile, "bounds"), bounds) || bounds.empty() != (points == 0)) {
        return bad(name + " has impossible bounds");
      }
      sum += points;
      run_.tile_points.push_back(points);
      run_.tile_bounds.push_back(bounds);
      run_.bounds.add(bounds);
    }
    const CloudCounts& c = run_.counts;
    if (c.invalid > c.read || c.filtered > c.read - c.invalid || sum != c.read - c.invalid - c.filtered) {
      return bad("the numbers of points of the tiles do not add up to the number of points that were read");
    }
    return success();
  }

  Status read_bundles() {
    const json& bundles = at(root_, "bundles");
    if (!bundles.is_array() || !read_sum(at(root_, "segments_xxh3"), segments_sum_))
      return bad("does not say in which files the points of the tiles are");
    for (const json& from : bundles) {
      std::uint64_t attempt = 0, number = 0;
      ShuffleFile bundle;
      if (!read_unsigned(at(from, "attempt"), attempt) || attempt > UINT32_MAX ||
          !read_unsigned(at(from, "number"), number) || number > UINT32_MAX ||
          !read_unsigned(at(from, "first_id"), bundle.first_id) || bundle.first_id > run_.counts.read ||
          !read_unsigned(at(from, "points"), bundle.points) || bundle.points > run_.counts.read) {
        return bad("file of points " + std::to_string(run_.bundles.size()) + " has impossible numbers");
      }
      bundle.id = {static_cast<std::uint32_t>(attempt), static_cast<std::uint32_t>(number)};
      run_.bundles.push_back(bundle);
    }
    return success();
  }

  Status read_seeds() {
    const json& seeds = at(root_, "seeds");
    if (!seeds.is_array() || seeds.size() > run_.counts.read) return bad("has an impossible list of seeds");
    std::size_t everywhere = 0;
    for (const json& from : seeds) {
      Seed seed;
      const json& reach = at(from, "reach");
      if (!read_unsigned(at(from, "id"), seed.point.id.value) || seed.point.id.value >= run_.counts.read ||
          !read_point(at(from, "at"), seed.point.at)) {
        return bad("a seed is not a point of the cloud");
      }
      if (reach.is_null()) {
        seed.reach = std::numeric_limits<double>::infinity();
        ++everywhere;
      } else if (reach.is_number() && reach.get<double>() >= 0) {
        seed.reach = reach.get<double>();
      } else {
        return bad("a seed has no valid reach");
      }
      seed.point.tile = run_.partition.tile_of(seed.point.at);
      run_.seeds.push_back(seed);
    }
    if (everywhere <= static_cast<std::size_t>(run_.partition.period().open_axes(run_.dimension)))
      return bad("has too few seeds that all tiles know");
    return success();
  }

  Status read_source() {
    const json& schema = at(root_, "schema");
    if (!schema.is_array()) return bad("schema is not a list");
    for (const json& from : schema) {
      Attribute a;
      std::string type;
      if (!read_string(at(from, "name"), a.name) || !read_string(at(from, "type"), type)) {
        return bad("an attribute has no name or type");
      }
      const auto found = std::find(type_names.begin(), type_names.end(), type);
      if (found == type_names.end()) return bad("attribute " + a.name + " has an unknown type");
      a.type = static_cast<AttributeType>(found - type_names.begin());
      if (from.contains("unit") && !read_string(at(from, "unit"), a.unit)) return bad("a unit is not text");
      run_.schema.push_back(std::move(a));
    }
    const json& inputs = at(root_, "inputs");
    if (!inputs.is_array()) return bad("inputs is not a list");
    for (const json& from : inputs) {
      InputFile input;
      std::int64_t modified = 0;
      if (!read_string(at(from, "path"), input.path) || !read_unsigned(at(from, "bytes"), input.bytes) ||
          !read_integer(at(from, "modified_ns"), INT64_MIN, INT64_MAX, modified)) {
        return bad("an input has no path, size or time");
      }
      input.modified_ns = modified;
      if (const json& points = at(from, "points"); !points.is_null()) {
        if (!read_unsigned(points, input.points.emplace()) || *input.points > run_.counts.read)
          return bad("an input has an impossible number of points");
      }
      run_.inputs.push_back(std::move(input));
    }
    std::string keep(name_of(run_.keep));
    // plans that keep the first point do not have it
    const bool read = !root_.contains("keep") || read_string(at(root_, "keep"), keep);
    if (!read || !kept_point_of(keep)) return bad("keep is not a known choice");
    run_.keep = *kept_point_of(keep);
    if (root_.contains("unit") && !read_string(at(root_, "unit"), run_.unit)) return bad("the unit is not text");
    if (!read_string(at(root_, "crs"), run_.crs) || !read_string(at(root_, "options_key"), run_.options_key)) {
      return bad("crs or options_key is not text");
    }
    return success();
  }

  std::filesystem::path path_;
  const json& root_;
  RoutedCloud run_;
  std::uint64_t segments_sum_ = 0;
};

// Reads the segments, and checks that they belong to these tiles and shuffle files.
Status read_segments(RoutedCloud& run, std::uint64_t written) {
  const auto path = segments_file(run.folder);
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  BOOST_OUTCOME_TRY(bytes, file.size());
  if (bytes % sizeof(Segment) != 0) return damaged_run(path, "ends within a segment");
  run.segments.resize(bytes / sizeof(Segment));
  BOOST_OUTCOME_TRY(got, file.read(std::as_writable_bytes(std::span(run.segments))));
  const auto sum = checksum(std::as_bytes(std::span(run.segments)));
  if (got != bytes || sum != written)
    return damaged_run(
        path, "is damaged: its checksum is " + checksum_text(sum) + ", but " + checksum_text(written) + " was written");
  std::uint64_t end = 0;
  for (std::size_t t = 0; t < run.tile_points.size(); ++t) {
    std::uint64_t points = 0;
    for (; points < run.tile_points[t] && end < run.segments.size(); ++end) {
      const Segment& s = run.segments[end];
      if (s.bundle >= run.bundles.size() || s.count == 0 || s.begin > run.bundles[s.bundle].points ||
          s.count > run.bundles[s.bundle].points - s.begin) {
        return damaged_run(path, "segment " + std::to_string(end) + " lies in no file of points");
      }
      points += s.count;
    }
    if (points != run.tile_points[t])
      return damaged_run(path, "tile " + std::to_string(t) + " has another number of points than the plan says");
    run.segment_end.push_back(end);
  }
  return end == run.segments.size() ? success() : Status(damaged_run(path, "has segments that belong to no tile"));
}

Status check_size(const std::filesystem::path& path, std::uint64_t records, std::size_t record_bytes) {
  BOOST_OUTCOME_TRY(bytes, file_bytes(path));
  // Divided, not multiplied, as the number comes from a file and might overflow.
  if (bytes % record_bytes == 0 && bytes / record_bytes == records) return success();
  return damaged_run(path, "has " + std::to_string(bytes) + " bytes, but " + std::to_string(records) + " records of " +
                               std::to_string(record_bytes) + " bytes were written");
}

}  // namespace

std::string sealed_plan(std::string_view json) {
  const auto rest = json.substr(1);  // without the brace, which the seal has
  std::string text(seal_begin);
  text += checksum_text(checksum(std::as_bytes(std::span(rest))));
  text += seal_end;
  text += rest;
  return text;
}

Result<std::uint64_t> write_plan(const RoutedCloud& run) {
  json tiles = json::array();
  for (std::size_t t = 0; t < run.tile_points.size(); ++t) {
    tiles.push_back({{"points", run.tile_points[t]}, {"bounds", to_json(run.tile_bounds[t])}});
  }
  json bundles = json::array();
  for (const ShuffleFile& b : run.bundles) {
    bundles.push_back(
        {{"attempt", b.id.attempt}, {"number", b.id.number}, {"first_id", b.first_id}, {"points", b.points}});
  }
  const auto segments = std::as_bytes(std::span(run.segments));
  BOOST_OUTCOME_TRYV(write_whole(segments_file(run.folder), segments));
  json seeds = json::array();
  for (const Seed& s : run.seeds) {
    const json reach = std::isinf(s.reach) ? json(nullptr) : json(s.reach);
    seeds.push_back({{"at", to_json(s.point.at)}, {"id", s.point.id.value}, {"reach", reach}});
  }
  json schema = json::array();
  for (const Attribute& a : run.schema) {
    schema.push_back({{"name", a.name}, {"type", type_names[static_cast<std::size_t>(a.type)]}});
    if (!a.unit.empty()) schema.back()["unit"] = a.unit;
  }
  json inputs = json::array();
  for (const InputFile& i : run.inputs) {
    inputs.push_back({{"path", i.path}, {"bytes", i.bytes}, {"modified_ns", i.modified_ns}});
    if (i.points) inputs.back()["points"] = *i.points;
  }
  json plan{{"version", format_version},
            {"partition", parse_json(run.partition.to_json())},
            {"counts", {{"read", run.counts.read}, {"invalid", run.counts.invalid}, {"filtered", run.counts.filtered}}},
            {"tiles", std::move(tiles)},
            {"bundles", std::move(bundles)},
            {"segments_xxh3", checksum_text(checksum(segments))},
            {"seeds", std::move(seeds)},
            {"schema", std::move(schema)},
            {"inputs", std::move(inputs)},
            {"crs", run.crs},
            {"options_key", run.options_key}};
  if (run.partition.period().any()) {
    plan["counts"]["moved"] = run.counts.moved;
    plan["counts"]["snapped"] = run.counts.snapped;
  }
  if (!run.unit.empty()) plan["unit"] = run.unit;
  if (run.keep != DuplicatePolicy::first) plan["keep"] = name_of(run.keep);
  // File names and coordinate systems need not be UTF-8; JSON must be.
  const std::string text = sealed_plan(json_text(plan));
  BOOST_OUTCOME_TRYV(write_whole(plan_file(run.folder), text));
  return seal_of(text);
}

Result<RoutedCloud> open_run(const std::filesystem::path& folder) {
  const auto path = plan_file(folder);
  std::string text;
  {
    BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
    BOOST_OUTCOME_TRY(bytes, file.size());
    if (bytes > plan_bytes_max) return damaged_run(path, "is larger than a plan can be");
    text.resize(bytes);
    BOOST_OUTCOME_TRY(got, file.read(std::as_writable_bytes(std::span(text))));
    text.resize(got);
  }
  BOOST_OUTCOME_TRY(seal, check_seal(path, text));
  const json root = parse_json(text);
  if (root.is_discarded()) return damaged_run(path, "is not JSON");
  PlanReader reader(path, root);
  BOOST_OUTCOME_TRY(run, reader.read(folder));
  run.seal = seal;
  BOOST_OUTCOME_TRYV(read_segments(run, reader.segments_sum()));
  const std::size_t row = row_bytes(run.schema);
  for (const ShuffleFile& bundle : run.bundles) {
    BOOST_OUTCOME_TRYV(check_size(points_file(folder, bundle.id), bundle.points, sizeof(LocalPoint)));
    if (row > 0) {
      BOOST_OUTCOME_TRYV(check_size(attributes_file(folder, bundle.id), bundle.points, row));
    }
  }
  run.checked = std::make_shared<std::vector<TileChecked>>(run.tile_points.size());
  return std::move(run);
}

}  // namespace tessera
