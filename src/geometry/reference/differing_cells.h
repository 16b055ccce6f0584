// What two sorted lists of cells do not share, as a text: "" when they are equal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>
#include <vector>

namespace tessera {

// `text_of` gives the text of one cell. Only a few cells of each kind are named.
template <class Cell, class TextOf>
std::string differing_cells(const std::vector<Cell>& expected, const std::vector<Cell>& got, const TextOf& text_of) {
  std::vector<Cell> missing, extra;
  std::set_difference(expected.begin(), expected.end(), got.begin(), got.end(), std::back_inserter(missing));
  std::set_difference(got.begin(), got.end(), expected.begin(), expected.end(), std::back_inserter(extra));
  std::string out;
  const auto tell = [&](const char* what, const std::vector<Cell>& cells) {
    if (cells.empty()) return;
    out += (out.empty() ? "" : "; ") + std::string(what) + " " + std::to_string(cells.size()) + ":";
    for (std::size_t i = 0; i < cells.size() && i < 5; ++i) out += " " + text_of(cells[i]);
  };
  tell("missing", missing);
  tell("extra", extra);
  return out;
}

}  // namespace tessera
