#include "src/input/column_names.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
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

// The keys that together make a point, each list in the order of named_columns().
constexpr std::array<std::array<std::string_view, 3>, 5> key_sets{
    {{"x", "y", ""}, {"x", "y", "z"}, {"position", "", ""}, {"ra", "dec", "distance"}, {"ra", "dec", "redshift"}}};

std::size_t size_of_set(const std::array<std::string_view, 3>& keys) {
  return static_cast<std::size_t>(std::count_if(keys.begin(), keys.end(), [](auto key) { return !key.empty(); }));
}

std::pair<std::string, std::string> parts_of(const std::string& entry) {
  const std::size_t sign = entry.find('=');
  if (sign == std::string::npos) return {entry, ""};
  return {entry.substr(0, sign), entry.substr(sign + 1)};
}

// The keys of these entries; null if they make no point.
const std::array<std::string_view, 3>* keys_of(std::span<const std::string> entries) {
  for (const auto& keys : key_sets) {
    const bool all = std::all_of(keys.begin(), keys.end(), [&](std::string_view key) {
      return key.empty() ||
             std::any_of(entries.begin(), entries.end(), [&](auto& e) { return parts_of(e).first == key; });
    });
    if (all && size_of_set(keys) == entries.size()) return &keys;
  }
  return nullptr;
}

Status check_entries(std::span<const std::string> entries) {
  for (const std::string& entry : entries)
    if (parts_of(entry).second.empty()) return error(Errc::usage, in_quotes(entry) + " is not KEY=COLUMN, as x=XPOS");
  if (keys_of(entries) != nullptr) return success();
  return error(Errc::usage,
               "the keys must be x,y or x,y,z, or position, or ra,dec,distance, or ra,dec,redshift, as in "
               "x=XPOS,y=YPOS,z=ZPOS");
}

}  // namespace

bool are_entries(std::span<const std::string> names) {
  return std::any_of(names.begin(), names.end(), [](auto& name) { return name.find('=') != std::string::npos; });
}

std::vector<std::pair<std::string, std::string>> named_columns(std::span<const std::string> entries) {
  std::vector<std::pair<std::string, std::string>> columns;
  for (const auto key : *keys_of(entries))
    for (const std::string& entry : entries)
      if (auto parts = parts_of(entry); parts.first == key) columns.push_back(std::move(parts));
  return columns;
}

Status check_columns(std::span<const std::string> names) {
  const auto refuse = [](const std::string& reason) { return error(Errc::usage, reason); };
  if (names.empty()) return success();
  if (are_entries(names)) return check_entries(names);
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
