// Reads many points from the body of a question: JSON, protobuf, text, NumPy's format, and no other.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/input/cloud/cloud.h"
#include "src/input/format.h"
#include "src/job/report/human.h"
#include "src/service/questions/answer_messages.h"
#include "src/service/questions/answering.h"
#include "src/service/json.h"

namespace tessera {

Result<std::vector<Point>> Answering::points() const {
  if (question_.type == "application/json") return points_in_json();
  if (question_.type == protobuf_type) return points_of(*question_.body, dimension_);
  if (question_.type == "text/csv") return points_in_file(".csv");
  return points_in_file(".npy");
}

Result<std::vector<Point>> Answering::points_in_json() const {
  const auto bad = [](const std::string& what) { return error(Errc::bad_input, "the body: " + what); };
  if (nested_too_deep(*question_.body)) return bad("lists are nested too deep for points");
  const auto document = parse_json(*question_.body);
  if (document.is_discarded()) return bad("is not JSON");
  const auto list = document.is_object() ? document.find("points") : document.end();
  if (!document.is_object() || list == document.end() || !list->is_array() || list->empty())
    return bad("must be an object with a list 'points', that is not empty");
  std::vector<Point> points;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const auto& numbers = (*list)[i];
    const std::string place = "points[" + std::to_string(i) + "]";
    if (!numbers.is_array() || numbers.size() < static_cast<std::size_t>(dimension_) || numbers.size() > 3)
      return bad(place + ": must be a list of " + std::to_string(dimension_) + " numbers");
    Point p;
    for (std::size_t axis = 0; axis < numbers.size(); ++axis) {
      if (!numbers[axis].is_number()) return bad(place + ": has what is no number");
      if (static_cast<int>(axis) < dimension_) p[static_cast<int>(axis)] = numbers[axis].get<double>();
    }
    points.push_back(without_negative_zero(p));
  }
  return points;
}

// As the command reads such a file, so that each format has one reader.
Result<std::vector<Point>> Answering::points_in_file(const std::string& ending) const {
  // If the content decided, a body could have any file format, and callers would reach the readers of all formats.
  const auto bytes = std::as_bytes(std::span(*question_.body));
  const auto wanted = ending == ".npy" ? FileFormat::npy : FileFormat::text;
  if (format_of(bytes.first(std::min(bytes.size(), format_bytes)), "body" + ending, bytes.size()) != wanted)
    return error(Errc::bad_input, std::string("the body: is not ") + (ending == ".npy" ? "NumPy's format" : "text"));
  const auto path = asked_points_file(folder_, ending);
  BOOST_OUTCOME_TRYV(write_whole(path, *question_.body));
  const auto read = [&]() -> Result<std::vector<Point>> {
    BOOST_OUTCOME_TRY(cloud, Cloud::open({path.string()}, {.dimension = dimension_, .heights = false}, ask_.stop));
    std::vector<Point> points;
    BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
      if (points.size() + batch.points.size() > limits_.points)
        return error(Errc::memory, path.string() + ": holds more than " + grouped(limits_.points) + " points");
      for (const auto& p : batch.points) points.push_back(p.at);
      return success();
    }));
    if (counts.read == 0) return error(Errc::bad_input, path.string() + ": holds no points");
    return points;
  };
  auto points = read();
  if (points) return points;
  std::string said = points.error().where;
  if (const auto at = said.find(path.string()); at != std::string::npos)
    said.replace(at, path.string().size(), "the body");
  return error(points.error().code, said);
}

}  // namespace tessera
