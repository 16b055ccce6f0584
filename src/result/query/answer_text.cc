#include "src/result/query/answer_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"
#include "src/result/query/answers.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* not_final = "  not final: the whole triangulation may differ here\n";

std::string text_of(const Point& p, int dimension) {
  std::string text;
  for (int axis = 0; axis < dimension; ++axis) {
    if (axis > 0) text += ' ';
    add_number(text, p[axis]);
  }
  return text;
}

std::string vertices_of(const query::Cell& cell, int dimension) {
  std::string text;
  for (int k = 0; k <= dimension; ++k)
    text += (k > 0 ? " " : "") + to_string(cell.vertices[static_cast<std::size_t>(k)]);
  return text;
}

std::string name_of(const query::Cell& cell, int dimension) {
  return "cell " + std::to_string(cell.cell) + " of tile " + to_string(cell.tile) + " (" +
         vertices_of(cell, dimension) + ")";
}

Json json_of(const Point& p, int dimension) {
  Json list = Json::array();
  for (int axis = 0; axis < dimension; ++axis) list.push_back(p[axis]);
  return list;
}

Json json_of(const query::Vertex& vertex, int dimension) {
  Json object{{"id", vertex.id.value}, {"tile", vertex.owner.value}, {"point", json_of(vertex.at, dimension)}};
  if (vertex.offset == PeriodOffset{}) return object;
  Json& offset = object["offset"] = Json::array();
  for (int axis = 0; axis < dimension; ++axis) offset.push_back(vertex.offset.by[static_cast<std::size_t>(axis)]);
  return object;
}

Json json_of(const query::Cell& cell, int dimension) {
  if (!cell) return cell.final ? Json(nullptr) : Json{{"final", false}};
  Json vertices = Json::array();
  for (int k = 0; k <= dimension; ++k) vertices.push_back(cell.vertices[static_cast<std::size_t>(k)].value);
  Json object{{"tile", cell.tile.value}, {"cell", cell.cell}, {"vertices", vertices}};
  if (!cell.final) object["final"] = false;
  return object;
}

template <class List>
Json json_of(const List& list, int dimension) {
  Json all = Json::array();
  for (const auto& one : list) all.push_back(json_of(one, dimension));
  return all;
}

}  // namespace

std::string text_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                    std::optional<bool> final) {
  if (!details)
    return text_of(p, dimension) +
           (final.value_or(true) ? " is outside the hull\n" : " is in no cell of this region\n");
  std::string text = "cell " + std::to_string(details->cell.cell) + " of tile " + to_string(details->cell.tile) + "\n";
  for (const auto& vertex : details->vertices)
    text += "  vertex " + to_string(vertex.id) + " of tile " + to_string(vertex.owner) + " at " +
            text_of(vertex.at, dimension) + "\n";
  for (std::size_t k = 0; k < details->neighbors.size(); ++k)
    text += "  opposite vertex " + to_string(details->vertices[k].id) + ": " +
            (details->neighbors[k]         ? name_of(details->neighbors[k], dimension)
             : details->neighbors[k].final ? "the outside"
                                           : "unknown") +
            "\n";
  return text + (final.value_or(true) ? "" : not_final);
}

std::string json_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                    std::optional<bool> final) {
  Json object{{"point", json_of(p, dimension)}};
  if (details) {
    object["tile"] = details->cell.tile.value;
    object["cell"] = details->cell.cell;
    object["vertices"] = json_of(details->vertices, dimension);
    object["neighbors"] = json_of(details->neighbors, dimension);
  } else {
    object["cell"] = nullptr;
  }
  if (final) object["final"] = *final;
  return json_text(object) + "\n";
}

std::string text_of(PointId asked, int dimension, const query::Star& star, bool part) {
  std::string text;
  if (asked != star.vertex.id)
    text = "point " + to_string(asked) + " of the input is equal to vertex " + to_string(star.vertex.id) + "\n";
  text += "vertex " + to_string(star.vertex.id) + " of tile " + to_string(star.vertex.owner) + " at " +
          text_of(star.vertex.at, dimension) + "\n  Voronoi " + (dimension == 3 ? "volume " : "area ");
  if (std::isinf(star.voronoi_volume)) {
    text += "unbounded: it is on the hull";
  } else if (std::isnan(star.voronoi_volume)) {
    text += star.final ? "unknown: a cell around it has no volume" : "unknown: not all cells around it are here";
  } else {
    add_number(text, star.voronoi_volume);
  }
  text += "\n  " + std::to_string(star.neighbors.size()) + " neighbours:";
  for (const auto& neighbor : star.neighbors) text += " " + to_string(neighbor.id);
  text += "\n  " + std::to_string(star.cells.size()) + " cells:\n";
  for (const auto& cell : star.cells) text += "    " + name_of(cell, dimension) + "\n";
  return text + (part && !star.final ? not_final : "");
}

std::string json_of(PointId asked, int dimension, const query::Star& star, bool part) {
  Json object{{"asked", asked.value}, {"vertex", json_of(star.vertex, dimension)}};
  object["voronoi_volume"] = std::isfinite(star.voronoi_volume) ? Json(star.voronoi_volume) : Json(nullptr);
  object["on_hull"] = std::isinf(star.voronoi_volume);
  object["neighbors"] = json_of(star.neighbors, dimension);
  object["cells"] = json_of(star.cells, dimension);
  if (part) object["final"] = star.final;
  return json_text(object) + "\n";
}

}  // namespace tessera
