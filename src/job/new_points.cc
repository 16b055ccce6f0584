#include "src/job/new_points.h"

#include <cstdint>

#include "src/job/report/human.h"

namespace tessera {
namespace {

std::string text_of(const std::vector<Attribute>& schema) {
  std::string text;
  for (const Attribute& attribute : schema) text += (text.empty() ? "" : ", ") + attribute.name;
  return text.empty() ? "none" : text;
}

Status check_limits(std::uint64_t points, std::uint64_t bytes, const std::string& name, const NewPointsLimits& limits) {
  if (points > limits.points)
    return error(Errc::memory,
                 name + ": more than " + grouped(limits.points) +
                     " points, the most that are allowed here, cannot be added at once; add the files one "
                     "after the other");
  if (bytes > limits.bytes)
    return error(Errc::memory, name + ": the new points take more than " + human_bytes(limits.bytes) +
                                   " of memory, the most that is allowed here; add the files one after the other");
  return success();
}

}  // namespace

CloudOptions options_of_new_points(const Manifest& result, unsigned threads) {
  CloudOptions options{.dimension = result.dimension, .heights = false, .threads = threads};
  for (const Attribute& attribute : result.schema) {
    if (result.dimension == 2 && attribute.name == "z") {
      options.heights = true;
    } else {
      options.attributes.push_back(attribute.name);
    }
  }
  return options;
}

Result<NewPoints> read_new_points(const Cloud& cloud, const std::string& name, const Manifest& result,
                                  const std::filesystem::path& folder, const std::stop_token& stop,
                                  const NewPointsLimits& limits) {
  if (cloud.schema() != result.schema)
    return error(Errc::usage, name + ": the new points have other attributes (" + text_of(cloud.schema()) + ") than " +
                                  folder.string() + " (" + text_of(result.schema) + "), or attributes of other types");
  if (!cloud.crs().empty() && !result.crs.empty() && cloud.crs() != result.crs)
    return error(Errc::usage, name + ": the new points have another coordinate system than " + folder.string());
  NewPoints made;
  const auto take = [&](CloudBatch& batch) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while new points were read");
    for (const LocalPoint& p : batch.points) made.points.push_back(p.at);
    made.rows.insert(made.rows.end(), batch.rows.begin(), batch.rows.end());
    return check_limits(made.points.size(), made.points.size() * sizeof(Point) + made.rows.size(), name, limits);
  };
  std::vector<std::uint64_t> points;
  BOOST_OUTCOME_TRYV(cloud.for_each_batch(cloud.whole(), take, &points));
  std::uint64_t first = 0;
  for (std::size_t i = 0; i < points.size(); first += points[i++]) {
    const FileInfo& file = cloud.files()[i];
    made.inputs.push_back({file.path.string(), file.bytes, file.modified_ns, Manifest::Input::Ids{first, points[i]}});
  }
  return made;
}

}  // namespace tessera
