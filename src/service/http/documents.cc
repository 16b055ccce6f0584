#include "src/service/http/documents.h"

namespace tessera::service::http {
namespace {

using nlohmann::ordered_json;

// OGC API - Features and Tiles.
void add_maps(ordered_json& schemas) {
  const ordered_json links{{"type", "array"}, {"items", reference("MapLink")}};
  const ordered_json text{{"type", "string"}}, object{{"type", "object"}};
  const ordered_json count{{"type", "integer"}, {"minimum", 0}};
  const auto list_of = [](const ordered_json& items) { return ordered_json{{"type", "array"}, {"items", items}}; };
  schemas["MapLink"] = {
      {"type", "object"},
      {"required", {"href", "rel"}},
      {"properties",
       {{"href", text}, {"rel", text}, {"type", text}, {"title", text}, {"templated", {{"type", "boolean"}}}}}};
  schemas["Collection"] = {{"type", "object"},
                           {"required", {"id", "links", "extent"}},
                           {"properties",
                            {{"id", text},
                             {"title", text},
                             {"description", text},
                             {"itemType", text},
                             {"extent", object},
                             {"crs", list_of(text)},
                             {"storageCrs", text},
                             {"links", links}}}};
  schemas["Collections"] = {{"type", "object"},
                            {"required", {"collections", "links"}},
                            {"properties", {{"collections", list_of(reference("Collection"))}, {"links", links}}}};
  const ordered_json identity{{"oneOf", {text, {{"type", "integer"}}}}};
  schemas["Feature"] = {{"type", "object"},
                        {"required", {"type", "id", "geometry", "properties"}},
                        {"properties",
                         {{"type", {{"type", "string"}, {"enum", {"Feature"}}}},
                          {"id", identity},
                          {"geometry",
                           {{"type", "object"},
                            {"required", {"type", "coordinates"}},
                            {"properties",
                             {{"type", {{"type", "string"}, {"enum", {"Polygon", "LineString"}}}},
                              {"coordinates", {{"type", "array"}}}}}}},
                          {"properties", object},
                          {"links", links}}}};
  schemas["Feature"]["properties"]["geometry"]["properties"]["coordinates"]["items"] = {
      {"type", "array"}, {"items", ordered_json::object()}};
  schemas["FeatureCollection"] = {{"type", "object"},
                                  {"required", {"type", "features", "numberReturned", "links"}},
                                  {"properties",
                                   {{"type", {{"type", "string"}, {"enum", {"FeatureCollection"}}}},
                                    {"features", list_of(reference("Feature"))},
                                    {"numberMatched", count},
                                    {"numberReturned", count},
                                    {"links", links}}}};
  schemas["TileSet"] = {{"type", "object"},
                        {"required", {"dataType", "crs", "links"}},
                        {"properties",
                         {{"title", text},
                          {"dataType", text},
                          {"crs", text},
                          {"tileMatrixSetURI", text},
                          {"boundingBox", object},
                          {"links", links}}}};
  schemas["TileSets"] = {{"type", "object"},
                         {"required", {"tilesets"}},
                         {"properties", {{"tilesets", list_of(reference("TileSet"))}, {"links", links}}}};
}

}  // namespace

ordered_json reference(const std::string& schema) { return {{"$ref", "#/components/schemas/" + schema}}; }

void add_documents(ordered_json& schemas) {
  const ordered_json links{{"type", "array"}, {"items", reference("Link")}};
  const ordered_json text{{"type", "string"}};
  const ordered_json list_of_text{{"type", "array"}, {"items", text}};
  schemas["LandingPage"] = {{"type", "object"},
                            {"required", {"title", "links"}},
                            {"properties", {{"title", text}, {"description", text}, {"links", links}}}};
  schemas["Conformance"] = {
      {"type", "object"}, {"required", {"conformsTo"}}, {"properties", {{"conformsTo", list_of_text}}}};
  schemas["ProcessSummary"] = {{"type", "object"},
                               {"required", {"id", "version", "jobControlOptions", "links"}},
                               {"properties",
                                {{"id", text},
                                 {"title", text},
                                 {"description", text},
                                 {"version", text},
                                 {"jobControlOptions", list_of_text},
                                 {"outputTransmission", list_of_text},
                                 {"links", links}}}};
  schemas["ProcessList"] = {
      {"type", "object"},
      {"required", {"processes", "links"}},
      {"properties", {{"processes", {{"type", "array"}, {"items", reference("ProcessSummary")}}}, {"links", links}}}};
  schemas["Process"] = {{"allOf",
                         {reference("ProcessSummary"),
                          {{"type", "object"},
                           {"required", {"inputs", "outputs"}},
                           {"properties", {{"inputs", {{"type", "object"}}}, {"outputs", {{"type", "object"}}}}}}}}};
  schemas["Results"] = {{"type", "object"}, {"additionalProperties", {{"type", "object"}}}};
  const auto list_of = [](const ordered_json& items) { return ordered_json{{"type", "array"}, {"items", items}}; };
  const ordered_json point = list_of({{"type", "number"}});
  const ordered_json whole{{"type", "integer"}, {"format", "int64"}};
  schemas["Points"] = {{"type", "object"}, {"required", {"points"}}, {"properties", {{"points", list_of(point)}}}};
  schemas["NewPoints"] = {
      {"type", "object"},
      {"required", {"points"}},
      {"additionalProperties", false},
      {"properties",
       {{"points", list_of(point)},
        {"attributes", {{"type", "object"}, {"additionalProperties", list_of({{"type", "number"}})}}}}}};
  schemas["PointIds"] = {{"type", "object"},
                         {"required", {"ids"}},
                         {"additionalProperties", false},
                         {"properties", {{"ids", list_of(whole)}}}};
  schemas["Answers"] = {{"type", "object"},
                        {"required", {"answers"}},
                        {"properties", {{"answers", list_of({{"type", "object"}, {"required", {"point"}}})}}}};
  schemas["Cell"] = {{"type", "object"},
                     {"nullable", true},
                     {"properties", {{"tile", whole}, {"cell", whole}, {"vertices", list_of(whole)}}}};
  schemas["Vertex"] = {{"type", "object"}, {"properties", {{"id", whole}, {"tile", whole}, {"point", point}}}};
  ordered_json nullable = whole;
  nullable["nullable"] = true;
  schemas["Location"] = {{"type", "object"},
                         {"required", {"point", "cell"}},
                         {"properties",
                          {{"point", point},
                           {"tile", whole},
                           {"cell", nullable},
                           {"vertices", list_of(reference("Vertex"))},
                           {"neighbors", list_of(reference("Cell"))}}}};
  schemas["Star"] = {{"type", "object"},
                     {"required", {"asked", "vertex", "voronoi_volume", "on_hull", "neighbors", "cells"}},
                     {"properties",
                      {{"asked", whole},
                       {"vertex", reference("Vertex")},
                       {"voronoi_volume", {{"type", "number"}, {"nullable", true}}},
                       {"on_hull", {{"type", "boolean"}}},
                       {"neighbors", list_of(reference("Vertex"))},
                       {"cells", list_of(reference("Cell"))}}}};
  schemas["Neighbours"] = {
      {"type", "object"},
      {"required", {"asked", "vertex", "on_hull", "neighbors"}},
      {"properties",
       {{"asked", whole}, {"vertex", whole}, {"on_hull", {{"type", "boolean"}}}, {"neighbors", list_of(whole)}}}};
  schemas["Profile"] = {
      {"type", "object"},
      {"required", {"points"}},
      {"properties", {{"points", list_of({{"type", "object"}, {"required", {"distance", "x", "y", "part"}}})}}}};
  schemas["Document"] = {{"type", "object"}};
  schemas["JsonExecute"] = {{"type", "object"},
                            {"required", {"inputs"}},
                            {"additionalProperties", false},
                            {"properties",
                             {{"inputs", {{"type", "object"}}},
                              {"outputs", {{"type", "object"}}},
                              {"response", {{"type", "string"}, {"enum", {"document"}}}}}}};
  add_maps(schemas);
}

}  // namespace tessera::service::http
