#include "src/result/query/neighbours.h"

#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"

namespace tessera::query {

std::string text_of(const Neighbours& found, bool part) {
  std::string text;
  if (found.asked != found.vertex)
    text = "point " + to_string(found.asked) + " of the input is equal to vertex " + to_string(found.vertex) + "\n";
  text += "vertex " + to_string(found.vertex) + (found.on_hull ? ", on the hull, has " : " has ") +
          std::to_string(found.ids.size()) + " neighbours:";
  for (const PointId id : found.ids) text += " " + to_string(id);
  text += "\n";
  if (part && !found.final) text += "  not final: the whole triangulation may differ here\n";
  return text;
}

std::string json_of(const Neighbours& found, bool part) {
  nlohmann::ordered_json object{
      {"asked", found.asked.value}, {"vertex", found.vertex.value}, {"on_hull", found.on_hull}};
  auto& list = object["neighbors"] = nlohmann::ordered_json::array();
  for (const PointId id : found.ids) list.push_back(id.value);
  if (part) object["final"] = found.final;
  return json_text(object) + "\n";
}

}  // namespace tessera::query
