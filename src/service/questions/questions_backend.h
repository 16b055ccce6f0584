// What front ends ask of one result: questions about its triangulation, and its collections for maps.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "src/service/reply.h"

namespace tessera::service {

// A question to a result, with options as text. The service reads options as the commands do.
struct Question {
  enum class About : std::uint8_t {
    locate,
    star,
    neighbours,
    cells,
    interpolate,
    dem,
    hull,
    section,
    solids,
    contours,
    profile,
    features,  // of the collection of kind `kind`: bbox, limit, after; item: only that feature
    map_tile   // level, row, column, style
  };
  About about = About::locate;
  std::string triangulation;
  std::string vertex = {};  // star, neighbours: the source index of the vertex
  // point, cell, tile, bbox, f, limit, value, method, weights, ...; all questions have "version", the number of a
  // version of the result; default: the newest one
  std::map<std::string, std::string> options = {};
  std::optional<std::string> body = {};  // locate, interpolate: many points; cells: a polygon; profile: a line
  std::string type = {};                 // media type of the body
  // Answer with a message of proto/query.proto. REQUIRES: has_message(about), and no option f.
  bool as_message = false;
  std::stop_token stop = {};  // the caller has gone
};

// True if there is a message for the answers. Other answers are files, pictures and GeoJSON.
constexpr bool has_message(Question::About about) {
  using About = Question::About;
  return about == About::locate || about == About::star || about == About::neighbours || about == About::interpolate ||
         about == About::profile;
}
inline constexpr const char* protobuf_type = "application/x-protobuf";

struct QuestionAnswer {
  std::string text = {};                // with the type below; or
  std::optional<ServedFile> file = {};  // a file, which has its own type
  std::string type = {};
  // Of the result, which the whole answer is of; of a live result, the number that the version has in memory.
  std::uint64_t version = 0;
  bool final = true;  // the answer provably holds for the triangulation of all points
  // For features, whose text is a JSON object without its last brace: where the next page begins, if there is one.
  std::optional<std::uint64_t> next = {};
};

// A collection of features that a result offers for maps.
struct FeatureCollection {
  std::string id;             // NAME.kind
  std::string triangulation;  // NAME
  std::string kind;           // tiles, hull, contours
  std::string title = {}, description = {};
  std::array<double, 4> extent{};  // west, south, east, north
  std::string storage_crs = {};    // a URI: features are also offered in the result's system; or empty
};
// The coordinate system of features, unless the client asks for another.
inline constexpr const char* crs84_uri = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";

// Thread-safe.
class QuestionsBackend {
 public:
  virtual ~QuestionsBackend() = default;

  // The identity of this result, which differs from that of any other result that had or will have its name. For one
  // identity, this program always gives the same answers. Empty for a live result, whose answers may change at any
  // moment.
  virtual Reply<std::string> identity(std::string_view name) = 0;
  // Answers a question. May read from disk. 404; 400 for options that make no sense; 422 for invalid points or
  // polygons, and for too large an answer; 410 when the caller or the result has gone meanwhile; 500 for a damaged
  // tile.
  virtual Reply<QuestionAnswer> ask(const Question& question) = 0;

  // The collections for maps of all results with a known place on the earth, by name.
  virtual Reply<std::vector<FeatureCollection>> collections() = 0;
  // Also 404 for a possible name without a collection: the result has no coordinate system or no contour lines.
  virtual Reply<FeatureCollection> collection(std::string_view id) = 0;
  // West, south, east and north of the raster of a result's heights; 404 when it has none.
  virtual Reply<std::array<double, 4>> map_extent(std::string_view name) = 0;
};

}  // namespace tessera::service
