// The dashboard's files, as they were built into the program.
#pragma once

#include <span>
#include <string_view>

namespace tessera {

struct WebFile {
  std::string_view name;  // "app.js"
  std::string_view type;  // media type
  std::string_view etag;  // strong, quoted: a hash of the bytes
  std::string_view bytes;
};

std::span<const WebFile> web_files();

}  // namespace tessera
