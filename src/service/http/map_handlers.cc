// Results on maps: collections of features (OGC API - Features) and tiles of pictures (OGC API - Tiles).
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/service/http/absolute.h"
#include "src/service/http/handlers.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;
using About = Question::About;

constexpr const char* geojson = "application/geo+json";
constexpr const char* png = "image/png";
constexpr const char* matrix_set = "http://www.opengis.net/def/tilematrixset/OGC/1.0/WebMercatorQuad";

std::string collection_path(const std::string& id) { return "/v1/collections/" + encode_segment(id); }
std::string map_path(const std::string& triangulation) {
  return triangulation_path(triangulation) + "/map/tiles/WebMercatorQuad";
}

ordered_json link(const Call& call, const std::string& path, const char* rel, const char* type,
                  const std::string& title = {}) {
  ordered_json made{{"href", absolute(call.context.links, call.request, path)}, {"rel", rel}, {"type", type}};
  if (!title.empty()) made["title"] = title;
  return made;
}

ordered_json told(const Call& call, const FeatureCollection& collection) {
  const std::string self = collection_path(collection.id);
  ordered_json made{{"id", collection.id},
                    {"title", collection.title},
                    {"description", collection.description},
                    {"itemType", "feature"},
                    {"extent", {{"spatial", {{"bbox", ordered_json::array({collection.extent})}, {"crs", crs84_uri}}}}},
                    {"crs", {crs84_uri}},
                    {"links",
                     {link(call, self, "self", json, "This collection"),
                      link(call, self + "/items", "items", geojson, "Its features"),
                      link(call, triangulation_path(collection.triangulation), "describedby", json, "The result")}}};
  if (!collection.storage_crs.empty()) {
    made["crs"].push_back(collection.storage_crs);
    made["storageCrs"] = collection.storage_crs;
  }
  return made;
}

Answer collections(const Call& call) {
  const auto found = call.context.backend->questions.collections();
  if (!found) return problem(found.error());
  ordered_json list{{"links", {link(call, "/v1/collections", "self", json, "The collections of features, for maps")}},
                    {"collections", ordered_json::array()}};
  for (const FeatureCollection& one : found.value()) list["collections"].push_back(told(call, one));
  return json_answer(200, json_text(list));
}

Answer collection(const Call& call) {
  const auto found = call.context.backend->questions.collection(call.arguments[0]);
  return found ? json_answer(200, json_text(told(call, found.value()))) : problem(found.error());
}

// The features with their links. The features are in the requested coordinate system; other systems were refused.
Answer with_links(const Call& call, QuestionAnswer found, ordered_json links) {
  Answer answer;
  answer.headers = {{"Content-Type", geojson},
                    {"Content-Crs", "<" + std::string(call.request.target.parameter("crs").value_or(crs84_uri)) + ">"},
                    {"Tessera-Final", found.final ? "true" : "false"},
                    // The lines may be drawn anew.
                    {"Cache-Control", "private, no-cache"}};
  answer.body = std::move(found.text) + ",\"links\":" + json_text(links) + "}\n";
  return answer;
}

Answer items(const Call& call) {
  const auto known = call.context.backend->questions.collection(call.arguments[0]);
  if (!known) return problem(known.error());
  Question question{.about = About::features, .triangulation = known.value().triangulation, .stop = call.request.stop};
  for (const auto& [key, value] : call.request.target.query) question.options.emplace(key, value);
  question.options["kind"] = known.value().kind;
  Reply<QuestionAnswer> found = call.context.backend->questions.ask(question);
  if (!found) return problem(found.error());
  const std::string self = collection_path(known.value().id);
  const auto page = [&](std::optional<std::uint64_t> after) {
    std::string query;
    for (const auto& [key, value] : call.request.target.query)
      if (key != "after" || !after) query += (query.empty() ? "?" : "&") + key + "=" + encode_segment(value);
    if (after) query += (query.empty() ? "?" : "&") + std::string("after=") + std::to_string(*after);
    return self + "/items" + query;
  };
  ordered_json links{link(call, page({}), "self", geojson), link(call, self, "collection", json)};
  if (found.value().next) links.push_back(link(call, page(found.value().next), "next", geojson));
  return with_links(call, std::move(found).value(), std::move(links));
}

std::string asked_crs(const Call& call) {
  const auto crs = call.request.target.parameter("crs");
  return crs ? "?crs=" + encode_segment(*crs) : "";
}

Answer item(const Call& call) {
  const auto known = call.context.backend->questions.collection(call.arguments[0]);
  if (!known) return problem(known.error());
  Question question{.about = About::features, .triangulation = known.value().triangulation, .stop = call.request.stop};
  question.options = {{"kind", known.value().kind}, {"item", call.arguments[1]}};
  if (const auto crs = call.request.target.parameter("crs")) question.options["crs"] = *crs;
  Reply<QuestionAnswer> found = call.context.backend->questions.ask(question);
  if (!found) return problem(found.error());
  if (found.value().text.empty())
    return problem(404, "collection '" + known.value().id + "' has no feature " + call.arguments[1], 2);
  const std::string self = collection_path(known.value().id);
  return with_links(
      call, std::move(found).value(),
      {link(call, self + "/items/" + encode_segment(call.arguments[1]) + asked_crs(call), "self", geojson),
       link(call, self, "collection", json)});
}

ordered_json tileset(const Call& call, const std::string& name, const std::array<double, 4>& extent) {
  const std::string self = map_path(name);
  // As in the standard, clients replace the parts in braces.
  ordered_json places = link(call, self + "/0/0/0", "item", png, "A tile");
  std::string href = places["href"];
  href.replace(href.size() - 5, 5, "{tileMatrix}/{tileRow}/{tileCol}");
  places["href"] = href;
  places["templated"] = true;
  return {{"title", name},
          {"dataType", "map"},
          {"crs", "http://www.opengis.net/def/crs/EPSG/0/3857"},
          {"tileMatrixSetURI", matrix_set},
          {"boundingBox",
           {{"lowerLeft", {extent[0], extent[1]}}, {"upperRight", {extent[2], extent[3]}}, {"crs", crs84_uri}}},
          {"links", {link(call, self, "self", json), std::move(places)}}};
}

Answer map_tilesets(const Call& call) {
  const auto extent = call.context.backend->questions.map_extent(call.arguments[0]);
  if (!extent) return problem(extent.error());
  const ordered_json list{{"tilesets", {tileset(call, call.arguments[0], extent.value())}},
                          {"links", {link(call, triangulation_path(call.arguments[0]) + "/map/tiles", "self", json)}}};
  return json_answer(200, json_text(list));
}

Answer map_tileset(const Call& call) {
  const auto extent = call.context.backend->questions.map_extent(call.arguments[0]);
  if (!extent) return problem(extent.error());
  return json_answer(200, json_text(tileset(call, call.arguments[0], extent.value())));
}

// A number of a tile. Maps are small enough that all numbers have few digits.
bool is_number(const std::string& text) {
  return !text.empty() && text.size() < 9 && text.find_first_not_of("0123456789") == std::string::npos;
}

Answer map_tile(const Call& call) {
  const auto extent = call.context.backend->questions.map_extent(call.arguments[0]);
  if (!extent) return problem(extent.error());
  const auto &level = call.arguments[1], &row = call.arguments[2], &column = call.arguments[3];
  const bool numbers = is_number(level) && is_number(row) && is_number(column);
  if (!numbers || std::stoul(level) >= 25 || std::stoul(row) >> std::stoul(level) != 0 ||
      std::stoul(column) >> std::stoul(level) != 0)
    return problem(404, "the map has no tile " + level + "/" + row + "/" + column, 2);
  Question question{.about = About::map_tile, .triangulation = call.arguments[0], .stop = call.request.stop};
  question.options = {{"level", level}, {"row", row}, {"column", column}};
  if (const auto style = call.request.target.parameter("style")) question.options["style"] = *style;
  Reply<QuestionAnswer> found = call.context.backend->questions.ask(question);
  if (!found) return problem(found.error());
  Answer answer;
  // The raster may be drawn anew.
  answer.headers = {{"Content-Type", png},
                    {"Tessera-Final", found.value().final ? "true" : "false"},
                    {"Cache-Control", "private, max-age=60"}};
  answer.body = std::move(found.value().text);
  return answer;
}

Route route(std::string path, const char* name, const char* summary, std::vector<Response> responses, Handler handler,
            std::vector<Parameter> query = {}) {
  return {"GET",   std::move(path),      Role::read,         name,
          summary, std::move(responses), std::move(handler), std::move(query)};
}

}  // namespace

void add_map_routes(std::vector<Route>& routes) {
  const Parameter crs{"crs", "string",
                      "The URI of the coordinate system of the answer, one of the collection's; default: CRS84"};
  const std::string of_collection = "/v1/collections/{collection}";
  const std::string tiles = "/v1/triangulations/{triangulation}/map/tiles";
  routes.push_back(route("/v1/collections", "listCollections", "The collections of features, for maps",
                         {{200, json, "Collections", "The collections"}}, collections));
  routes.push_back(route(of_collection, "getCollection",
                         "A collection: the areas of the tiles, the hull or the contour lines of a result",
                         {{200, json, "Collection", "The collection"}}, collection));
  Route all = route(
      of_collection + "/items", "getFeatures",
      "The features of a collection, in longitude and latitude or in the coordinates of the result",
      {{200, geojson, "FeatureCollection", "A page of features; it has a link `next` when there are more"}}, items,
      {{"bbox", "string", "west,south,east,north: only features that meet it"},
       {"bbox-crs", "string", "The URI of the coordinate system of bbox; default: CRS84"},
       crs,
       {"limit", "integer", "How many features a page has at most, up to 10000; default: 10"},
       {"after", "integer", "The id of the last feature of the page before"},
       {"datetime", "string", "Has no effect: the features have no time"}});
  all.runs = Runs::questions;
  routes.push_back(std::move(all));
  Route one = route(of_collection + "/items/{item}", "getFeature", "A feature",
                    {{200, geojson, "Feature", "The feature"}}, item, {crs});
  one.runs = Runs::questions;
  routes.push_back(std::move(one));
  routes.push_back(route(tiles, "listMapTilesets", "The map of a 2D result, made of its raster dem.tif",
                         {{200, json, "TileSets", "The sets of tiles of the map, of which there is one"}},
                         map_tilesets));
  routes.push_back(route(tiles + "/WebMercatorQuad", "getMapTileset", "The tiles of the map of a 2D result",
                         {{200, json, "TileSet", "The extent of the map, and links to its tiles"}}, map_tileset));
  Route tile = route(tiles + "/WebMercatorQuad/{tileMatrix}/{tileRow}/{tileCol}", "getMapTile",
                     "A tile of the map of a 2D result",
                     {{200, png, "", "256 x 256 pixels, transparent where there are no heights"}}, map_tile,
                     {{"style", "string", "hillshade (default), or terrain-rgb: the heights as colours"}});
  tile.runs = Runs::questions;
  routes.push_back(std::move(tile));
}

}  // namespace tessera::service::http
