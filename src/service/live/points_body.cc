#include "src/service/live/points_body.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>
#include <utility>

#include "query.pb.h"
#include "src/base/json/json_text.h"
#include "src/input/cloud/cloud.h"
#include "src/input/npy/npy_header.h"
#include "src/job/new_points.h"
#include "src/service/json.h"

namespace tessera::service {
namespace {

constexpr const char* the_body = "the body";
constexpr const char* body_json = "application/json";

Error bad_body(const std::string& what) { return error(Errc::bad_input, std::string(the_body) + ": " + what); }

// The body as a file of which nothing is on a disk.
class BodySource final : public ByteSource {
 public:
  explicit BodySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  const std::filesystem::path& path() const override { return name_; }
  std::uint64_t size() const override { return bytes_.size(); }
  std::int64_t modified_ns() const override { return 0; }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset) return bad_body("ends too early");
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return success();
  }
  Status check_unchanged() const override { return success(); }

 private:
  std::filesystem::path name_ = the_body;
  std::span<const std::byte> bytes_;
};

// What was sent, by columns: x, y and z, and attributes by their names.
struct SentColumns {
  std::vector<double> x, y, z;
  std::map<std::string, std::vector<double>> attributes;
};

// Returns false for a number that the type does not have.
template <class Type>
bool put_as(double number, std::byte* to) {
  if constexpr (std::is_integral_v<Type>) {
    // The upper bound itself may be no double, but the next number after it is one.
    const double end = std::ldexp(1.0, std::numeric_limits<Type>::digits);
    if (!(number >= static_cast<double>(std::numeric_limits<Type>::min()) && number < end)) return false;
    if (std::trunc(number) != number) return false;
  }
  if constexpr (std::is_same_v<Type, float>) {
    if (std::isfinite(number) && std::abs(number) > std::numeric_limits<float>::max()) return false;
  }
  const auto value = static_cast<Type>(number);
  std::memcpy(to, &value, sizeof value);
  return true;
}

bool put_number(AttributeType type, double number, std::byte* to) {
  switch (type) {
    case AttributeType::u8:
      return put_as<std::uint8_t>(number, to);
    case AttributeType::i8:
      return put_as<std::int8_t>(number, to);
    case AttributeType::u16:
      return put_as<std::uint16_t>(number, to);
    case AttributeType::i16:
      return put_as<std::int16_t>(number, to);
    case AttributeType::u32:
      return put_as<std::uint32_t>(number, to);
    case AttributeType::i32:
      return put_as<std::int32_t>(number, to);
    case AttributeType::u64:
      return put_as<std::uint64_t>(number, to);
    case AttributeType::i64:
      return put_as<std::int64_t>(number, to);
    case AttributeType::f32:
      return put_as<float>(number, to);
    case AttributeType::f64:
      return put_as<double>(number, to);
  }
  return false;
}

// Whether z is the attribute "z" of a result in the plane.
bool is_height(const Manifest& result, const Attribute& attribute) {
  return result.dimension == 2 && attribute.name == "z";
}

std::string known_attributes(const Manifest& result) {
  std::string text;
  for (const Attribute& attribute : result.schema)
    if (!is_height(result, attribute)) text += (text.empty() ? "" : ", ") + attribute.name;
  return text.empty() ? "none" : text;
}

Status check_sent_columns(const SentColumns& sent, const Manifest& result, bool heights) {
  if (sent.x.empty()) return bad_body("has no points");
  const auto wrong = [&](const std::vector<double>& list, const std::string& name) {
    return bad_body("has " + std::to_string(sent.x.size()) + " values of x, but " + std::to_string(list.size()) +
                    " of " + name);
  };
  if (sent.y.size() != sent.x.size()) return wrong(sent.y, "y");
  const bool needs_z = result.dimension == 3 || heights;
  if (needs_z && sent.z.size() != sent.x.size()) return wrong(sent.z, "z");
  if (!needs_z && !sent.z.empty())
    return bad_body("has values of z, but the result is a triangulation in the plane without heights");
  for (const auto& [name, values] : sent.attributes) {
    const bool known = std::any_of(result.schema.begin(), result.schema.end(), [&, &sought = name](const Attribute& a) {
      return a.name == sought && !is_height(result, a);
    });
    if (!known)
      return error(Errc::usage, std::string(the_body) + ": the result has no attribute '" + name +
                                    "'; its attributes are: " + known_attributes(result));
    if (values.size() != sent.x.size()) return wrong(values, "'" + name + "'");
  }
  return success();
}

Result<ResultChange> change_of(const SentColumns& sent, const Manifest& result) {
  const bool heights = std::any_of(result.schema.begin(), result.schema.end(),
                                   [&](const Attribute& attribute) { return is_height(result, attribute); });
  BOOST_OUTCOME_TRYV(check_sent_columns(sent, result, heights));
  ResultChange change;
  change.add.resize(sent.x.size());
  for (std::size_t i = 0; i < sent.x.size(); ++i) {
    change.add[i] = {sent.x[i], sent.y[i], result.dimension == 3 ? sent.z[i] : 0};
    if (heights && !std::isfinite(sent.z[i]))
      return bad_body("the height of point " + std::to_string(i) + " is not finite");
  }
  const std::size_t width = row_bytes(result.schema);
  change.rows.resize(width * change.add.size());
  std::size_t at = 0;
  for (const Attribute& attribute : result.schema) {
    const auto found = sent.attributes.find(attribute.name);
    if (!is_height(result, attribute) && found == sent.attributes.end())
      return error(Errc::usage, std::string(the_body) + ": the points have no attribute '" + attribute.name +
                                    "'; the result has the attributes: " + known_attributes(result));
    const std::vector<double>& values = is_height(result, attribute) ? sent.z : found->second;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!put_number(attribute.type, values[i], &change.rows[i * width + at]))
        return bad_body("'" + attribute.name + "' of point " + std::to_string(i) +
                        " is no number of the type that the result has");
    at += size_of(attribute.type);
  }
  return change;
}

Result<nlohmann::json> json_body(const std::string& bytes) {
  if (nested_too_deep(bytes)) return bad_body("lists are nested too deep");
  auto document = parse_json(bytes);
  if (document.is_discarded()) return bad_body("is not JSON");
  if (!document.is_object()) return bad_body("must be a JSON object");
  return document;
}

Result<std::vector<double>> numbers_in(const nlohmann::json& list, const std::string& place) {
  if (!list.is_array()) return bad_body(place + ": must be a list of numbers");
  std::vector<double> numbers;
  for (const auto& number : list) {
    if (!number.is_number()) return bad_body(place + ": has an entry that is not a number");
    // A double does not have all integers, and a wrong attribute is worse than none.
    constexpr std::int64_t exact = std::int64_t{1} << 53;
    if (number.is_number_integer() && !number.is_number_unsigned() &&
        (number.get<std::int64_t>() > exact || number.get<std::int64_t>() < -exact))
      return bad_body(place + ": has an integer beyond 2^53; send a NumPy file");
    if (number.is_number_unsigned() && number.get<std::uint64_t>() > static_cast<std::uint64_t>(exact))
      return bad_body(place + ": has an integer beyond 2^53; send a NumPy file");
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

Result<SentColumns> columns_in_json(const std::string& bytes) {
  BOOST_OUTCOME_TRY(document, json_body(bytes));
  SentColumns sent;
  for (const auto& [key, value] : document.items()) {
    if (key != "points" && key != "attributes")
      return bad_body("'" + key + "' is not known; there are points, attributes");
    if (key == "attributes") {
      if (!value.is_object()) return bad_body("attributes: must be an object with a list for each name");
      for (const auto& [name, list] : value.items()) {
        BOOST_OUTCOME_TRY(numbers, numbers_in(list, "attributes." + name));
        sent.attributes[name] = std::move(numbers);
      }
      continue;
    }
    if (!value.is_array()) return bad_body("points: must be a list of points");
    std::size_t place = 0, coordinates = 0;
    for (const auto& point : value) {
      const std::string name = "points[" + std::to_string(place++) + "]";
      BOOST_OUTCOME_TRY(numbers, numbers_in(point, name));
      if (numbers.size() < 2 || numbers.size() > 3) return bad_body(name + ": must be a list of 2 or 3 numbers");
      if (place == 1) coordinates = numbers.size();
      if (numbers.size() != coordinates)
        return bad_body(name + ": has another number of coordinates than the points before");
      sent.x.push_back(numbers[0]);
      sent.y.push_back(numbers[1]);
      if (coordinates == 3) sent.z.push_back(numbers[2]);
    }
  }
  return sent;
}

Result<SentColumns> columns_in_message(const std::string& bytes) {
  proto::NewPoints message;
  if (!message.ParseFromString(bytes)) return bad_body("is not a protobuf message tessera.proto.NewPoints");
  SentColumns sent;
  sent.x.assign(message.x().begin(), message.x().end());
  sent.y.assign(message.y().begin(), message.y().end());
  sent.z.assign(message.z().begin(), message.z().end());
  for (const proto::Values& values : message.attributes()) {
    const bool first =
        sent.attributes.emplace(values.name(), std::vector<double>(values.values().begin(), values.values().end()))
            .second;
    if (!first) return bad_body("has the attribute '" + values.name() + "' twice");
  }
  return sent;
}

Result<ResultChange> points_in_npy(const std::string& bytes, const Manifest& result) {
  CloudOptions options = options_of_new_points(result, 1);
  BOOST_OUTCOME_TRY(cloud, Cloud::open_source(std::make_shared<BodySource>(std::as_bytes(std::span(bytes))), options));
  BOOST_OUTCOME_TRY(read, read_new_points(cloud, the_body, result, "the result", {}));
  if (read.points.empty()) return bad_body("has no points");
  return ResultChange{.add = std::move(read.points), .rows = std::move(read.rows)};
}

bool is_npy(const std::string& bytes) { return bytes.starts_with("\x93NUMPY"); }

}  // namespace

Result<ResultChange> read_points_body(const PointsBody& body, const Manifest& result) {
  if (body.type == "application/x-npy") {
    // The content must not decide: otherwise callers would reach the readers of all formats.
    if (!is_npy(body.bytes)) return bad_body("is not a NumPy file");
    return points_in_npy(body.bytes, result);
  }
  BOOST_OUTCOME_TRY(sent, body.type == body_json ? columns_in_json(body.bytes) : columns_in_message(body.bytes));
  return change_of(sent, result);
}

Result<std::vector<PointId>> read_ids_body(const PointsBody& body) {
  std::vector<PointId> ids;
  if (body.type == "application/x-npy") {
    if (!is_npy(body.bytes)) return bad_body("is not a NumPy file");
    BOOST_OUTCOME_TRY(numbers, read_npy_integers(BodySource(std::as_bytes(std::span(body.bytes)))));
    for (const std::uint64_t number : numbers) ids.push_back(PointId{number});
  } else if (body.type == body_json) {
    BOOST_OUTCOME_TRY(document, json_body(body.bytes));
    const auto list = document.find("ids");
    if (document.size() != 1 || list == document.end() || !list->is_array())
      return bad_body("must be a JSON object with a list 'ids', and nothing else");
    for (const auto& id : *list) {
      if (!id.is_number_unsigned()) return bad_body("ids: has an entry that is no source index, a whole number");
      ids.push_back(PointId{id.get<std::uint64_t>()});
    }
  } else {
    proto::PointIds message;
    if (!message.ParseFromString(body.bytes)) return bad_body("is not a protobuf message tessera.proto.PointIds");
    for (const std::uint64_t id : message.ids()) ids.push_back(PointId{id});
  }
  if (ids.empty()) return bad_body("has no source indices");
  return ids;
}

}  // namespace tessera::service
