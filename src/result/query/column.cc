#include "src/result/query/column.h"

namespace tessera::query {

Result<Column> find_column(const std::filesystem::path& out, const Manifest& manifest, const std::string& name) {
  if (const auto column = column_of(manifest.schema, name)) return *column;
  std::string names;
  for (const auto& attribute : manifest.schema) {
    names += (names.empty() ? "" : ", ") + attribute.name;
  }
  if (name == "z" && names.empty()) return error(Errc::usage, out.string() + ": its vertices have no heights");
  return error(Errc::usage, out.string() + ": its vertices have no attribute '" + name + "'; they have " +
                                (names.empty() ? "none" : names));
}

}  // namespace tessera::query
