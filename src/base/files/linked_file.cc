#include "src/base/files/linked_file.h"

#include <unistd.h>

#include "src/base/files/whole_file.h"

namespace tessera {

Status link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to) {
  BOOST_OUTCOME_TRYV(remove_file(to));
  if (::link(from.c_str(), to.c_str()) == 0) return success();
  BOOST_OUTCOME_TRY(bytes, read_whole(from));
  return write_whole(to, bytes);
}

}  // namespace tessera
