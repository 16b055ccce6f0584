#include "src/query/column.h"

namespace tessera::query {

Result<Column> find_column(const std::filesystem::path& out, const Manifest& manifest, const std::string& name) {
  Column column;
  std::string names;
  for (const auto& attribute : manifest.schema) {
    column.type = attribute.type;
    if (attribute.name == name) return column;
    column.offset += size_of(attribute.type);
    names += (names.empty() ? "" : ", ") + attribute.name;
  }
  if (name == "z" && names.empty()) return error(Errc::usage, out.string() + ": its vertices have no heights");
  return error(Errc::usage, out.string() + ": its vertices have no attribute '" + name + "'; they have " +
                                (names.empty() ? "none" : names));
}

}  // namespace tessera::query
