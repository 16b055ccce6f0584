#include "src/input/column_names.h"

#include <array>
#include <optional>
#include <unordered_set>

#include "src/base/option.h"
#include "src/base/printable.h"

namespace tessera {
namespace {

constexpr std::size_t names_max = 4096;

// Returns 0 for x, 1 for y, 2 for z. Nothing for other names.
std::optional<std::size_t> axis_of(const std::string& name) {
  const std::size_t letter = name.size() == 1 ? std::string_view("xyzXYZ").find(name[0]) : std::string_view::npos;
  return letter == std::string_view::npos ? std::nullopt : std::optional(letter % 3);
}

}  // namespace

Status check_columns(std::span<const std::string> names) {
  const auto refuse = [](const std::string& reason) { return error(Errc::usage, reason); };
  if (names.empty()) return success();
  if (names.size() > names_max) return refuse("there are more than " + std::to_string(names_max) + " names");
  std::array<bool, 3> found{};
  std::unordered_set<std::string_view> others;
  for (const std::string& name : names) {
    if (name.empty()) return refuse(std::string("a name is empty; ") + unnamed_column + " leaves a column out");
    if (name == unnamed_column) continue;
    const auto axis = axis_of(name);
    if (axis ? found[*axis] : !others.insert(name).second) return refuse(in_quotes(name) + " is there twice");
    if (axis) found[*axis] = true;
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (!found[axis]) return refuse(std::string("no column is called ") + "xy"[axis]);
  }
  return success();
}

ColumnNames find_columns(std::span<const std::string> names) {
  std::array<std::optional<std::size_t>, 3> at;
  ColumnNames found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == unnamed_column) continue;
    found.end = i + 1;
    if (const auto axis = axis_of(names[i]))
      at[*axis] = i;
    else
      found.others.push_back(i);
  }
  for (const auto& column : at)
    if (column) found.coordinates.push_back(*column);
  return found;
}

std::string too_few_columns(std::size_t there, const ColumnNames& names) {
  if (there >= names.end) return "";
  return "has " + std::to_string(there) + (there == 1 ? " column" : " columns") + ", but " + option("columns") +
         " names " + std::to_string(names.end);
}

}  // namespace tessera
